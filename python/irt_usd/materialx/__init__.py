# SPDX-License-Identifier: Apache-2.0
"""MaterialX: `.mtlx` files as USD layers, and MaterialX shader networks as shading graphs."""
