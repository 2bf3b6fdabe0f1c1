# SPDX-License-Identifier: Apache-2.0
"""Checkpoints: a shot's history, films and progress on disk, exact and proven before use."""
