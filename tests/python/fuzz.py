# SPDX-License-Identifier: Apache-2.0
"""Random sequences of edits without end: `python fuzz.py [--seconds N] [--first SEED]`.

Prints how many passed. A sequence that fails is printed, made as short as leaving out edits makes
it, in a form that Python reads; `edits.play` plays it again. Exits with 1 then.
"""

import argparse
import sys
import time
import traceback
from dataclasses import replace

import edits


def fails(shot: edits.Shot) -> bool:
    try:
        edits.play(shot)
    except (AssertionError, RuntimeError):
        return True
    return False


def shortened(shot: edits.Shot) -> edits.Shot:
    """A failing shot without the frames and edits that its failure does not need."""
    while True:
        frames = shot.frames
        shorter = [replace(shot, frames=frames[:f] + frames[f + 1 :]) for f in range(len(frames))]
        shorter += [
            replace(shot, frames=[*frames[:f], frame[:e] + frame[e + 1 :], *frames[f + 1 :]])
            for f, frame in enumerate(frames)
            for e in range(len(frame))
        ]
        failing = next(filter(fails, shorter), None)
        if failing is None:
            return shot
        shot = failing


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="stop after so many")
    parser.add_argument("--first", type=int, default=time.time_ns() // 10**9, help="first seed")
    arguments = parser.parse_args()
    start = last = time.monotonic()
    seed = arguments.first
    passed = frames = 0
    while (now := time.monotonic()) - start < arguments.seconds:
        if now - last > 60:
            last = now
            print(f"{passed} sequences, {frames} frames passed", flush=True)
        shot = edits.seeded_shot(seed)
        try:
            frames += len(edits.play(shot))
        except (AssertionError, RuntimeError):
            traceback.print_exc()
            print(f"seed {seed}, shortened:\n{shortened(shot)!r}", flush=True)
            return 1
        passed += 1
        seed += 1
    print(
        f"{passed} sequences, {frames} frames passed in {time.monotonic() - start:.0f} s,"
        f" seeds {arguments.first} to {seed - 1}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
