# SPDX-License-Identifier: Apache-2.0
"""Measurements of speed: what `irt bench` runs."""
