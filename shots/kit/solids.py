# SPDX-License-Identifier: Apache-2.0
"""UsdGeom's solids, standing on a height. Centimetres, y up."""

from typing import TypeVar

from pxr import Gf, Usd, UsdGeom

Solid = TypeVar("Solid", UsdGeom.Cone, UsdGeom.Cylinder, UsdGeom.Capsule)


class Turner:
    """Stacks solids on the y axis below one prim; `stage` and `path` say where."""

    def __init__(self, stage: Usd.Stage, path: str) -> None:
        self.stage = stage
        self.path = path

    def sphere(
        self,
        name: str,
        radius: float,
        center: tuple[float, float, float],
        scale: tuple[float, float, float] | None = None,
    ) -> UsdGeom.Sphere:
        """Define a sphere, or an ellipsoid by `scale`."""
        solid = UsdGeom.Sphere.Define(self.stage, f"{self.path}/{name}")
        solid.CreateRadiusAttr(radius)
        solid.AddTranslateOp().Set(Gf.Vec3d(*center))
        if scale is not None:
            solid.AddScaleOp().Set(Gf.Vec3f(*scale))
        return solid

    def bulge(self, name: str, radius: float, thickness: float, y: float) -> UsdGeom.Sphere:
        """Define a flat ellipsoid of revolution, its middle at height `y`."""
        return self.sphere(name, radius, (0, y, 0), (1, thickness / (2 * radius), 1))

    def cylinder(self, name: str, radius: float, y: float, height: float) -> UsdGeom.Cylinder:
        """Define a cylinder that stands on height `y`."""
        return self._stand(UsdGeom.Cylinder, name, radius, y, height)

    def cone(self, name: str, radius: float, y: float, height: float) -> UsdGeom.Cone:
        """Define a cone that stands on height `y`."""
        return self._stand(UsdGeom.Cone, name, radius, y, height)

    def cup(self, name: str, radius: float, y: float, height: float) -> UsdGeom.Cone:
        """Define a cone on its apex at height `y`."""
        solid = self._stand(UsdGeom.Cone, name, radius, y, height)
        solid.AddRotateXOp().Set(180.0)
        return solid

    def capsule(self, name: str, radius: float, y: float, height: float) -> UsdGeom.Capsule:
        """Define a capsule from height `y`, `height` with its caps."""
        solid = self._stand(UsdGeom.Capsule, name, radius, y, height)
        solid.GetHeightAttr().Set(height - 2 * radius)
        return solid

    def box(
        self,
        name: str,
        size: tuple[float, float, float],
        center: tuple[float, float, float],
        turn: float = 0.0,
    ) -> UsdGeom.Cube:
        """Define a box, turned by `turn` degrees about the y axis before it is moved."""
        solid = UsdGeom.Cube.Define(self.stage, f"{self.path}/{name}")
        solid.CreateSizeAttr(1.0)
        if turn:
            solid.AddRotateYOp().Set(turn)
        solid.AddTranslateOp().Set(Gf.Vec3d(*center))
        solid.AddScaleOp().Set(Gf.Vec3f(*size))
        return solid

    def _stand(self, kind: type[Solid], name: str, radius: float, y: float, height: float) -> Solid:
        solid = kind.Define(self.stage, f"{self.path}/{name}")
        solid.CreateAxisAttr(UsdGeom.Tokens.y)
        solid.CreateRadiusAttr(radius)
        solid.CreateHeightAttr(height)
        solid.AddTranslateOp().Set(Gf.Vec3d(0, y + height / 2, 0))
        return solid
