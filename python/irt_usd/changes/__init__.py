# SPDX-License-Identifier: Apache-2.0
"""What differs between two snapshots, for the user to read and for the core to apply."""

from irt_usd.changes.diff import Change, ChangeList, diff, whole_changes
from irt_usd.changes.invalidation import Invalidates

__all__ = ["Change", "ChangeList", "Invalidates", "diff", "whole_changes"]
