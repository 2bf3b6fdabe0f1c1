# SPDX-License-Identifier: Apache-2.0
"""A shot from its stage to its frames: ranges, output names, the frame loop, verification."""
