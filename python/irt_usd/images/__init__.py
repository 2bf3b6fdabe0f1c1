# SPDX-License-Identifier: Apache-2.0
"""Image files: EXR frames and contact sheets, written whole or not at all."""
