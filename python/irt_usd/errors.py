# SPDX-License-Identifier: Apache-2.0
"""The errors that end a command: one message each, and the exit status that goes with it."""

from typing import ClassVar


class IrtError(Exception):
    """A failure whose message is for the user as it stands. `status` is the exit status."""

    status: ClassVar[int] = 1


class InputError(IrtError):
    """Bad usage or bad input; the message names file, prim and attribute, and what to do."""

    status: ClassVar[int] = 2


class MachineError(IrtError):
    """A failure of the machine: a full disk, a file that vanished."""

    status: ClassVar[int] = 1
