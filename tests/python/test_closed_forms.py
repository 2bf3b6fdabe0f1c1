# SPDX-License-Identifier: Apache-2.0
"""The tracer against closed forms: areas, mirrors, Snell's law, falloff, shadow edges."""

import math

import numpy as np
import pytest

from irt_usd import _core

IDENTITY = np.eye(4)


def placed(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[3, :3] = (x, y, z)
    return matrix


def camera(half: float = 1.0, orthographic: bool = False) -> _core.Camera:
    """At the origin, looking along -z; the window is 2 half wide and high."""
    return _core.Camera(IDENTITY, (-half, half, -half, half), orthographic)


def render(
    changes: _core.ChangeSet,
    *,
    size: tuple[int, int] = (64, 64),
    view: _core.Camera | None = None,
    aovs: tuple[str, ...] = (),
    samples: int = 1,
    **settings: float,
) -> _core.Renderer:
    renderer = _core.Renderer(
        view or camera(),
        _core.ViewSettings(*size, samples=samples, aovs=aovs, **settings),  # type: ignore[arg-type]
    )
    renderer.update(changes)
    return renderer


def scene(**materials: _core.Material) -> _core.ChangeSet:
    changes = _core.ChangeSet()
    for name, material in materials.items():
        changes.set_material("/" + name, material)
    return changes


MATT = _core.Material(diffuse_color=(1, 1, 1), specular_color=(0, 0, 0), ior=1.0)


def test_silhouette_of_a_sphere_has_the_area_of_its_cone() -> None:
    """A sphere of radius r at distance d covers a disc of radius r / sqrt(d^2 - r^2)."""
    changes = scene(matt=MATT)
    changes.set_object("/ball", _core.Quadric.sphere(1.0), placed(0, 0, -4), "/matt")
    size = 512
    alpha = render(changes, size=(size, size), view=camera(0.5)).beauty()[..., 3]
    expected = math.pi / (4**2 - 1)
    assert alpha.sum() / size**2 == pytest.approx(expected, rel=2e-3)


def test_mirror_shows_the_image_at_its_mirrored_place() -> None:
    """A ball before a mirror is seen where its mirror image stands, at the path's length."""
    changes = scene(
        mirror=_core.Material(metallic=1, roughness=0, diffuse_color=(1, 1, 1)),
        glow=_core.Material(emissive_color=(1, 0, 0), diffuse_color=(0, 0, 0)),
    )
    changes.set_object("/mirror", _core.Quadric.plane(40, 40), placed(0, 0, -10), "/mirror")
    # Behind the camera, up and to the right; its image stands at z = -20 - 6.
    changes.set_object("/ball", _core.Quadric.sphere(0.5), placed(3, 2, 6), "/glow")
    red = render(changes, size=(400, 400), view=camera(0.2)).beauty()[..., 0]
    rows, columns = np.nonzero(red > 0.5)
    image = np.array([3 / 26, 2 / 26])
    centre = np.array([(columns.mean() + 0.5) / 200 - 1, 1 - (rows.mean() + 0.5) / 200]) * 0.2
    assert centre == pytest.approx(image, abs=0.2 / 400)
    assert len(rows) * 0.001**2 == pytest.approx(math.pi * (0.5 / 26) ** 2, rel=0.02)


@pytest.mark.parametrize("ior", [1.2, 1.5, 2.4])
def test_glass_slab_shifts_by_snells_law(ior: float) -> None:
    """A ray at 45 degrees leaves a slab of thickness 1 parallel to itself, shifted by
    sin(a - b) / cos(b)."""
    changes = scene(
        glass=_core.Material(opacity=0, ior=ior, roughness=0.5),
        glow=_core.Material(emissive_color=(1, 1, 1), diffuse_color=(0, 0, 0)),
    )
    changes.set_object("/slab", _core.Quadric.cube(1.0), np.diag([50.0, 50, 1, 1]), "/glass")
    angle = math.radians(45)
    bent = math.asin(math.sin(angle) / ior)
    # Behind the slab, a wall that glows where x exceeds the exit point of the ray through (0, 0).
    turned = np.eye(4)
    turned[0, :3] = (math.cos(angle), 0, -math.sin(angle))
    turned[2, :3] = (math.sin(angle), 0, math.cos(angle))
    turned[3, :3] = (10 * math.sin(angle), 0, 10 * math.cos(angle))
    view = _core.Camera(turned, (-0.001, 0.001, -0.001, 0.001), True)

    def lit(edge: float) -> bool:
        wall = placed(edge + 5, 0, -3)
        changes.set_object("/wall", _core.Quadric.plane(10, 10), wall, "/glow")
        return bool(render(changes, size=(1, 1), view=view).beauty()[0, 0, 0] > 0.5)

    # Along -z from the entry at x of the slab's front: tan(bent) inside, tan(angle) outside.
    entry = 10 * math.sin(angle) - (10 * math.cos(angle) - 0.5) * math.tan(angle)
    landing = entry - math.tan(bent) - 2.5 * math.tan(angle)
    assert lit(landing - 1e-4)
    assert not lit(landing + 1e-4)


def test_a_surface_present_in_part_mixes_with_what_is_behind() -> None:
    """Light, emission and clear coat are those of the surface, by its share."""
    seen = {}
    for presence in (1.0, 0.25, 0.0):
        changes = scene(
            matt=MATT,
            pane=_core.Material(
                diffuse_color=(0.5, 0.2, 0.1),
                emissive_color=(0.1, 0.2, 0.3),
                roughness=0.3,
                clearcoat=1.0,
                opacity=presence,
                opacity_is_presence=True,
            ),
        )
        changes.set_object("/wall", _core.Quadric.plane(100, 100), placed(0, 0, -9), "/matt")
        changes.set_object("/pane", _core.Quadric.plane(2, 2), placed(0, 0, -2), "/pane")
        changes.set_light("/key", _core.Light.distant((0, 0, -1), (1, 1, 1), False))
        seen[presence] = render(changes).beauty()[..., :3].astype(float)
    assert (seen[1.0] != seen[0.0]).any()
    np.testing.assert_allclose(seen[0.25], 0.25 * seen[1.0] + 0.75 * seen[0.0], rtol=1e-5)


@pytest.mark.parametrize(("presence", "passed"), [(False, 0.75 * 0.5), (True, 0.75)])
def test_shadow_of_a_transparent_pane(presence: bool, passed: float) -> None:
    """What is transmitted is tinted, what goes by is not."""
    pane = _core.Material(diffuse_color=(0.5, 0.5, 0.5), opacity=0.25, opacity_is_presence=presence)
    changes = scene(matt=MATT, pane=pane)
    changes.set_object("/wall", _core.Quadric.plane(100, 100), placed(0, 0, -1), "/matt")
    changes.set_light("/key", _core.Light.distant((0, 0, -1), (1, 1, 1)))
    open_level = render(changes, size=(1, 1)).beauty()[0, 0, 0]
    changes.set_object("/pane", _core.Quadric.plane(9, 9), placed(0, 0, 3), "/pane")
    assert render(changes, size=(1, 1)).beauty()[0, 0, 0] / open_level == pytest.approx(
        passed, rel=2e-4
    )


def test_point_light_falls_off_by_the_inverse_square() -> None:
    changes = scene(matt=MATT)
    changes.set_object("/wall", _core.Quadric.plane(100, 100), placed(0, 0, -1), "/matt")
    levels = []
    for distance in (1.0, 2.0, 4.0, 1000.0):
        changes.set_light("/lamp", _core.Light.point((0, 0, distance - 1), (math.pi, 0, 0)))
        levels.append(render(changes, size=(1, 1)).beauty()[0, 0, 0] * distance**2)
    # A white Lambert wall under intensity pi at normal incidence: 1 / distance^2.
    assert levels == pytest.approx([1, 1, 1, 1], rel=1e-6)


def test_distant_light_goes_by_the_cosine() -> None:
    changes = scene(matt=MATT)
    changes.set_object("/wall", _core.Quadric.plane(100, 100), placed(0, 0, -1), "/matt")
    for degrees in (0, 30, 60, 85):
        angle = math.radians(degrees)
        direction = (math.sin(angle), 0, -math.cos(angle))
        changes.set_light("/sun", _core.Light.distant(direction, (math.pi,) * 3))
        level = render(changes, size=(1, 1)).beauty()[0, 0, 1]
        # The dielectric's Fresnel rises to 1 at grazing incidence, by Schlick's fifth power.
        fresnel = (1 - math.cos(angle / 2)) ** 5
        assert level == pytest.approx(math.cos(angle), rel=1e-6 + 2 * fresnel)


def test_shadow_edge_lies_where_the_tangent_ray_lands() -> None:
    """A card of half width 1 at height 2, a lamp at height 4: a shadow of half width 2."""
    changes = scene(matt=MATT)
    changes.set_object("/floor", _core.Quadric.plane(100, 100), placed(0, 0, -10), "/matt")
    changes.set_object("/card", _core.Quadric.plane(2, 2), placed(0, 0, -8), "/matt")
    changes.set_light("/lamp", _core.Light.point((0, 0, -6), (math.pi,) * 3))
    size = 1000
    # From below the card one could not see it; an oblique view is not needed: look beside it.
    image = render(changes, size=(size, 1), view=camera(0.5)).beauty()[0, :, 0]
    x = ((np.arange(size) + 0.5) / size - 0.5) * 10
    beyond_card = np.abs(x) > 1.3
    dark = image == 0
    assert np.all(dark[beyond_card & (np.abs(x) < 1.99)])
    assert not np.any(dark[np.abs(x) > 2.01])


def test_shadow_of_glass_is_tinted_once_for_each_primitive() -> None:
    changes = scene(matt=MATT, pane=_core.Material(opacity=0.5, diffuse_color=(1, 0.5, 0), ior=1.0))
    changes.set_object("/floor", _core.Quadric.plane(100, 100), placed(0, 0, -1), "/matt")
    changes.set_light("/sun", _core.Light.distant((0, 0, -1), (math.pi,) * 3))
    for panes, expected in ((1, (0.5, 0.25, 0)), (2, (0.25, 0.0625, 0))):
        for i in range(panes):
            where = placed(0, 0, 1 + i)  # behind the camera: between sun and floor
            changes.set_object(f"/pane{i}", _core.Quadric.plane(10, 10), where, "/pane")
        pixel = render(changes, size=(1, 1)).beauty()[0, 0, :3]
        # Quantised to 1/4096 octave a pane.
        assert pixel == pytest.approx(np.array(expected), rel=panes * 1.7e-4, abs=1e-12)


def test_total_internal_reflection_begins_at_the_critical_angle() -> None:
    """Seen from inside glass of index 1.5, a face turns from window to mirror at asin(1/1.5)."""
    changes = scene(
        glass=_core.Material(opacity=0, ior=1.5, roughness=0.5),
        glow=_core.Material(emissive_color=(1, 1, 1), diffuse_color=(0, 0, 0)),
    )
    changes.set_object("/block", _core.Quadric.cube(1.0), np.diag([40.0, 40, 20, 1]), "/glass")
    changes.set_object("/sky", _core.Quadric.plane(1e5, 1e5), placed(0, 0, -30), "/glow")
    critical = math.asin(1 / 1.5)
    for angle, seen in ((critical - 1e-3, True), (critical + 1e-3, False)):
        turned = np.eye(4)
        turned[0, :3] = (math.cos(angle), 0, -math.sin(angle))
        turned[2, :3] = (math.sin(angle), 0, math.cos(angle))
        turned[3, :3] = (0, 0, -5)
        view = _core.Camera(turned, (-1e-6, 1e-6, -1e-6, 1e-6))
        pixel = render(changes, size=(1, 1), view=view, max_depth=1).beauty()[0, 0, 0]
        assert (pixel > 0) == seen


def test_aovs_agree_with_geometry() -> None:
    changes = scene(matt=_core.Material(diffuse_color=(0.25, 0.5, 0.75)))
    changes.set_object("/ball", _core.Quadric.sphere(1.0), placed(0.5, 0.25, -5), "/matt")
    renderer = render(
        changes, view=camera(0.3), aovs=("depth", "normal", "position", "albedo", "objectId")
    )
    hit = renderer.beauty()[..., 3] == 1
    position = renderer.aov("position")[hit].astype(np.float64)
    centred = position - (0.5, 0.25, -5)
    assert hit.any()
    assert not hit.all()
    assert np.linalg.norm(centred, axis=1) == pytest.approx(np.ones(hit.sum()), rel=1e-6)
    assert renderer.aov("normal")[hit] == pytest.approx(centred, abs=2e-6)
    assert renderer.aov("depth")[hit] == pytest.approx(-position[:, 2], rel=1e-6)
    assert np.all(renderer.aov("albedo")[hit] == np.array((0.25, 0.5, 0.75), np.float32))
    assert len(np.unique(renderer.aov("objectId")[hit])) == 1
    assert np.all(renderer.aov("objectId")[~hit] == 0)


def test_refraction_is_tinted_at_each_surface() -> None:
    """Two panes of index 1, seen head on, reflect nothing and tint twice."""
    tint = (0.5, 0.25, 1.0)
    pane = _core.Material(opacity=0.0, ior=1.0, transmission_color=tint)
    changes = scene(
        pane=pane, lamp=_core.Material(diffuse_color=(0, 0, 0), emissive_color=(1, 1, 1))
    )
    square = np.array([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], "f4")
    mesh = _core.Mesh(square, np.array([4], np.int32), np.arange(4, dtype=np.int32))
    for name, depth, material in (("a", -2, "pane"), ("b", -3, "pane"), ("wall", -4, "lamp")):
        changes.set_object("/" + name, mesh, placed(0, 0, depth), "/" + material)
    seen = render(changes, size=(1, 1), view=camera(1e-3)).beauty()[0, 0, :3]
    assert seen == pytest.approx([t * t for t in tint], rel=1e-6)
