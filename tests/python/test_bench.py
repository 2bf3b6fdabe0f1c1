# SPDX-License-Identifier: Apache-2.0
"""`irt bench`: that it measures the right work and says so; not how fast it is."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf

import scenes
from cli_support import failure, irt
from irt_usd import _core
from irt_usd.bench import peers
from irt_usd.bench.scenes import FILES, BenchScene, load_scene
from irt_usd.bench.timing import Figure, Spread, interleave, ratios
from irt_usd.stage.mesh import MeshShape

SIZE = (32, 24)

HEAD = """#usda 1.0
(
    upAxis = "Y"
)

def Camera "Cam"
{
    float focalLength = 35
    double3 xformOp:translate = (0, 1, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

def SphereLight "Lamp"
{
    float inputs:intensity = 100
    double3 xformOp:translate = (3, 6, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

"""

BALL = 'def Sphere "Ball"\n{\n    double radius = 1\n}\n'

FLOOR = """def Mesh "Floor"
{
    int[] faceVertexCounts = [4, 3]
    int[] faceVertexIndices = [0, 1, 2, 3, 2, 4, 3]
    point3f[] points = [(-5, -1, 5), (5, -1, 5), (5, -1, -5), (-5, -1, -5), (0, 3, -7)]
    uniform token subdivisionScheme = "none"
}
"""

MODEL = f"""class Xform "_model"
{{
    {BALL}
    {FLOOR}
}}
"""


def instance(name: str, x: float) -> str:
    return f"""def Xform "{name}" (
    instanceable = true
    prepend references = </_model>
)
{{
    double3 xformOp:translate = ({x}, 0, 0)
    float xformOp:rotateY = 20
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateY"]
}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene of each kind, tiny."""
    instanced = MODEL + instance("a", -2) + instance("b", 1.5) + BALL.replace("Ball", "Own")
    texts = {"quadrics": BALL, "triangles": FLOOR, "pieces": FLOOR, "instances": instanced}
    for name, text in texts.items():
        layer = Sdf.Layer.CreateAnonymous()
        layer.ImportFromString(HEAD + text)
        layer.Export(str(tmp_path / FILES[name]))
    return tmp_path


def trace_bench(samples: int = 1) -> tuple[_core.TraceBench, _core.Renderer, dict[str, Any]]:
    """A bench, and a renderer of the same scene after its update."""
    state = scenes.initial()
    camera = _core.Camera(np.eye(4), (-0.6, 0.6, -0.5, 0.5))
    settings = _core.ViewSettings(24, 20, samples=samples, max_depth=5)
    bench = _core.TraceBench(state.fresh(), camera, settings, render_origin=(0, 0, 0))
    renderer = _core.Renderer(camera, settings)
    return bench, renderer, renderer.update(state.fresh())


@pytest.mark.parametrize("samples", [1, 4])
def test_recorded_rays_are_those_of_a_render(samples: int) -> None:
    bench, _, update = trace_bench(samples)
    assert bench.rays == update["rays"]
    assert bench.rays["refracted"] > 0
    assert bench.rays["shadow"] > 0


@pytest.mark.parametrize("threads", [1, 2])
def test_the_bench_renders_what_a_renderer_does(threads: int) -> None:
    bench, renderer, _ = trace_bench()
    bench.rays  # noqa: B018 - recording must not touch the film
    assert bench.render(threads) > 0
    assert bench.beauty().tobytes() == renderer.beauty().tobytes()


def test_the_bare_loop_meets_what_we_meet() -> None:
    bench, _, _ = trace_bench()
    rays = bench.rays
    queries = rays["primary"] + rays["reflected"] + rays["refracted"]
    seconds, bare = bench.time("bare", "nearest")
    _, ours = bench.time("ours", "nearest")
    assert seconds > 0
    assert 0 < ours < queries
    assert abs(bare - ours) <= 0.01 * queries
    assert bench.time("ours", "occlusion")[1] <= bench.time("bare", "occlusion")[1] + 2


def test_unknown_loops_are_refused() -> None:
    bench, _, _ = trace_bench()
    with pytest.raises(ValueError, match="neither bare nor ours"):
        bench.time("other", "nearest")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="neither nearest nor occlusion"):
        bench.time("bare", "other")  # type: ignore[arg-type]


def film(scene: BenchScene, changes: _core.ChangeSet) -> np.ndarray:
    settings = _core.ViewSettings(*scene.shot.size)
    renderer = _core.Renderer(scene.camera, settings, render_origin=scene.shot.render_origin)
    renderer.update(changes)
    return renderer.beauty().copy()


def test_native_instances_are_instanced(folder: Path) -> None:
    scene = load_scene("instances", folder, SIZE)
    assert scene.contents == "2 instances, 2 quadrics, 3 triangles"
    baked = _core.ChangeSet()
    for states in (scene.snapshot.materials, scene.snapshot.lights, scene.snapshot.objects):
        for state in states.values():
            state.add_to(baked)
    differing = np.abs(film(scene, scene.changes) - film(scene, baked)).max(axis=2) > 1e-4
    assert differing.mean() < 0.01


def test_json_tells_what_was_measured(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "out" / "bench.json"
    result = irt(
        *("bench", "trace", "--scenes", str(folder), "--size", "32x24", "--repeats", "2"),
        *("--no-peers", "--json", str(target)),
    )
    assert result.exit_code == 0, result.output
    written = json.loads(target.read_text())
    assert set(written) == {"machine", "isa", "repeats", "scenes", "peers"}
    assert written["repeats"] == 2
    assert written["peers"] == []
    assert [scene["scene"] for scene in written["scenes"]] == list(FILES)
    for scene in written["scenes"]:
        assert scene["size"] == [32, 24]
        assert scene["rays"]["primary"] == 32 * 24
        assert scene["hits"]["ours nearest"] == scene["hits"]["bare nearest"] > 0
        assert all(0 < s["low"] <= s["median"] <= s["high"] for s in scene["seconds"].values())
        targets = {f["name"]: (f["floor"], f["aim"]) for f in scene["figures"]}
        assert targets["intersection"] == (0.7, 0.9)
        assert targets["with shading and film"] == (0.5, 0.7)
        assert targets["2 threads over 1"] == (1.9, None)
        assert all(f["ratio"]["median"] > 0 for f in scene["figures"])
        assert all(speed > 0 for speed in scene["rays_per_second"].values())


def test_one_scene(folder: Path) -> None:
    result = irt(
        *("bench", "trace", "--scenes", str(folder), "--size", "8x8", "--repeats", "1"),
        *("--scene", "quadrics"),
    )
    assert result.exit_code == 0, result.output
    assert "quadrics: 1 quadrics; 8x8; rays: 64 primary" in result.output
    assert "intersection" in result.output
    assert "triangles" not in result.output


def test_without_mitsuba_a_line_says_how_to_get_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(peers, "is_installed", lambda: False)
    result = irt(
        *("bench", "trace", "--scenes", str(folder), "--size", "8x8", "--repeats", "1"),
        *("--scene", "triangles"),
    )
    assert result.exit_code == 0, result.output
    assert "pip install" in result.stderr


def test_scenes_that_are_not_there(tmp_path: Path) -> None:
    message = failure("bench", "trace", "--scenes", str(tmp_path), "--no-peers")
    assert str(tmp_path / FILES["quadrics"]) in message
    assert "make bench" in message


def test_a_variant_that_cannot_start_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(peers, "VARIANTS", {"no_such_variant": (None, None)})
    scene = load_scene("triangles", folder, SIZE)
    result = peers.compare(scene, 1, 1, lambda _: None)
    assert list(result.absent) == ["no_such_variant"]
    assert result.absent["no_such_variant"]
    assert result.figures == ()
    assert result.paths_per_second["irt"] > 0


@pytest.mark.skipif(
    not peers.is_installed(), reason="Mitsuba 3 is not installed: make bench installs it"
)
def test_mitsuba_renders_the_same_image(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "VARIANTS", {"scalar_rgb": (2.0, None)})
    scene = load_scene("triangles", folder, (160, 120))
    result = peers.compare(scene, 1, 1, lambda _: None)
    assert result.absent == {}
    assert result.differences["scalar_rgb"] < 0.02
    assert [figure.name for figure in result.figures] == ["irt over scalar_rgb"]


def test_fans_start_at_the_first_vertex() -> None:
    attributes = {
        "faceVertexCounts": np.array([3, 2, 5], np.int32),
        "faceVertexIndices": np.array([0, 1, 2, 7, 7, 3, 4, 5, 6, 7], np.int32),
    }
    assert peers.fans(MeshShape(attributes, 1.0)).tolist() == [
        [0, 1, 2],
        [3, 4, 5],
        [3, 5, 6],
        [3, 6, 7],
    ]


def test_images_compare_by_blocks() -> None:
    ours = np.ones((17, 16, 3), np.float32)
    theirs = ours.copy()
    assert peers.difference(ours, theirs) == 0
    theirs[0, 0] = 0.5  # noise of one pixel
    theirs[0, 1] = 1.5
    assert peers.difference(ours, theirs) == 0
    assert peers.difference(1.1 * ours, ours) == pytest.approx(0.1, rel=1e-5)


def test_rounds_are_interleaved() -> None:
    order: list[str] = []

    def timer(name: str) -> Any:
        def once() -> float:
            order.append(name)
            return float(len(order))

        return once

    seconds = interleave({"a": timer("a"), "b": timer("b")}, 3)
    assert "".join(order) == "abbaab"
    assert seconds == {"a": [1.0, 4.0, 5.0], "b": [2.0, 3.0, 6.0]}
    assert ratios(seconds["a"], [1.0, 1.0, 1.0]) == Spread(4.0, 1.0, 5.0)


@pytest.mark.parametrize(
    ("median", "floor", "aim", "verdict"),
    [
        (0.6, 0.7, 0.9, "floor missed"),
        (0.8, 0.7, 0.9, "aim missed"),
        (0.9, 0.7, 0.9, "aim reached"),
        (2.0, 1.9, None, "floor reached"),
        (0.9, None, 1.0, "aim missed"),
        (0.9, None, None, ""),
    ],
)
def test_verdicts(median: float, floor: float | None, aim: float | None, verdict: str) -> None:
    assert Figure("x", Spread(median, median, median), floor, aim).verdict == verdict
