# SPDX-License-Identifier: Apache-2.0
"""MaterialX's noises written down a second time, from its mx_noise.glsl, function by function."""

import math
from itertools import product
from typing import Any

_MASK = 0xFFFFFFFF
Point = tuple[float, ...]


def _rotl(x: int, k: int) -> int:
    return (x << k | x >> (32 - k)) & _MASK


def _bjmix(a: int, b: int, c: int) -> tuple[int, int, int]:
    for k, swap in ((4, 0), (6, 1), (8, 2), (16, 0), (19, 1), (4, 2)):
        if swap == 0:
            a = (a - c & _MASK) ^ _rotl(c, k)
            c = c + b & _MASK
        elif swap == 1:
            b = (b - a & _MASK) ^ _rotl(a, k)
            a = a + c & _MASK
        else:
            c = (c - b & _MASK) ^ _rotl(b, k)
            b = b + a & _MASK
    return a, b, c


def _bjfinal(a: int, b: int, c: int) -> int:
    c = (c ^ b) - _rotl(b, 14) & _MASK
    a = (a ^ c) - _rotl(c, 11) & _MASK
    b = (b ^ a) - _rotl(a, 25) & _MASK
    c = (c ^ b) - _rotl(b, 16) & _MASK
    a = (a ^ c) - _rotl(c, 4) & _MASK
    b = (b ^ a) - _rotl(a, 14) & _MASK
    return (c ^ b) - _rotl(b, 24) & _MASK


def hash_int(*key: int) -> int:
    seed = 0xDEADBEEF + (len(key) << 2) + 13
    first = [*key[:3], 0, 0][:3]
    a, b, c = (seed + value & _MASK for value in first)
    if len(key) > 3:
        a, b, c = _bjmix(a, b, c)
        a = a + key[3] & _MASK
    return _bjfinal(a, b, c)


def _gradient(bits: int, p: Point) -> float:
    if len(p) == 2:
        h = bits & 7
        u, v = (p[0], 2 * p[1]) if h < 4 else (p[1], 2 * p[0])
    else:
        h = bits & 15
        u = p[0] if h < 8 else p[1]
        v = p[1] if h < 4 else (p[0] if h in (12, 14) else p[2])
    return (-u if h & 1 else u) + (-v if h & 2 else v)


def _perlin(p: Point, shift: int, mask: int) -> float:
    cell = [math.floor(x) for x in p]
    rest = [x - i for x, i in zip(p, cell, strict=True)]
    fades = [t * t * t * (t * (t * 6 - 15) + 10) for t in rest]
    total = 0.0
    for corner in product((0, 1), repeat=len(p)):
        weight = math.prod(f if k else 1 - f for f, k in zip(fades, corner, strict=True))
        bits = hash_int(*(i + k for i, k in zip(cell, corner, strict=True)))
        offset = tuple(t - k for t, k in zip(rest, corner, strict=True))
        total += weight * _gradient(bits >> shift & mask, offset)
    return total * (0.6616 if len(p) == 2 else 0.9820)


def perlin(p: Point) -> tuple[float, ...]:
    return (_perlin(p, 0, _MASK),) * 3


def perlin_vector(p: Point) -> tuple[float, ...]:
    return tuple(_perlin(p, shift, 0xFF) for shift in (0, 8, 16))


def cells(p: Point) -> tuple[float, ...]:
    return (hash_int(*map(math.floor, p)) / _MASK,) * 3


def _random(cell: Any) -> tuple[float, ...]:
    return tuple(hash_int(*cell, i) / _MASK for i in range(3))


def _nearest(p: Point, jitter: float) -> list[tuple[float, Point]]:
    found = []
    home = [math.floor(x) for x in p]
    for step in product((-1, 0, 1), repeat=len(p)):
        cell = [i + k for i, k in zip(home, step, strict=True)]
        spot = [i + 0.5 + (r - 0.5) * jitter for i, r in zip(cell, _random(cell), strict=False)]
        found.append((math.dist(spot, p), tuple(spot)))
    return sorted(found)


def worley(p: Point, jitter: float) -> tuple[float, ...]:
    return tuple(distance for distance, _ in _nearest(p, jitter)[:3])


def worley_cells(p: Point, jitter: float) -> tuple[float, ...]:
    return _random([math.floor(x) for x in _nearest(p, jitter)[0][1]])


def worley_cell(p: Point, jitter: float) -> float:
    return cells(_nearest(p, jitter)[0][1])[0]
