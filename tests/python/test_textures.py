# SPDX-License-Identifier: Apache-2.0
"""UsdUVTexture and its neighbours, from files to pixels, against closed forms."""

from pathlib import Path
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

import numpy as np
import pytest
from pxr import UsdUtils

from irt_usd.changes import diff
from irt_usd.errors import InputError
from irt_usd.images.textures import TextureLibrary
from irt_usd.report import Report
from irt_usd.shot.foresight import foresee
from irt_usd.shot.progress import shot_progress
from irt_usd.shot.settings import TraceSettings
from irt_usd.shot.tracer import ShotTracer
from irt_usd.shot.verify import TABLE_HEADER, verify_shot
from textured import block_middles, blocks, picture, shot_of, srgb, write_image, write_stage

CODES = np.array([(20, 40, 60, 255), (80, 100, 120, 128), (140, 160, 180, 64), (200, 220, 240, 0)])
FILE = "asset inputs:file = @image.png@\n"


@pytest.fixture
def image(tmp_path: Path) -> Path:
    return write_image(tmp_path / "image.png", blocks(CODES.astype(np.uint8)))


def seen(folder: Path, texture: str = "", **parts: str) -> np.ndarray:
    return block_middles(picture(write_stage(folder, texture=FILE + texture, **parts)))


def test_eight_bits_of_three_or_four_channels_are_srgb(tmp_path: Path, image: Path) -> None:
    np.testing.assert_allclose(seen(tmp_path), srgb(CODES[:, :3] / 255), rtol=1e-6)


def test_raw(tmp_path: Path, image: Path) -> None:
    found = seen(tmp_path, 'token inputs:sourceColorSpace = "raw"')
    np.testing.assert_allclose(found, CODES[:, :3] / 255, rtol=1e-6)


def test_scale_and_bias(tmp_path: Path, image: Path) -> None:
    texture = """token inputs:sourceColorSpace = "raw"
float4 inputs:scale = (2, 0.5, 1, 1)
float4 inputs:bias = (0.25, 0, -0.125, 0)"""
    expected = np.maximum(CODES[:, :3] / 255 * (2, 0.5, 1) + (0.25, 0, -0.125), 0)
    np.testing.assert_allclose(seen(tmp_path, texture), expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("output", ["r", "g", "b", "a"])
def test_single_outputs(tmp_path: Path, image: Path, output: str) -> None:
    inputs = f"color3f inputs:emissiveColor.connect = </M/T.outputs:{output}>"
    found = seen(tmp_path, 'token inputs:sourceColorSpace = "raw"', inputs=inputs)
    expected = CODES[:, "rgba".index(output)] / 255
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 3, axis=1), rtol=1e-6)


@pytest.mark.parametrize(
    ("transform", "order"),
    [
        ("float2 inputs:translation = (0.5, 0)", [1, 0, 3, 2]),
        ("float2 inputs:translation = (0, 0.5)", [2, 3, 0, 1]),
        ("float inputs:rotation = 90", [1, 3, 0, 2]),  # counter-clockwise, of st
        ("float2 inputs:scale = (-1, 1)", [1, 0, 3, 2]),
        ("float2 inputs:scale = (1, -1)\nfloat inputs:rotation = 90", [0, 2, 1, 3]),
    ],
)
def test_transform(tmp_path: Path, image: Path, transform: str, order: list[int]) -> None:
    """The result is in * scale, then rotated, then moved: here onto other blocks."""
    texture = 'token inputs:sourceColorSpace = "raw"\ntoken inputs:wrapS = "repeat"\n'
    texture += 'token inputs:wrapT = "repeat"'
    found = seen(tmp_path, texture, transform=transform)
    np.testing.assert_allclose(found, (CODES[:, :3] / 255)[order], rtol=1e-6)


@pytest.mark.parametrize(
    ("wrap", "expected"),
    [
        ("repeat", [0, 1, 2, 3]),
        ("mirror", [1, 0, 3, 2]),
        ("clamp", [1, 1, 3, 3]),
        ("black", [None] * 4),
        ("useMetadata", [None] * 4),
    ],
)
def test_wrap(tmp_path: Path, image: Path, wrap: str, expected: list[int | None]) -> None:
    """One square to the right of the image's own."""
    texture = f'token inputs:sourceColorSpace = "raw"\ntoken inputs:wrapS = "{wrap}"'
    found = seen(tmp_path, texture, transform="float2 inputs:translation = (1, 0)")
    values = [np.zeros(3) if i is None else CODES[i, :3] / 255 for i in expected]
    np.testing.assert_allclose(found, values, rtol=1e-6)


def test_wrap_by_the_files_metadata(tmp_path: Path) -> None:
    pixels = blocks(CODES[:, :3].astype(np.float32) / 255)
    write_image(tmp_path / "image.exr", pixels, {"wrapmodes": "periodic,clamp"})
    stage = write_stage(
        tmp_path,
        texture="asset inputs:file = @image.exr@",
        transform="float2 inputs:translation = (1, 0)",
    )
    found = block_middles(picture(stage))
    np.testing.assert_allclose(found, CODES[:, :3] / 255, rtol=1e-6)


def test_the_primvars_name_through_the_interface_and_a_fallback(
    tmp_path: Path, image: Path
) -> None:
    graph = f"""def NodeGraph "G"
{{
    token inputs:name.connect = </M.inputs:name>
    float2 outputs:st.connect = </M/G/R.outputs:result>
    def Shader "R"
    {{
        uniform token info:id = "UsdPrimvarReader_float2"
        token inputs:varname.connect = </M/G.inputs:name>
        float2 inputs:fallback = (0.75, 0.75)
        float2 outputs:result
    }}
}}
def Shader "T2"
{{
    uniform token info:id = "UsdUVTexture"
    {FILE}
    float2 inputs:st.connect = </M/G.outputs:st>
    float3 outputs:rgb
}}"""
    for name, expected in (("st", CODES[:, :3]), ("other", CODES[[3] * 4, :3])):
        stage = write_stage(
            tmp_path,
            interface=f'token inputs:name = "{name}"',
            shaders=graph,
            inputs="color3f inputs:emissiveColor.connect = </M/T2.outputs:rgb>",
        )
        np.testing.assert_allclose(block_middles(picture(stage)), srgb(expected / 255), rtol=1e-6)


@pytest.mark.parametrize("kind", ["float3", "normal", "point", "vector"])
def test_primvars_of_three_numbers(tmp_path: Path, kind: str) -> None:
    colors = "[(0, 0, 0), (1, 0, 0), (1, 0.5, 0), (0, 0.5, 0)]"
    primvar = f'color3f[] primvars:tint = {colors} (\ninterpolation = "vertex"\n)'
    reader = f"""def Shader "R"
{{
    uniform token info:id = "UsdPrimvarReader_{kind}"
    string inputs:varname = "tint"
    float3 outputs:result
}}"""
    inputs = "color3f inputs:emissiveColor.connect = </M/R.outputs:result>"
    stage = write_stage(tmp_path, primvars=primvar, shaders=reader, inputs=inputs)
    found = picture(stage)
    x = (np.arange(8) + 0.5) / 8
    np.testing.assert_allclose(found[..., 0], np.broadcast_to(x, (8, 8)), rtol=1e-5)
    np.testing.assert_allclose(
        found[..., 1], np.broadcast_to(x[::-1, None] / 2, (8, 8)), rtol=1e-5, atol=1e-6
    )


def test_udim(tmp_path: Path) -> None:
    """Tiles 1001, 1002 and 1012; 1011 is a hole."""
    for tile, value in ((1001, 50), (1002, 100), (1012, 150)):
        write_image(tmp_path / f"t.{tile}.png", np.full((4, 4, 3), value, np.uint8))
    texture = """asset inputs:file = @t.<UDIM>.png@
token inputs:sourceColorSpace = "raw"
float4 inputs:fallback = (0.5, 0.25, 0.125, 1)
float4 inputs:scale = (0.5, 0.5, 0.5, 1)"""
    stage = write_stage(tmp_path, texture=texture, transform="float2 inputs:scale = (2, 2)")
    report = Report()
    found = block_middles(picture(stage, report))
    expected = [[50 / 510] * 3, [100 / 510] * 3, [0.5, 0.25, 0.125], [150 / 510] * 3]
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    (text,) = [n.text for n in report.notices if "light" not in n.message]
    assert "UDIM tiles missing, fallback rendered: 1011: /M/T.inputs:file in " in text


def test_udim_without_tiles(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, texture="asset inputs:file = @t.<UDIM>.png@")
    with pytest.raises(InputError, match=r"/M/T.inputs:file in .*square0.usda: @.*t.<UDIM>.png@"):
        shot_of(stage)


def test_a_package(tmp_path: Path, image: Path) -> None:
    stage = write_stage(tmp_path, texture=FILE)
    package = tmp_path / "square.usdz"
    assert UsdUtils.CreateNewUsdzPackage(str(stage), str(package))
    image.unlink()
    found = block_middles(picture(package))
    np.testing.assert_allclose(found, srgb(CODES[:, :3] / 255), rtol=1e-6)


def test_a_package_with_a_compressed_texture(tmp_path: Path, image: Path) -> None:
    """As a zip bomb would have it: USD forbids compression, and nothing is unpacked."""
    stage = write_stage(tmp_path, texture=FILE)
    package = tmp_path / "square.usdz"
    with ZipFile(package, "w", ZIP_STORED) as archive:
        archive.write(stage, stage.name)
        archive.write(image, "image.png", ZIP_DEFLATED)
    with pytest.raises(InputError, match=r"square\.usdz"):
        picture(package)


def test_the_path_varies(tmp_path: Path, image: Path) -> None:
    write_image(tmp_path / "other.png", blocks(CODES[::-1].astype(np.uint8)))
    keys = "asset inputs:file.timeSamples = {1: @image.png@, 2: @other.png@, 3: @other.png@}"
    stage = write_stage(tmp_path, texture=keys)
    found = block_middles(picture(stage, frames="2"))
    np.testing.assert_allclose(found, srgb(CODES[::-1, :3] / 255), rtol=1e-6)
    shot = shot_of(stage, frames="1:3")
    first, second, third = (shot.reader.read(time) for time in (1, 2, 3))
    (change,) = diff(first, second).changes
    assert (change.path, change.attribute) == ("/M/T", "inputs:file")
    assert str(change.old).endswith("image.png")
    assert str(change.new).endswith("other.png")
    assert not diff(second, third).changes


def test_of_a_sequence_two_images_are_in_memory(tmp_path: Path, image: Path) -> None:
    """That of a frame and that of the frame before; what does not vary stays."""
    numbers = range(1, 7)
    for number in numbers:
        write_image(tmp_path / f"f{number}.png", blocks((CODES + number).astype(np.uint8)))
    keys = ", ".join(f"{number}: @f{number}.png@" for number in numbers)
    stage = write_stage(tmp_path, texture=f"asset inputs:file.timeSamples = {{{keys}}}")
    shot = shot_of(stage, frames="1:6")
    assert foresee(shot, shot.frames) is not None
    library = shot.reader.textures
    assert isinstance(library, TextureLibrary)
    assert not library.decoded
    tracer = ShotTracer(shot, TraceSettings(), shot.frames)
    for frame in shot.frames:
        tracer.trace(frame)
        shown = tracer.film().beauty[..., :3].copy()
        names = {Path(reference.file).stem for reference in library.decoded}
        assert names == {f"f{n}" for n in (int(frame) - 1, int(frame)) if n in numbers}
        np.testing.assert_array_equal(shown, picture(stage, frames=str(frame)))


@pytest.mark.parametrize(
    "keys",
    [
        {"texture": "float4 inputs:scale.timeSamples = {1: (1, 1, 1, 1), 3: (0.5, 2, 1, 1)}"},
        {"texture": "float4 inputs:bias.timeSamples = {1: (0, 0, 0, 0), 3: (0.5, 0, 0.25, 0)}"},
        {"texture": 'token inputs:wrapS.timeSamples = {1: "black", 3: "repeat"}'},
        {"transform": "float inputs:rotation.timeSamples = {1: 0, 3: 30}"},
        {"texture": 'token inputs:sourceColorSpace.timeSamples = {1: "raw", 2: "sRGB"}'},
    ],
)
def test_updates_are_exact(tmp_path: Path, image: Path, keys: dict[str, str]) -> None:
    stage = write_stage(tmp_path, **{**keys, "texture": FILE + keys.get("texture", "")})
    shot = shot_of(stage, frames="1:3", size=(24, 24))
    assert len(diff(shot.reader.read(1), shot.reader.read(3)).changes) == 1
    with shot_progress(3, TABLE_HEADER, True) as progress:
        assert verify_shot(shot, TraceSettings(), 16, progress).exact


def test_display_color_in_every_interpolation(tmp_path: Path) -> None:
    for interpolation, values in (
        ("constant", "[(0.5, 0.25, 0)]"),
        ("uniform", "[(0.5, 0.25, 0)]"),
        ("vertex", "[(0, 0.25, 0), (1, 0.25, 0), (1, 0.25, 0), (0, 0.25, 0)]"),
        ("varying", "[(0, 0.25, 0), (1, 0.25, 0), (1, 0.25, 0), (0, 0.25, 0)]"),
        ("faceVarying", "[(0, 0.25, 0), (1, 0.25, 0), (1, 0.25, 0), (0, 0.25, 0)]"),
    ):
        primvar = (
            f'color3f[] primvars:displayColor = {values} (\ninterpolation = "{interpolation}"\n)'
        )
        stage = write_stage(tmp_path, primvars=primvar)
        text = stage.read_text().replace("rel material:binding = </M>", "")
        stage.write_text(text)
        shot = shot_of(stage)
        tracer = ShotTracer(shot, TraceSettings(aovs=("albedo",)), shot.frames, "none")
        tracer.trace(shot.frames[0])
        albedo = tracer.film().aovs["albedo"]
        steady = interpolation in ("constant", "uniform")
        x = np.full(8, 0.5) if steady else (np.arange(8) + 0.5) / 8
        expected = np.stack([np.broadcast_to(x, (8, 8)), np.full((8, 8), 0.25), np.zeros((8, 8))])
        np.testing.assert_allclose(albedo, np.moveaxis(expected, 0, 2), rtol=1e-5)


def test_st_is_an_inherited_constant(tmp_path: Path, image: Path) -> None:
    constant = 'texCoord2f[] primvars:st = [(0.25, 0.75)] (\ninterpolation = "constant"\n)'
    found = block_middles(picture(write_stage(tmp_path, texture=FILE, primvars=constant)))
    np.testing.assert_allclose(found, srgb(CODES[[2] * 4, :3] / 255), rtol=1e-6)
