# SPDX-License-Identifier: Apache-2.0
"""The paper's tables 1 to 5, measured here: what `irt bench paper` runs."""
