# SPDX-License-Identifier: Apache-2.0
"""Plays shots on the core's test build: `python mutant_worker.py SHOTS`.

First those made for the faults of cpp/irt/mutant.h, then as many random ones. Prints the first that
a fault shows in, and how; nothing where none does.
"""

import sys

import core_of_test_build  # noqa: F401  first
import edits
import mutant_shots


def main(count: int) -> None:
    shots = {f"shot '{name}'": shot for name, shot in mutant_shots.SHOTS.items()}
    shots |= {f"random shot {seed}": edits.seeded_shot(seed) for seed in range(count)}
    for name, shot in shots.items():
        try:
            edits.play(shot)
        except (AssertionError, RuntimeError) as error:
            print(f"{name}: {str(error).splitlines()[0]}")
            return


if __name__ == "__main__":
    main(int(sys.argv[1]))
