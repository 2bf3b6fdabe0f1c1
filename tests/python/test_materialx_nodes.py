# SPDX-License-Identifier: Apache-2.0
"""MaterialX's nodes as operations of the shading graph, against values computed by hand."""

import math
from pathlib import Path
from typing import Any

import pytest
from pxr import Usd, UsdShade

import mx_noise
from graph_values import surface_value
from irt_usd.materialx.material import MaterialXSource
from irt_usd.report import Report
from irt_usd.stage.color import StageColors
from irt_usd.stage.graph import Surface
from irt_usd.stage.open import open_stage
from materialx_documents import material, mtlx

UV = (0.25, 0.75)
ST = {"st": UV, "position": (0.3, 0.6, 1.2), "normal": (0.0, 0.6, 0.8), "view": (0.0, 0.0, -1.0)}
P = (0.3, 0.6, 1.2)


def translated(
    folder: Path, text: str, report: Report | None = None
) -> tuple[Usd.Stage, MaterialXSource]:
    """The source of material M of a document, and the stage that it reads."""
    (folder / "look.mtlx").write_text(text)
    layer = folder / "look.usda"
    arc = "references = @look.mtlx@</MaterialX/Materials>"
    layer.write_text(f'#usda 1.0\ndef "L" (\n {arc}\n)\n{{\n}}\n')
    stage = open_stage(str(layer))
    found = UsdShade.Material.Get(stage, "/L/M")
    kept = report or Report()
    shader = found.ComputeSurfaceSource("mtlx")[0]
    return stage, MaterialXSource("/L/M", shader, kept, StageColors(stage, kept), None)


def surface(folder: Path, text: str, report: Report | None = None) -> Surface:
    _stage, source = translated(folder, text, report)
    return source.read(Usd.TimeCode(1)).surface


def node(category: str, kind: str, name: str = "n", **inputs: str) -> str:
    """A node whose inputs are "type value", or "type @node" for a connection."""
    parts = []
    for key, text in inputs.items():
        type_, value = text.split(" ", 1)
        if value.startswith("@"):
            source, _, output = value[1:].partition(".")
            named = f' output="{output}"' if output else ""
            parts.append(f'<input name="{key}" type="{type_}" nodename="{source}"{named}/>')
        else:
            parts.append(f'<input name="{key}" type="{type_}" value="{value}"/>')
    return f'<{category} name="{name}" type="{kind}">{"".join(parts)}</{category}>'


def emitted(folder: Path, kind: str, nodes: str, output: str = "") -> Any:
    """What node n gives, by way of an unlit surface; numbers and vectors as colours."""
    named = f' output="{output}"' if output else ""
    wide = f'<input name="in" type="{kind}" nodename="n"{named}/>'
    convert = f'<convert name="c" type="color3">{wide}</convert>' if kind != "color3" else ""
    source = "n" if kind == "color3" else "c"
    own = named if kind == "color3" else ""
    text = mtlx(
        f"""{nodes}{convert}
        <surface_unlit name="S" type="surfaceshader">
          <input name="emission_color" type="color3" nodename="{source}"{own}/>
        </surface_unlit>
        <surfacematerial name="M" type="material">
          <input name="surfaceshader" type="surfaceshader" nodename="S"/>
        </surfacematerial>"""
    )
    value = surface_value(surface(folder, text), "emissiveColor", ST)
    return value[0] if kind in ("float", "integer", "boolean") else value


V = node("combine3", "vector3", "v", in1="float @x", in2="float @y", in3="float 2")
X = node("extract", "float", "x", **{"in": "vector2 @t", "index": "integer 0"})
Y = node("extract", "float", "y", **{"in": "vector2 @t", "index": "integer 1"})
T = '<texcoord name="t" type="vector2"/>'
VARYING = T + X + Y + V


@pytest.mark.parametrize("varying", [False, True], ids=["constant", "varying"])
@pytest.mark.parametrize(
    ("category", "inputs", "expected"),
    [
        ("add", {"in1": "0.25", "in2": "0.5"}, 0.75),
        ("subtract", {"in1": "0.25", "in2": "0.125"}, 0.125),
        ("multiply", {"in1": "0.25", "in2": "0.5"}, 0.125),
        ("divide", {"in1": "0.25", "in2": "0.5"}, 0.5),
        ("modulo", {"in1": "0.25", "in2": "0.1"}, 0.05),
        ("power", {"in1": "0.25", "in2": "2"}, 0.0625),
        ("min", {"in1": "0.25", "in2": "0.125"}, 0.125),
        ("max", {"in1": "0.25", "in2": "0.125"}, 0.25),
        ("absval", {"in": "0.25"}, 0.25),
        ("sign", {"in": "0.25"}, 1.0),
        ("floor", {"in": "0.25"}, 0.0),
        ("ceil", {"in": "0.25"}, 1.0),
        ("sqrt", {"in": "0.25"}, 0.5),
        ("sin", {"in": "0.25"}, math.sin(0.25)),
        ("cos", {"in": "0.25"}, math.cos(0.25)),
        ("tan", {"in": "0.25"}, math.tan(0.25)),
        ("exp", {"in": "0.25"}, math.exp(0.25)),
        ("ln", {"in": "0.25"}, 0.0),
        ("fract", {"in": "0.25"}, 0.25),
        ("invert", {"in": "0.25", "amount": "2"}, 1.75),
        ("clamp", {"in": "0.25", "low": "0.5", "high": "0.75"}, 0.5),
        ("mix", {"mix": "0.25", "fg": "1", "bg": "0.5"}, 0.625),
        ("remap", {"in": "0.25", "inlow": "0", "inhigh": "0.5", "outlow": "1", "outhigh": "3"}, 2),
        ("range", {"in": "0.25", "inhigh": "0.5", "gamma": "2", "outhigh": "4"}, 4 * 0.5**0.5),
        ("smoothstep", {"in": "0.25", "low": "0", "high": "1"}, 0.15625),
        ("contrast", {"in": "0.25", "amount": "2", "pivot": "0.125"}, 0.375),
        ("ifgreater", {"value1": "0.25", "value2": "0.5", "in1": "1", "in2": "2"}, 2.0),
        ("ifgreatereq", {"value1": "0.25", "value2": "0.25", "in1": "1", "in2": "2"}, 1.0),
        ("ifequal", {"value1": "0.25", "value2": "0.25", "in1": "1", "in2": "2"}, 1.0),
        ("plus", {"fg": "0.25", "bg": "0.5"}, 0.75),
        ("minus", {"fg": "0.25", "bg": "0.5"}, 0.25),
        ("difference", {"fg": "0.25", "bg": "0.125"}, 0.125),
        ("screen", {"fg": "0.25", "bg": "0.5"}, 0.625),
        ("overlay", {"fg": "0.25", "bg": "0.75"}, 0.625),
    ],
)
def test_numbers(
    tmp_path: Path, category: str, inputs: dict[str, str], expected: float, varying: bool
) -> None:
    """The first input is 0.25, a constant or the s of the texture coordinates."""
    given = {key: f"float {text}" for key, text in inputs.items()}
    if varying:
        first = next(iter(given))
        given[first] = "float @x"
    found = emitted(tmp_path, "float", VARYING + node(category, "float", **given))
    if category == "ln":
        found, expected = math.exp(found) if found else 0.0, found and 0.25
    assert found == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(
    ("category", "kind", "inputs", "expected"),
    [
        ("normalize", "vector3", {"in": "vector3 @v"},
         tuple(v / math.sqrt(4.625) for v in (0.25, 0.75, 2))),
        ("magnitude", "float", {"in": "vector3 @v"}, math.sqrt(4.625)),
        ("magnitude", "float", {"in": "vector2 @t"}, math.sqrt(0.625)),
        ("dotproduct", "float", {"in1": "vector3 @v", "in2": "vector3 1,2,3"}, 7.75),
        ("dotproduct", "float", {"in1": "vector2 @t", "in2": "vector2 1,2"}, 1.75),
        ("crossproduct", "vector3", {"in1": "vector3 @v", "in2": "vector3 1,0,0"},
         (0, 2, -0.75)),
        ("multiply", "vector3", {"in1": "vector3 @v", "in2": "float 2"}, (0.5, 1.5, 4)),
        ("rotate2d", "vector2", {"in": "vector2 @t", "amount": "float 90"}, (0.75, -0.25, 0)),
        ("ramplr", "color3", {"valuel": "color3 0,1,2", "valuer": "color3 4,1,0"},
         (1, 1, 1.5)),
        ("ramptb", "color3", {"valueb": "color3 0,0,0", "valuet": "color3 4,8,0"}, (3, 6, 0)),
        ("splitlr", "color3", {"valuel": "color3 1,2,3", "valuer": "color3 0,0,0"},
         (1, 2, 3)),
        ("geompropvalue", "vector2", {"geomprop": "string st"}, (0.25, 0.75, 0)),
        ("geompropvalue", "float", {"geomprop": "string no", "default": "float 0.5"}, 0.5),
        ("image", "color3", {"file": "filename a.png"}, (0.25, 0.75, 1.0)),
        ("image", "float", {"file": "filename a.png"}, 0.25),
        ("image", "vector2", {"file": "filename a.png"}, (0.25, 0.75, 0)),
        (
            "tiledimage", "color3",
            {"file": "filename a.png", "uvtiling": "vector2 2,4", "uvoffset": "vector2 0.125,1"},
            (0.375, 2, 2.375),
        ),
        (
            "place2d", "vector2",
            {"texcoord": "vector2 @t", "offset": "vector2 0.25,0.5", "scale": "vector2 0.5,2"},
            (0.25, -0.125, 0),
        ),
        ("switch", "color3", {"in1": "color3 1,1,1", "in2": "color3 2,3,4", "which": "float 1"},
         (2, 3, 4)),
        ("saturate", "color3", {"in": "color3 @k", "amount": "float 0"},
         (0.25 * 0.2722287 + 0.75 * 0.6740818 + 2 * 0.0536895,) * 3),
        ("luminance", "color3", {"in": "color3 @k", "lumacoeffs": "color3 1,2,3"}, (7.75,) * 3),
    ],
)  # fmt: skip
def test_vectors(
    tmp_path: Path, category: str, kind: str, inputs: dict[str, str], expected: Any
) -> None:
    colour = node("convert", "color3", "k", **{"in": "vector3 @v"})
    nodes = VARYING + colour + node(category, kind, **inputs)
    assert emitted(tmp_path, kind, nodes) == pytest.approx(expected, abs=1e-6)


def test_separate_and_combine(tmp_path: Path) -> None:
    apart = node("separate3", "multioutput", "s", **{"in": "vector3 @v"})
    parts = {f"in{i + 1}": f"float @s.{o}" for i, o in enumerate(("outz", "outx", "outy"))}
    together = node("combine3", "vector3", **parts)
    assert emitted(tmp_path, "vector3", VARYING + apart + together) == (2.0, 0.25, 0.75)


def apart(p: tuple[float, ...], *by: float) -> tuple[float, ...]:
    return tuple(a + b for a, b in zip(p, by, strict=False))


def octaves(noise: Any, p: tuple[float, ...], count: int, index: int = 0) -> float:
    """Of lacunarity 2 and diminish 0.5."""
    return float(sum(noise(tuple(2**i * x for x in p))[index] / 2**i for i in range(count)))


PERLIN, VECTOR = mx_noise.perlin, mx_noise.perlin_vector


@pytest.mark.parametrize(
    ("category", "kind", "inputs", "expected"),
    [
        ("noise2d", "float", {"amplitude": "float 2", "pivot": "float 0.5"},
         2 * PERLIN(UV)[0] + 0.5),
        ("noise2d", "vector3", {"amplitude": "vector3 1,2,3"},
         tuple(k * v for k, v in zip((1, 2, 3), VECTOR(UV), strict=True))),
        ("noise3d", "float", {}, PERLIN(P)[0]),
        ("noise3d", "color3", {"amplitude": "float 0.5"}, tuple(0.5 * v for v in VECTOR(P))),
        ("fractal2d", "float", {"octaves": "integer 4"}, octaves(PERLIN, UV, 4)),
        ("fractal3d", "vector3", {}, tuple(octaves(VECTOR, P, 3, i) for i in range(3))),
        ("fractal3d", "vector2", {"octaves": "integer 2"},
         (octaves(PERLIN, P, 2), octaves(PERLIN, apart(P, 19, 193, 17), 2), 0)),
        ("cellnoise2d", "float", {}, mx_noise.cells(UV)[0]),
        ("cellnoise3d", "float", {}, mx_noise.cells(P)[0]),
        ("worleynoise2d", "float", {"jitter": "float 0.5"}, mx_noise.worley(UV, 0.5)[0]),
        ("worleynoise3d", "vector3", {}, mx_noise.worley(P, 1.0)),
        ("worleynoise2d", "float", {"style": "integer 1"}, mx_noise.worley_cell(UV, 1.0)),
        ("worleynoise3d", "vector3", {"style": "integer 1"}, mx_noise.worley_cells(P, 1.0)),
        ("unifiednoise2d", "float", {"type": "integer 1"}, mx_noise.cells(UV)[0]),
        ("position", "vector3", {}, P),
        ("position", "vector3", {"space": "string world"}, (10.3, 20.6, 31.2)),
        ("normal", "vector3", {"space": "string world"}, (0, 0.6, 0.8)),
        ("viewdirection", "vector3", {"space": "string world"}, (0, 0, -1)),
        ("facingratio", "float", {}, 0.8),
        ("transformpoint", "vector3",
         {"in": "vector3 1,2,3", "fromspace": "string object", "tospace": "string world"},
         (11, 22, 33)),
        ("transformpoint", "vector3",
         {"in": "vector3 1,2,3", "fromspace": "string world", "tospace": "string model"},
         (-9, -18, -27)),
        ("transformvector", "vector3",
         {"in": "vector3 1,2,3", "fromspace": "string object", "tospace": "string world"},
         (1, 2, 3)),
    ],
)  # fmt: skip
def test_noises_and_places(
    tmp_path: Path, category: str, kind: str, inputs: dict[str, str], expected: Any
) -> None:
    nodes = node(category, kind, **inputs)
    assert emitted(tmp_path, kind, nodes) == pytest.approx(expected, abs=1e-6)


MATRIX = "1,2,0, 0,1,3, 4,0,1"


@pytest.mark.parametrize(
    ("category", "kind", "inputs", "expected"),
    [
        ("asin", "float", {"in": "float @x"}, math.asin(0.25)),
        ("acos", "float", {"in": "float @x"}, math.acos(0.25)),
        ("atan2", "float", {"iny": "float @y", "inx": "float @x"}, math.atan2(0.75, 0.25)),
        ("rotate3d", "vector3",
         {"in": "vector3 @v", "amount": "float 90", "axis": "vector3 0,0,2"}, (0.75, -0.25, 2)),
        ("transformmatrix", "vector3", {"in": "vector3 @v", "mat": f"matrix33 {MATRIX}"},
         (0.25 + 8, 0.5 + 0.75, 2.25 + 2)),
        ("transformmatrix", "vector2", {"in": "vector2 @t", "mat": f"matrix33 {MATRIX}"},
         (0.25 + 4, 0.5 + 0.75, 0)),
        ("determinant", "float", {"in": f"matrix33 {MATRIX}"}, 25.0),
        ("burn", "float", {"fg": "float @x", "bg": "float @y"}, 0.0),
        ("burn", "float", {"fg": "float 0", "bg": "float @y"}, 0.0),
        ("dodge", "float", {"fg": "float @x", "bg": "float @y", "mix": "float 0.5"},
         0.5 * 1.0 + 0.375),
        ("inside", "float", {"in": "float @y", "mask": "float @x"}, 0.1875),
        ("outside", "color3", {"in": "color3 1,2,4", "mask": "float @x"}, (0.75, 1.5, 3)),
        ("frame", "float", {}, 1.0),
        ("time", "float", {"fps": "float 4"}, 0.25),
    ],
)  # fmt: skip
def test_more_arithmetic(
    tmp_path: Path, category: str, kind: str, inputs: dict[str, str], expected: Any
) -> None:
    assert emitted(tmp_path, kind, VARYING + node(category, kind, **inputs)) == pytest.approx(
        expected, abs=1e-6
    )


def test_matrices_undo_each_other(tmp_path: Path) -> None:
    inverse = node("invertmatrix", "matrix33", "i", **{"in": f"matrix33 {MATRIX}"})
    there = node(
        "transformmatrix", "vector3", "w", **{"in": "vector3 @v", "mat": f"matrix33 {MATRIX}"}
    )
    back = node("transformmatrix", "vector3", **{"in": "vector3 @w", "mat": "matrix33 @i"})
    assert emitted(tmp_path, "vector3", VARYING + inverse + there + back) == pytest.approx(
        (0.25, 0.75, 2.0)
    )
    rows = {f"in{i + 1}": f"vector3 {row}" for i, row in enumerate(("@v", "0,1,0", "0,0,1"))}
    made = node("creatematrix", "matrix33", "m", **rows)
    turned = node("transpose", "matrix33", "t2", **{"in": "matrix33 @m"})
    point = node("transformmatrix", "vector3", **{"in": "vector3 1,1,1", "mat": "matrix33 @t2"})
    assert emitted(tmp_path, "vector3", VARYING + made + turned + point) == pytest.approx(
        (0.25 + 0.75 + 2.0, 1.0, 1.0)
    )


@pytest.mark.parametrize(
    ("category", "expected"),
    [
        ("over", (0.5 + 0.4 * 0.5, 0.5, 0.25)),
        ("in", (0.5 * 0.8, 0.4 * 0.0, 0.0)),
        ("out", (0.5 * 0.2, 0.0, 0.0)),
        ("mask", (0.4 * 0.5, 0.5, 0.25)),
        ("matte", (0.5 * 0.5 + 0.4 * 0.5, 0.5, 0.25)),
        ("disjointover", (0.5 + 0.4 * 0.625, 0.625, 0.3125)),
    ],
)
def test_compositing(tmp_path: Path, category: str, expected: Any) -> None:
    layers = {"fg": "color4 0.5,0,0,0.5", "bg": "color4 0.4,1,0.5,0.8"}
    nodes = node(category, "color4", "n4", **layers) + node(
        "convert", "color3", **{"in": "color4 @n4"}
    )
    assert emitted(tmp_path, "color3", nodes) == pytest.approx(expected, abs=1e-6)


def test_a_frame_is_a_change(tmp_path: Path) -> None:
    text = material('<input name="base" type="float" nodename="n"/>', node("frame", "float"))
    _stage, source = translated(tmp_path, text)
    assert source.varies
    first, second = (source.read(Usd.TimeCode(t)) for t in (1, 2))
    assert first.attributes["frame"] == 1.0
    assert surface_value(first.surface, "diffuseColor") == pytest.approx((0.8,) * 3)
    assert surface_value(second.surface, "diffuseColor") == pytest.approx((1.6,) * 3)


def test_the_geometrys_own_normal(tmp_path: Path) -> None:
    report = Report()
    text = material(
        '<input name="normal" type="vector3" nodename="n"/>',
        node("normal", "vector3", space="string world"),
    )
    assert "normal" not in surface(tmp_path, text, report).connected
    assert not report.notices


NORMAL_MAP = node("image", "vector3", "i", file="filename n.png") + node(
    "normalmap", "vector3", **{"in": "vector3 @i", "scale": "float 0.5"}
)


def test_normal_map(tmp_path: Path) -> None:
    text = material('<input name="normal" type="vector3" nodename="n"/>', NORMAL_MAP)
    found = surface_value(surface(tmp_path, text), "normal", ST)
    assert found == pytest.approx((-0.25, 0.25, 1.0))


def test_a_normal_that_is_no_map_is_ignored(tmp_path: Path) -> None:
    report = Report()
    constant = node("constant", "vector3", value="vector3 1,0,0")
    text = material('<input name="normal" type="vector3" nodename="n"/>', constant)
    assert "normal" not in surface(tmp_path, text, report).connected
    assert any("other nodes than normal maps" in n.text for n in report.notices)
    quiet = Report()
    surface(tmp_path, material('<input name="normal" type="vector3" value="0,0,1"/>'), quiet)
    assert not quiet.notices


def test_unknown_nodes_give_their_defaults(tmp_path: Path) -> None:
    report = Report()
    black = node("blackbody", "color3", temperature="float 5000")
    text = material('<input name="base_color" type="color3" nodename="n"/>', black)
    assert surface_value(surface(tmp_path, text, report), "diffuseColor") == (0.0, 0.0, 0.0)
    assert [n.message for n in report.notices] == [
        "MaterialX node blackbody (its default rendered)"
    ]
    nonsense = '<nonsense name="n" type="float"/>'
    other = Report()
    surface(tmp_path, material('<input name="base" type="float" nodename="n"/>', nonsense), other)
    assert any("shader node nonsense" in n.text for n in other.notices)


def test_nodes_that_feed_themselves(tmp_path: Path) -> None:
    report = Report()
    loop = node("add", "float", "n", in1="float @o", in2="float 0.5") + node(
        "multiply", "float", "o", in1="float @n", in2="float 2"
    )
    text = material('<input name="base" type="float" nodename="n"/>', loop)
    found = surface_value(surface(tmp_path, text, report), "diffuseColor")
    assert found == pytest.approx((0.4, 0.4, 0.4))
    assert any("leads back to itself" in n.text for n in report.notices)


def test_primvars_and_textures_are_known_beforehand(tmp_path: Path) -> None:
    nodes = node("image", "color3", "i", file="filename a.png") + node(
        "geompropvalue", "float", geomprop="string wear"
    )
    inputs = '<input name="base" type="float" nodename="n"/>'
    inputs += '<input name="base_color" type="color3" nodename="i"/>'
    _stage, source = translated(tmp_path, material(inputs, nodes))
    assert source.primvars == {"st", "wear"}
    (reference,) = source.textures()
    assert reference.file.endswith("a.png")
    assert reference.color_space == "raw"


def test_colour_spaces(tmp_path: Path) -> None:
    value = 'value="0.5,0.5,0.5" colorspace="srgb_texture"'
    found = surface(tmp_path, material(f'<input name="base_color" type="color3" {value}/>'))
    linear = ((0.5 + 0.055) / 1.055) ** 2.4
    assert surface_value(found, "diffuseColor") == pytest.approx((linear,) * 3, rel=1e-5)


def test_a_value_that_varies(tmp_path: Path) -> None:
    curve = 'value="1" valuerange="1,2" valuecurve="0.5, 0.25"'
    _stage, source = translated(tmp_path, material(f'<input name="base" type="float" {curve}/>'))
    assert source.varies
    first, second = (source.read(Usd.TimeCode(t)) for t in (1, 2))
    assert surface_value(first.surface, "diffuseColor") == pytest.approx((0.4,) * 3)
    assert surface_value(second.surface, "diffuseColor") == pytest.approx((0.2,) * 3)
    assert source.read(Usd.TimeCode(2)) is second
