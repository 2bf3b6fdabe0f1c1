# SPDX-License-Identifier: Apache-2.0
"""Shots split over hosts: cells, partial frames and their merging, jobs for schedulers."""
