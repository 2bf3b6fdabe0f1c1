# SPDX-License-Identifier: Apache-2.0
"""MaterialX's noises, as its GLSL implementation has them (genglsl/lib/mx_noise.glsl)."""

from collections.abc import Callable

from irt_usd.materialx.expressions import Expressions, Value, constant
from irt_usd.materialx.inputs import WIDTHS, Inputs

_WIDTH_2D, _WIDTH_3D = 2, 3
_APART = {_WIDTH_2D: (19.0, 73.0, 0.0), _WIDTH_3D: (19.0, 73.0, 29.0)}
"""Where a fourth number of noise is taken, so that it is none of the first three."""
_FRACTAL_APART = {_WIDTH_2D: (19.0, 193.0, 0.0), _WIDTH_3D: (19.0, 193.0, 17.0)}
_FOURTH = 3


def _place(node: Inputs, width: int) -> Value:
    return node.value("texcoord" if width == _WIDTH_2D else "position")


def _moved(ex: Expressions, place: Value, by: tuple[float, ...]) -> Value:
    return ex.apply("add", place, constant(*by))


def _number(ex: Expressions, place: Value, width: int) -> Value:
    return ex.apply(f"perlin_{width}d", place)


def _vector(ex: Expressions, place: Value, width: int) -> Value:
    return ex.apply(f"perlin_vector_{width}d", place)


def _with_fourth(ex: Expressions, three: Value, fourth: Value) -> Value:
    return ex.combine(*(ex.channel(three, i) for i in range(3)), fourth)


def noise(width: int) -> Callable[[Inputs], Value]:
    """Perlin's, over two or three dimensions."""

    def make(node: Inputs) -> Value:
        ex, place = node.expressions, _place(node, width)
        count = WIDTHS.get(node.type, 1)
        if count == 1:
            value = _number(ex, place, width)
        else:
            value = _vector(ex, place, width)
            if count > _FOURTH:
                apart = _moved(ex, place, _APART[width])
                value = _with_fourth(ex, value, _number(ex, apart, width))
        scaled = ex.apply("multiply", value, node.value("amplitude"))
        return ex.apply("add", scaled, node.value("pivot"))

    return make


def fractal(width: int) -> Callable[[Inputs], Value]:
    """Octaves of Perlin's noise, each `lacunarity` times finer and `diminish` times weaker."""

    def octaves(node: Inputs, place: Value, kind: Callable[..., Value]) -> Value:
        ex = node.expressions
        total, amplitude = constant(0.0), constant(1.0)
        for _ in range(max(0, int(node.read("octaves")))):
            one = ex.apply("multiply", amplitude, kind(ex, place, width))
            total = ex.apply("add", one, total) if total != constant(0.0) else one
            amplitude = ex.apply("multiply", amplitude, node.value("diminish"))
            place = ex.apply("multiply", place, node.value("lacunarity"))
        return total

    def make(node: Inputs) -> Value:
        ex, place = node.expressions, _place(node, width)
        count = WIDTHS.get(node.type, 1)
        value = octaves(node, place, _vector if count > _WIDTH_2D else _number)
        if count in (_WIDTH_2D, 4):
            apart = octaves(node, _moved(ex, place, _FRACTAL_APART[width]), _number)
            value = ex.combine(value, apart) if count < 4 else _with_fourth(ex, value, apart)
        return ex.apply("multiply", value, node.value("amplitude"))

    return make


def cells(width: int) -> Callable[[Inputs], Value]:
    """A random number for each cell."""
    return lambda node: node.expressions.apply(f"cells_{width}d", _place(node, width))


def worley(width: int) -> Callable[[Inputs], Value]:
    """Distances to random points, or with style 1 random numbers of the nearest."""

    def make(node: Inputs) -> Value:
        ex, single = node.expressions, node.type not in WIDTHS
        solid = int(node.read("style")) == 1
        kind = f"worley_cells_{width}d" if solid else f"worley_{width}d"
        value = ex.apply(kind, _place(node, width), node.value("jitter"))
        return ex.channel(value, _FOURTH if solid else 0) if single else value

    return make


NOISES: dict[str, Callable[[Inputs], Value]] = {
    "noise2d": noise(2),
    "noise3d": noise(3),
    "fractal2d": fractal(2),
    "fractal3d": fractal(3),
    "cellnoise2d": cells(2),
    "cellnoise3d": cells(3),
    "worleynoise2d": worley(2),
    "worleynoise3d": worley(3),
}
