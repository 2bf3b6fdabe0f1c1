# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes: turned, lofted, extruded. Faces wind counter-clockwise seen from outside."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, Vt

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PolygonMesh:
    """Points (n, 3), vertices a face (f,), vertices (c,), and one normal (n, 3) a point or None."""

    points: Array
    counts: NDArray[np.int32]
    indices: NDArray[np.int32]
    normals: Array | None = None


def define_mesh(stage: Usd.Stage, path: str, mesh: PolygonMesh, decimals: int = 4) -> Usd.Prim:
    """Define `mesh` as a polygon mesh (not subdivided), its numbers rounded to `decimals`."""
    prim = UsdGeom.Mesh.Define(stage, path)
    points = _vec3f(mesh.points, decimals)
    prim.CreatePointsAttr(points)
    prim.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(mesh.counts))
    prim.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(mesh.indices))
    prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    prim.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    if mesh.normals is not None:
        prim.CreateNormalsAttr(_vec3f(mesh.normals, decimals))
        prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    return prim.GetPrim()


def _vec3f(values: Array, decimals: int) -> Vt.Vec3fArray:
    rounded = np.round(values, decimals) + 0.0  # + 0.0: no negative zeros
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rounded, dtype=np.float32))


def smooth(controls: Sequence[Sequence[float]], per_span: int) -> Array:
    """A Catmull-Rom curve through `controls`, `per_span` points a span and the last control."""
    c = np.asarray(controls, dtype=np.float64)
    padded = np.vstack([2 * c[0] - c[1], c, 2 * c[-1] - c[-2]])
    u = np.linspace(0, 1, per_span, endpoint=False)[:, None]
    spans = [
        0.5
        * (
            2 * p1
            + (p2 - p0) * u
            + (2 * p0 - 5 * p1 + 4 * p2 - p3) * u**2
            + (3 * p1 - p0 - 3 * p2 + p3) * u**3
        )
        for p0, p1, p2, p3 in zip(padded, padded[1:], padded[2:], padded[3:], strict=False)
    ]
    return np.vstack([*spans, c[-1:]])


def grid(points: Array, normals: Array | None, closed: bool) -> PolygonMesh:
    """Quads over points (rows, columns, 3); `closed` joins the last column to the first.

    The outside is where rows run up and columns run to the right.
    """
    rows, columns = points.shape[:2]
    row = np.arange(rows - 1)[:, None] * columns
    right = np.arange(columns if closed else columns - 1)
    following = (right + 1) % columns
    corners = (row + right, row + following, row + columns + following, row + columns + right)
    indices = np.stack(corners, axis=-1)
    return PolygonMesh(
        points.reshape(-1, 3),
        np.full(indices.size // 4, 4, dtype=np.int32),
        indices.reshape(-1).astype(np.int32),
        None if normals is None else normals.reshape(-1, 3),
    )


def polygon(points: Array, normal: Sequence[float] | Array) -> PolygonMesh:
    """One convex polygon."""
    n = len(points)
    return PolygonMesh(
        points,
        np.array([n], dtype=np.int32),
        np.arange(n, dtype=np.int32),
        np.tile(np.asarray(normal, dtype=np.float64), (n, 1)),
    )


def join(parts: Sequence[PolygonMesh]) -> PolygonMesh:
    """All parts as one mesh; either all or none of them have normals."""
    first = np.cumsum([0] + [len(part.points) for part in parts])
    normals = [part.normals for part in parts if part.normals is not None]
    return PolygonMesh(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.counts for part in parts]),
        np.concatenate(
            [part.indices + np.int32(start) for part, start in zip(parts, first[:-1], strict=True)]
        ),
        np.concatenate(normals) if normals else None,
    )


def lathe(strips: Sequence[Array], segments: int) -> PolygonMesh:
    """Turn profiles around the y axis into one closed solid.

    `strips` are (n, 2) arrays of (radius, y), each smooth, creased where they meet, from the foot
    (radius above 0, closed by a polygon) to the top (radius 0).
    """
    angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    # Seen from outside, columns to the right: the angle turns from +z to +x.
    around = np.stack([np.sin(angle), np.cos(angle)], axis=-1)

    def turn(strip: Array) -> PolygonMesh:
        along = np.gradient(strip, axis=0)
        if strip[-1, 0] == 0:
            along[-1] = (-1, 0)
        out = np.stack([along[:, 1], -along[:, 0]], axis=-1)
        out /= np.linalg.norm(out, axis=-1, keepdims=True)
        points, normals = _revolve(strip, around), _revolve(out, around)
        if strip[-1, 0] == 0:
            return _close_at_top(points, normals)
        return grid(points, normals, closed=True)

    foot = _revolve(strips[0][:1], around)[0][::-1]
    return join([polygon(foot, (0, -1, 0)), *(turn(strip) for strip in strips)])


def _revolve(pairs: Array, around: Array) -> Array:
    radius, y = pairs[:, 0, None], pairs[:, 1, None]
    x, z = radius * around[None, :, 0], radius * around[None, :, 1]
    return np.stack([x, np.broadcast_to(y, x.shape), z], axis=-1)


def _close_at_top(points: Array, normals: Array) -> PolygonMesh:
    """A closed grid whose last row is one point, reached by triangles."""
    body = grid(points[:-1], normals[:-1], closed=True)
    pole, columns = len(body.points), points.shape[1]
    last = np.arange(pole - columns, pole, dtype=np.int32)
    fan = np.stack([last, np.roll(last, -1), np.full_like(last, pole)], axis=-1)
    return PolygonMesh(
        np.vstack([body.points, points[-1, :1]]),
        np.concatenate([body.counts, np.full(columns, 3, dtype=np.int32)]),
        np.concatenate([body.indices, fan.reshape(-1)]),
        np.vstack([normals[:-1].reshape(-1, 3), normals[-1, :1]]),
    )


def loft(rings: Array) -> PolygonMesh:
    """Skin closed rings (rings, columns, 3) that run upwards, with a polygon at either end."""
    along = np.gradient(rings, axis=0)
    right = np.roll(rings, -1, axis=1) - np.roll(rings, 1, axis=1)
    normals = np.cross(right, along)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    first, last = rings[0][::-1], rings[-1]
    return join(
        [
            polygon(first, _polygon_normal(first)),
            grid(rings, normals, closed=True),
            polygon(last, _polygon_normal(last)),
        ]
    )


def _polygon_normal(points: Array) -> Array:
    around = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    return np.asarray(around / np.linalg.norm(around))


def border(profile: Array) -> PolygonMesh:
    """A mitred square border: `profile` (n, 2) of (half width, y), outside to inside; facets."""
    corners = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)], dtype=np.float64)
    half, y = profile[:, 0, None], profile[:, 1, None]
    x, z = half * corners[None, :, 0], half * corners[None, :, 1]
    return grid(np.stack([x, np.broadcast_to(y, x.shape), z], axis=-1), None, closed=True)


def extrude(profile: Array, half_width: float) -> PolygonMesh:
    """A smooth sheet: `profile` (n, 2) of (z, y) from front to back, drawn out along x."""
    along = np.gradient(profile, axis=0)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)

    def sheet(pairs: Array, x: tuple[float, float]) -> Array:
        columns = [np.stack([np.full(len(pairs), v), pairs[:, 1], pairs[:, 0]], -1) for v in x]
        return np.stack(columns, axis=1)

    normal = np.stack([along[:, 1], -along[:, 0]], axis=-1)
    return grid(sheet(profile, (-half_width, half_width)), sheet(normal, (0, 0)), closed=False)
