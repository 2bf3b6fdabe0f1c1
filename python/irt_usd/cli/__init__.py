# SPDX-License-Identifier: Apache-2.0
"""The `irt` program: one file a command.

Commands import what they need when they run, so that `irt --help` is quick.
"""
