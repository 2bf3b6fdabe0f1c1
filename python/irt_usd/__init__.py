# SPDX-License-Identifier: Apache-2.0
"""irt: an exact incremental ray tracer for animation, fed by USD stages."""
