# SPDX-License-Identifier: Apache-2.0
"""AOVs as a compositor finds them: EXR files of `irt render`, opened by OpenImageIO's own tool."""

import json
import re
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from numpy.typing import NDArray

from cli_support import failure, irt, write_stage
from irt_usd import _core, light_paths
from irt_usd.aovs import aov, default_layer, is_aov, primvar_aov
from irt_usd.shot.metadata import time_code

OIIOTOOL = str(Path(sysconfig.get_path("scripts")) / "oiiotool")

STAGE = """#usda 1.0
(
    "a comment"
    startTimeCode = 1
    endTimeCode = 3
    framesPerSecond = 24
    upAxis = "Y"
    owner = "the owner"
)

def Camera "Cam"
{
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 10
    float fStop = 4
    float focusDistance = 5
    double shutter:close = 0.5
    double3 xformOp:translate = (0, 0, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

def Xform "World"
{
    def Sphere "Ball" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        double radius = 1
        rel material:binding = </World/Red>
        double3 xformOp:translate.timeSamples = { 1: (-1, 0, 0), 2: (-0.5, 0, 0), 3: (0, 0, 0) }
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }

    def Mesh "Wall"
    {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [4, 4, 4]
        int[] faceVertexIndices = [0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6]
        int[] holeIndices = [1]
        point3f[] points = [(-9, -9, -2), (-1, -9, -2), (1, -9, -2), (9, -9, -2),
            (-9, 9, -2), (-1, 9, -2), (1, 9, -2), (9, 9, -2)]
        float2[] primvars:st = [(0, 0), (0.4, 0), (0.6, 0), (1, 0),
            (0, 1), (0.4, 1), (0.6, 1), (1, 1)] (
            interpolation = "vertex"
        )
    }

    def PointInstancer "Dots"
    {
        int64[] ids = [5, 3]
        int[] protoIndices = [0, 0]
        point3f[] positions = [(-2, 2.5, 0), (2, 2.5, 0)]
        rel prototypes = </World/Dots/Dot>

        def Sphere "Dot"
        {
            double radius = 0.4
        }
    }

    def Material "Red"
    {
        token outputs:surface.connect = </World/Red/Surface.outputs:surface>

        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.8, 0.1, 0.1)
            token outputs:surface
        }
    }
}

def DistantLight "Sun"
{
    float inputs:intensity = 3
}

def DistantLight "Fill"
{
    color3f inputs:color = (0.2, 0.3, 1)
    float inputs:intensity.timeSamples = { 1: 1, 2: 1, 3: 2 }
    float xformOp:rotateX = -40
    uniform token[] xformOpOrder = ["xformOp:rotateX"]
}
"""

SIZE = ("--size", "64x64")

EVERY_AOV = (
    *("depth", "cameraDepth", "normal", "Neye", "position", "Peye", "albedo"),
    *("objectId", "primId", "instanceId", "elementId", "CryptoObject", "CryptoMaterial"),
    *("motionBack", "motionFore", "irt.retraced", "irt.age", "irt.cause"),
    *("primvars:st as float2", "sun=lpe:C.*<L.'Sun'>", "direct=lpe:C.[LO]"),
)


def asking(*aovs: str) -> list[str]:
    return [word for name in aovs for word in ("--aov", name)]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Frames 1 to 3 with every AOV."""
    folder = tmp_path_factory.mktemp("aovs")
    stage = write_stage(folder, STAGE)
    pattern = str(folder / "f.####.exr")
    result = irt("render", stage, *SIZE, "--samples", "4", "-o", pattern, *asking(*EVERY_AOV))
    assert result.exit_code == 0, result.output
    return [folder / f"f.000{frame}.exr" for frame in (1, 2, 3)]


def parts(path: Path) -> list[tuple[Any, NDArray[Any]]]:
    """Spec and pixels of each part."""
    image: Any = oiio.ImageInput.open(str(path))
    found: list[tuple[Any, NDArray[Any]]] = []
    while image.seek_subimage(len(found), 0):
        spec = image.spec()
        kind = oiio.UINT32 if str(spec.format) == "uint" else oiio.FLOAT
        pixels = image.read_image(len(found), 0, 0, spec.nchannels, kind)
        found.append((spec, np.asarray(pixels)))
    return found


def layer(path: Path, *channels: str) -> NDArray[Any]:
    for spec, pixels in parts(path):
        if set(channels) <= set(spec.channelnames):
            return pixels[..., [spec.channelnames.index(name) for name in channels]]
    raise KeyError(channels)


def header(path: Path, key: str) -> Any:
    return parts(path)[0][0].getattribute(key)


def oiiotool(*arguments: str) -> str:
    done = subprocess.run([OIIOTOOL, *arguments], capture_output=True, text=True, check=True)
    return done.stdout


def test_oiiotool_opens_every_aov(files: list[Path], tmp_path: Path) -> None:
    said = oiiotool("--info", "-v", "-a", str(files[1]))
    listed = re.findall(r"channel list: (.*)", said)
    channels = {name.split(" ")[0] for line in listed for name in line.split(", ")}
    wanted: set[str] = {"R", "G", "B", "A"}
    for name in EVERY_AOV:
        label, _, given = name.rpartition("=")
        wanted |= set(aov(given).channels(label or default_layer(given), 8))
    assert channels == wanted
    copy = tmp_path / "red.exr"
    oiiotool(str(files[1]), "--ch", "R,G,B", "-o", str(copy))
    assert np.array_equal(layer(copy, "R"), layer(files[1], "R"))


def cryptomatte(path: Path, name: str) -> tuple[dict[str, str], NDArray[np.float32]]:
    """Manifest and ranks, as Cryptomatte 1.2.0 says to find them."""
    spec = parts(path)[0][0]
    (key,) = (
        a.name.rpartition("/")[0]
        for a in spec.extra_attribs
        if a.name.startswith("cryptomatte/") and a.name.endswith("/name") and a.value == name
    )
    assert key == f"cryptomatte/{_core.name_hash(name):08x}"[:19]
    assert spec.getattribute(f"{key}/hash") == "MurmurHash3_32"
    assert spec.getattribute(f"{key}/conversion") == "uint32_to_float32"
    manifest = json.loads(spec.getattribute(f"{key}/manifest"))
    channels = sorted(
        (c for c in spec.channelnames if re.fullmatch(rf"{name}\d\d\.[RGBA]", c)),
        key=lambda c: (c[:-1], "RGBA".index(c[-1])),
    )
    return manifest, layer(path, *channels)


def matte(path: Path, name: str, label: str) -> NDArray[np.float32]:
    """The coverage of one object or material."""
    manifest, ranks = cryptomatte(path, name)
    number = np.array(int(manifest[label], 16), np.uint32).view(np.float32)
    shares: NDArray[np.float32] = np.where(ranks[..., ::2] == number, ranks[..., 1::2], 0).sum(
        axis=-1
    )
    return shares


def test_cryptomatte_decodes_to_what_is_visible(files: list[Path]) -> None:
    for path in files:
        manifest, ranks = cryptomatte(path, "CryptoObject")
        assert set(manifest) == {"/World/Ball", "/World/Wall", "/World/Dots[3]", "/World/Dots[5]"}
        assert ranks[..., 1::2].sum(axis=-1) == pytest.approx(layer(path, "A")[..., 0], abs=1e-3)
        first = layer(path, "objectId.id")[..., 0]
        for label in manifest:
            shown = matte(path, "CryptoObject", label)
            mine = first == _core.name_hash(label)
            assert np.all(shown[mine] > 0)
            assert np.all(shown[shown == 1] == mine[shown == 1])
        ball = matte(path, "CryptoObject", "/World/Ball")
        assert np.array_equal(ball, matte(path, "CryptoMaterial", "/World/Red"))
        # A ball of radius 1 at distance 4: its disc, of the image's 4 by 4 at z = -4 before it.
        assert ball.sum() / 64**2 == pytest.approx(np.pi / 15 / 4, rel=0.1)
    ids = [cryptomatte(path, "CryptoObject")[0] for path in files]
    assert ids[0] == ids[1] == ids[2]


def test_ids_are_hydras(files: list[Path]) -> None:
    instance = layer(files[0], "instanceId.id")[..., 0]
    prim = layer(files[0], "primId.id")[..., 0]
    for key in (3, 5):
        assert np.array_equal(instance == key, prim == _core.name_hash(f"/World/Dots[{key}]"))
        assert (instance == key).any()
    assert set(np.unique(instance)) == {3, 5, 2**32 - 1}
    element = layer(files[0], "elementId.id")[..., 0]
    wall = prim == _core.name_hash("/World/Wall")
    assert set(np.unique(element[wall])) == {0, 2}  # the hole is face 1
    assert np.array_equal(element == 2, wall & (layer(files[0], "position.X")[..., 0] > 0))


def test_depth_position_and_normals_follow_closed_forms(files: list[Path]) -> None:
    depth, camera_depth = layer(files[0], "Z"), layer(files[0], "cameraDepth")
    position = layer(files[0], "position.X", "position.Y", "position.Z").astype(np.float64)
    normal = layer(files[0], "normal.X", "normal.Y", "normal.Z").astype(np.float64)
    eye = layer(files[0], "Peye.X", "Peye.Y", "Peye.Z")
    assert np.array_equal(depth, camera_depth)
    prim = layer(files[0], "primId.id")[..., 0]
    wall, ball = (prim == _core.name_hash(f"/World/{name}") for name in ("Wall", "Ball"))
    assert depth[wall] == pytest.approx(6, abs=1e-5)
    assert normal[wall] == pytest.approx(np.broadcast_to([0, 0, 1], (wall.sum(), 3)), abs=1e-6)
    outward = position[ball] - np.array([-1, 0, 0])
    assert np.linalg.norm(outward, axis=1) == pytest.approx(1, abs=1e-5)
    assert normal[ball] == pytest.approx(outward, abs=1e-5)
    seen = prim != 0
    assert eye[seen] == pytest.approx(position[seen] - np.array([0, 0, 4]), abs=1e-5)
    assert depth[seen][:, 0] == pytest.approx(4 - position[seen][:, 2], abs=1e-5)
    st = layer(files[0], "primvars:st.X", "primvars:st.Y")
    assert st[wall][:, 1] == pytest.approx((position[wall][:, 1] + 9) / 18, abs=1e-5)
    assert not st[ball].any()


def test_motion_is_that_of_the_ball(files: list[Path]) -> None:
    """Half a unit a frame; the image is 2 wide at distance 1, 64 pixels."""
    for path, back, fore in zip(files, (0, -0.5, -0.5), (0.5, 0.5, 0), strict=True):
        depth = layer(path, "Z")[..., 0]
        ball = layer(path, "primId.id")[..., 0] == _core.name_hash("/World/Ball")
        for name, step in (("motionBack", back), ("motionFore", fore)):
            motion = layer(path, f"{name}.X", f"{name}.Y")
            assert motion[ball][:, 0] == pytest.approx(step / depth[ball] * 32, abs=1e-3)
            assert motion[ball][:, 1] == pytest.approx(0, abs=1e-5)
            assert not motion[~ball].any()


def test_light_paths_are_parts_of_the_picture(files: list[Path]) -> None:
    for path in files:
        color, sun = layer(path, "R", "G", "B"), layer(path, "sun.R", "sun.G", "sun.B")
        direct = layer(path, "direct.R", "direct.G", "direct.B")
        assert np.all(sun <= color)
        assert sun.any()
        wall = layer(path, "primId.id")[..., 0] == _core.name_hash("/World/Wall")
        assert direct[wall] == pytest.approx(color[wall], rel=2e-3)
    # The fill light alone changed.
    prim = [layer(path, "primId.id") for path in files[1:]]
    same = (prim[0] == prim[1])[..., 0] & (prim[0] == _core.name_hash("/World/Wall"))[..., 0]
    suns = [layer(path, "sun.R", "sun.G", "sun.B") for path in files[1:]]
    assert (suns[0][same] == suns[1][same]).mean() > 0.8


def test_causes_are_named_in_the_header(files: list[Path]) -> None:
    tables = [json.loads(header(path, "irt:causes")) for path in files]
    assert tables[0] == {"1": "the first frame"}
    assert tables[1] == {"1": "/World/Ball.world_from_object"}
    assert sorted(tables[2].values()) == [
        "/Fill.inputs:intensity",
        "/World/Ball.world_from_object",
    ]
    cause = layer(files[1], "irt.cause")[..., 0]
    colors = [layer(path, "R", "G", "B", "A") for path in files[:2]]
    assert set(np.unique(cause)) == {0, 1}
    assert np.all(cause[(colors[0] != colors[1]).any(axis=-1)] == 1)
    assert header(files[0], "irt:frame") == "1"


def test_headers_tell_of_lens_film_back_and_time(files: list[Path]) -> None:
    said = {a.name: a.value for a in parts(files[1])[0][0].extra_attribs}
    assert said["Copyright"] == "the owner"
    assert said["ImageDescription"] == "a comment"
    assert said["FNumber"] == 4
    assert said["focus"] == 5
    assert said["ExposureTime"] == pytest.approx(0.5 / 24)
    assert said["screenWindowWidth"] == pytest.approx(2)
    assert said["screenWindowCenter"] == pytest.approx((0, 0))
    assert said["smpte:TimeCode"] == (2, 0)
    assert said["imageCounter"] == 2
    text = oiiotool("--info", "-v", str(files[1]))
    assert "smpte:TimeCode: 00:00:00:02" in text
    assert not any(word in text for word in ("host", "Memory", "seconds"))


def test_windows_are_those_of_a_render_cropped_by_hand(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, STAGE)
    names = ("depth", "objectId", "elementId", "CryptoObject", "motionFore", "direct=lpe:C.[LO]")
    for name, region in (("whole", ()), ("part", ("--region", "0.25,0.125,0.75,0.5"))):
        output = str(tmp_path / f"{name}.exr")
        done = irt("render", stage, "-f", "2", *SIZE, *region, "-o", output, *asking(*names))
        assert done.exit_code == 0, done.output
    cut = tmp_path / "cut.exr"
    oiiotool(str(tmp_path / "whole.exr"), "--crop", "32x24+16+32", "-o", str(cut))
    whole, part = parts(tmp_path / "whole.exr"), parts(tmp_path / "part.exr")
    assert [spec.channelnames for spec, _ in whole] == [spec.channelnames for spec, _ in part]
    for (_, pixels), (spec, others) in zip(whole, part, strict=True):
        assert (spec.x, spec.y, spec.width, spec.height) == (16, 32, 32, 24)
        assert (spec.full_x, spec.full_y, spec.full_width, spec.full_height) == (0, 0, 64, 64)
        assert np.array_equal(pixels[32:56, 16:48], others)
    ((spec, pixels),) = parts(cut)
    assert (spec.x, spec.y, spec.width, spec.height) == (16, 32, 32, 24)
    assert np.array_equal(pixels, part[0][1])
    assert header(tmp_path / "part.exr", "originalDataWindow") == pytest.approx((0, 0, 63, 63))


def test_two_runs_and_a_run_without_history_give_the_same_bytes(
    files: list[Path], tmp_path: Path
) -> None:
    stage = write_stage(tmp_path, STAGE)
    wanted = [name for name in EVERY_AOV if not name.startswith("irt.")]
    for run, extra in (("a", ()), ("b", ()), ("c", ("--history", "none"))):
        pattern = str(tmp_path / run / "f.####.exr")
        done = irt("render", stage, *SIZE, *extra, "-o", pattern, *asking(*wanted))
        assert done.exit_code == 0, done.output
    for path in files:
        contents = {(tmp_path / run / path.name).read_bytes() for run in "abc"}
        assert len(contents) == 1


def test_frames_do_not_depend_on_which_others_are_rendered(
    files: list[Path], tmp_path: Path
) -> None:
    stage = write_stage(tmp_path, STAGE)
    alone = tmp_path / "f.0002.exr"
    done = irt("render", stage, "-f", "2", *SIZE, "--samples", "4", "-o", str(alone),
               *asking("motionBack", "motionFore", "CryptoObject"))  # fmt: skip
    assert done.exit_code == 0, done.output
    channels = [f"{name}.{axis}" for name in ("motionBack", "motionFore") for axis in "XY"]
    assert np.array_equal(layer(alone, *channels), layer(files[1], *channels))
    assert cryptomatte(alone, "CryptoObject")[0] == cryptomatte(files[1], "CryptoObject")[0]


def test_motion_ends_though_nothing_changes(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, STAGE)
    pattern = str(tmp_path / "f.#.exr")
    done = irt("render", stage, "-f", "3:5", *SIZE, "-o", pattern, *asking("motionBack"))
    assert done.exit_code == 0, done.output
    moving = [layer(tmp_path / f"f.{frame}.exr", "motionBack.X").any() for frame in (3, 4, 5)]
    assert moving == [True, False, False]


def test_a_sidecar_holds_what_differs_from_run_to_run(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, STAGE)
    path = tmp_path / "f.exr"
    done = irt("render", stage, "-f", "1", *SIZE, "-o", str(path), "--sidecar")
    assert done.exit_code == 0, done.output
    facts = json.loads((tmp_path / "f.exr.json").read_text())
    assert facts["frame"]["frame"] == 1
    assert facts["frame"]["seconds"]["total"] > 0
    assert facts["peak_memory_bytes"] > 2**20
    assert facts["host"]
    (tmp_path / "f.exr.json").unlink()
    before = path.read_bytes()
    assert irt("render", stage, "-f", "1", *SIZE, "-o", str(path)).exit_code == 0
    assert path.read_bytes() == before
    assert not (tmp_path / "f.exr.json").exists()


PRODUCT = (
    STAGE.replace("startTimeCode", 'renderSettingsPrimPath = "/Render"\n    startTimeCode', 1)
    + """
def RenderSettings "Render"
{
    rel products = </Render/Main>
    uniform int2 resolution = (64, 64)

    def RenderProduct "Main"
    {
        token productName = "main.exr"
        rel orderedVars = [</Render/c>, </Render/st>, </Render/key>, </Render/crypto>,
            </Render/face>, </Render/odd>, </Render/diffuse>]
    }

    def RenderVar "c"
    {
        string sourceName = "color"
    }
    def RenderVar "st"
    {
        string sourceName = "st"
        token sourceType = "primvar"
        token dataType = "float2"
    }
    def RenderVar "key"
    {
        string sourceName = "C.*<L.'/Sun'>"
        token sourceType = "lpe"
    }
    def RenderVar "crypto"
    {
        string sourceName = "crypto_object"
    }
    def RenderVar "face"
    {
        string sourceName = "elementId"
    }
    def RenderVar "odd"
    {
        string sourceName = "edgeId"
    }
    def RenderVar "diffuse"
    {
        string sourceName = "lpe:C<RD>L"
    }
}
"""
)


def test_render_vars_ask_for_the_same(
    files: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = write_stage(tmp_path, PRODUCT)
    monkeypatch.chdir(tmp_path)
    done = irt("render", stage, "-f", "1", "--samples", "4")
    assert done.exit_code == 0, done.output
    path = tmp_path / "main.exr"
    st = layer(files[0], "primvars:st.X", "primvars:st.Y")
    assert np.array_equal(layer(path, "st.X", "st.Y"), st)
    assert np.array_equal(layer(path, "key.R"), layer(files[0], "sun.R"))
    assert np.array_equal(layer(path, "face.id"), layer(files[0], "elementId.id"))
    assert cryptomatte(path, "crypto")[0] == cryptomatte(files[0], "CryptoObject")[0]
    for lost in ("'edgeId'", "'lpe:C<RD>L'"):
        assert lost in done.output


def test_shots_with_every_aov_are_exact(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, PRODUCT)
    done = irt("verify", stage, "--size", "32x32", "--samples", "2", "--brute-force-pixels", "200")
    assert done.exit_code == 0, done.output
    assert "exact" in done.output


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("C.*", ("any", True, None)),
        ("lpe:C.*[LO]", ("any", True, None)),
        ("color lpe:C.*L", ("any", False, None)),
        ("CO", ("none", True, ())),
        ("C[LO]", ("none", True, None)),
        ("C.L", ("once", False, None)),
        ("C[DS][<L.>O]", ("once", True, None)),
        ("C.+L", ("some", False, None)),
        ("C[DS][DS]+[LO]", ("more", True, None)),
        ("C.* <L.'/a/b'>", ("any", False, ("/a/b",))),
        ("C.[<L.'a'><L.'b'>]", ("once", False, ("a", "b"))),
    ],
)
def test_light_path_expressions(expression: str, said: tuple[Any, ...]) -> None:
    found = light_paths.parse(expression)
    assert (found.events, found.emission, found.labels) == said


@pytest.mark.parametrize(
    "expression", ["", "L.*C", "C<RD>L", "CDL", "C...L", "C.", "C.*<L.'a'>O", "C.*[]", "C.*X"]
)
def test_light_path_expressions_that_are_not_understood(expression: str) -> None:
    with pytest.raises(ValueError, match=r"[a-z]"):
        light_paths.parse(expression)
    assert not is_aov(f"lpe:{expression}")


def test_primvars_have_the_channels_of_their_type() -> None:
    assert primvar_aov("st", "float2") == "primvars:st as float2"
    assert primvar_aov("st", "token") == "primvars:st"
    for kind, letters in (
        ("float", ()),
        ("color3f", "RGB"),
        ("normal3f", "XYZ"),
        ("color4f", "RGBA"),
    ):
        assert aov(primvar_aov("a:b", kind)).letters == tuple(letters)
    assert aov("primvars:a:b as float").source == "primvars:a:b"
    assert not is_aov("primvars:")
    assert not is_aov("primvars:a as nonsense")


@pytest.mark.parametrize(
    ("frame", "rate", "bits"),
    [(0, 24, 0), (24 * 61 + 5, 24, 0x00010105), (86400 * 24, 24, None), (-1, 24, None),
     (30, 29.97, 0x100), (1, 0.2, None)],
)  # fmt: skip
def test_time_codes(frame: int, rate: float, bits: int | None) -> None:
    code = time_code(frame, rate)
    assert (code.bits if code else None) == bits


def test_aovs_that_do_not_exist_are_refused(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, STAGE)
    assert "no AOV 'nomal'" in failure("render", stage, "--aov", "nomal")
    assert "no name for an EXR layer" in failure("render", stage, "--aov", "a b=normal")
    assert "no AOV 'lpe:C<RD>L'" in failure("render", stage, "--aov", "lpe:C<RD>L")


def test_bench_measures_aovs_writing_and_cameras(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, STAGE)
    figures = tmp_path / "aovs.json"
    done = irt("bench", "aovs", stage, "-f", "1:2", "--size", "16x16", "--repeats", "1",
               "--json", str(figures))  # fmt: skip
    assert done.exit_code == 0, done.output
    found = json.loads(figures.read_text())
    assert found["frames"] == 2
    assert set(found["shares"]) == {
        "all AOVs, of the time of the first frame",
        "all AOVs, of the time of the shot",
        "writing hidden behind tracing",
        "saved by two cameras in one run",
    }
    assert all(seconds["median"] > 0 for seconds in found["seconds"].values())
