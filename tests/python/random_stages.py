# SPDX-License-Identifier: Apache-2.0
"""Random shots as USD layers: every attribute of geometry that may vary with time does in some, and
every frame may hold another value, another count, or something that cannot be drawn."""

import random
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel

FRAMES = 5

Pick = Callable[[Sequence[Any]], Any]

_BOX = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
_QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
_TOPOLOGIES = (
    _QUADS,
    _QUADS[:5],
    [face for quad in _QUADS for face in (quad[:3], (quad[0], *quad[2:]))],
    [*_QUADS[:4], (0, 2, 6), (0, 6, 4)],
    [*_QUADS, (0, 0, 1), (0, 1)],
)
_COLORS = ((1, 0, 0), (0, 1, 0), (0.2, 0.2, 1), (0.5, 0.5, 0.5), (1, 1, 0))
_MATERIALS = ("/Looks/dyed", "/Looks/glass", "/Looks/mirror", None, None)
_INTERPOLATIONS = ("constant", "uniform", "vertex", "varying", "faceVarying")


def write(seed: int, folder: Path) -> Path:
    """The layer of that seed."""
    path = folder / f"random{seed}.usda"
    stage = Usd.Stage.CreateInMemory()
    _Maker(stage, random.Random(seed)).make()
    stage.GetRootLayer().Export(str(path))
    return path


class _Maker:
    def __init__(self, stage: Any, source: random.Random) -> None:
        self.stage = stage
        self.pick: Pick = source.choice
        self._source = source

    def chance(self, share: float) -> bool:
        return self._source.random() < share

    def number(self) -> float:
        return round(self._source.uniform(-1, 1), 2)

    def make(self) -> None:
        self.stage.SetStartTimeCode(1)
        self.stage.SetEndTimeCode(FRAMES)
        camera = UsdGeom.Camera.Define(self.stage, "/cam")
        camera.AddTranslateOp().Set((0, 1, 14))
        camera.CreateFocalLengthAttr(30)
        light = UsdLux.DistantLight.Define(self.stage, "/key")
        light.CreateAngleAttr(0)
        light.AddRotateXYZOp().Set((-50, 20, 0))
        self._materials()
        floor = UsdGeom.Mesh.Define(self.stage, "/floor")
        floor.CreatePointsAttr([(-8, -3, 8), (8, -3, 8), (8, -3, -8), (-8, -3, -8)])
        floor.CreateFaceVertexCountsAttr([4])
        floor.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
        floor.CreateSubdivisionSchemeAttr("none")
        kinds = (self._mesh, self._points, self._curves, self._instancer, self._skinned)
        for i in range(self.pick((1, 2, 2, 3))):
            self.pick(kinds)(f"/o{i}", (3.0 * i - 3, 0, 0))

    # ---- values

    def over_time(self, attribute: Any, value: Callable[[], Any], share: float) -> None:
        """One value, or one in some frames."""
        if not self.chance(share):
            attribute.Set(value())
            return
        for frame in range(1, FRAMES + 1):
            if frame == 1 or self.chance(0.6):
                attribute.Set(value(), frame)

    def wrong(self, count: int) -> int:
        """`count`, and now and then another."""
        return count if self.chance(0.97) else max(count + self.pick((-1, 1)), 0)

    def vectors(self, count: int, size: float = 1.0) -> list[tuple[float, float, float]]:
        return [
            (size * self.number(), size * self.number(), size * self.number())
            for _ in range(self.wrong(count))
        ]

    def place(self, prim: Any, offset: Sequence[float]) -> None:
        moved = UsdGeom.Xformable(prim).AddTranslateOp()
        self.over_time(
            moved.GetAttr(),
            lambda: Gf.Vec3d(*(a + b for a, b in zip(offset, self.vectors_of(0.5), strict=True))),
            0.3,
        )
        if self.chance(0.2):
            visible = UsdGeom.Imageable(prim).CreateVisibilityAttr()
            self.over_time(visible, lambda: self.pick(("inherited", "invisible")), 1)
        material = self.pick(_MATERIALS)
        if material:
            UsdShade.MaterialBindingAPI.Apply(prim).Bind(
                UsdShade.Material.Get(self.stage, material)
            )

    def vectors_of(self, size: float) -> tuple[float, float, float]:
        return size * self.number(), size * self.number(), size * self.number()

    def dye(self, prim: Any, counts: dict[str, Callable[[], int]]) -> None:
        """displayColor, displayOpacity and dye, in some interpolation, some with indices."""
        api = UsdGeom.PrimvarsAPI(prim)
        for name, share in (("displayColor", 0.7), ("dye", 0.7), ("displayOpacity", 0.2)):
            if not self.chance(share):
                continue
            interpolation = self.pick(tuple(counts))
            scalar = name == "displayOpacity"
            kind = Sdf.ValueTypeNames.FloatArray if scalar else Sdf.ValueTypeNames.Color3fArray
            primvar = api.CreatePrimvar(name, kind, interpolation)
            choices: Sequence[Any] = (1.0, 0.5, 0.25) if scalar else _COLORS
            count = counts[interpolation]
            if self.chance(0.3):
                primvar.Set(list(choices))
                indices = primvar.CreateIndicesAttr()
                self.over_time(indices, partial(self.some, range(len(choices)), count), 0.5)
            else:
                self.over_time(primvar.GetAttr(), partial(self.some, choices, count), 0.5)

    def some(self, choices: Sequence[Any], count: Callable[[], int]) -> list[Any]:
        return [self.pick(choices) for _ in range(self.wrong(count()))]

    # ---- prims

    def _materials(self) -> None:
        for name in ("dyed", "glass", "mirror"):
            material = UsdShade.Material.Define(self.stage, f"/Looks/{name}")
            shader = UsdShade.Shader.Define(self.stage, f"/Looks/{name}/S")
            shader.CreateIdAttr("UsdPreviewSurface")
            shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
            material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
            values: dict[str, float] = {"roughness": 0.0}
            if name == "glass":
                values["opacity"] = 0.2
            elif name == "mirror":
                values["metallic"] = 1.0
            else:
                values = {"opacity": self.pick((1.0, 1.0, 0.5))}
                reader = UsdShade.Shader.Define(self.stage, "/Looks/dyed/R")
                reader.CreateIdAttr("UsdPrimvarReader_float3")
                reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("dye")
                reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
                color = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
                color.ConnectToSource(reader.ConnectableAPI(), "result")
            for key, value in values.items():
                shader.CreateInput(key, Sdf.ValueTypeNames.Float).Set(value)

    def _mesh(self, path: str, offset: Sequence[float]) -> None:
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        self.place(mesh.GetPrim(), offset)
        self._shape(mesh)

    def _shape(self, mesh: Any) -> None:
        faces = self.pick(_TOPOLOGIES)
        self.over_time(
            mesh.CreatePointsAttr(),
            lambda: [
                tuple(a + 0.3 * b for a, b in zip(point, self.vectors_of(1), strict=True))
                for point in _BOX
            ],
            0.6,
        )
        if self.chance(0.2):
            for frame in range(1, FRAMES + 1):
                faces = self.pick(_TOPOLOGIES)
                mesh.CreateFaceVertexCountsAttr().Set([len(f) for f in faces], frame)
                mesh.CreateFaceVertexIndicesAttr().Set([i for f in faces for i in f], frame)
        else:
            mesh.CreateFaceVertexCountsAttr([len(f) for f in faces])
            mesh.CreateFaceVertexIndicesAttr([i for f in faces for i in f])
        mesh.CreateSubdivisionSchemeAttr(
            self.pick(("none", "catmullClark", "catmullClark", "loop", "bilinear"))
        )
        mesh.CreateInterpolateBoundaryAttr(self.pick(("none", "edgeOnly", "edgeAndCorner")))
        mesh.CreateFaceVaryingLinearInterpolationAttr(
            self.pick(("none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"))
        )
        mesh.CreateOrientationAttr(self.pick(("rightHanded", "leftHanded")))
        if self.chance(0.2):
            mesh.CreateDoubleSidedAttr(False)
        if self.chance(0.5):
            indices = self.pick(([0, 1, 3, 2], [0, 1, 0, 4], [0, 1, 5, 77], [2, 5, 0, 1]))
            mesh.CreateCreaseIndicesAttr(indices)
            mesh.CreateCreaseLengthsAttr(self.pick(([2, 2], [2, 2], [4])))
            sharp = self.pick((1, 2, 3))
            self.over_time(
                mesh.CreateCreaseSharpnessesAttr(),
                lambda: [self.pick((0.0, 1.0, 2.5, 10.0)) for _ in range(sharp)],
                0.5,
            )
        if self.chance(0.4):
            self.over_time(
                mesh.CreateCornerIndicesAttr(), lambda: [self.pick(range(8)) for _ in "ab"], 0.5
            )
            self.over_time(
                mesh.CreateCornerSharpnessesAttr(),
                lambda: [self.pick((0.5, 2.0, 10.0)) for _ in "ab"],
                0.5,
            )
        if self.chance(0.3):
            self.over_time(
                mesh.CreateHoleIndicesAttr(), lambda: self.pick(([], [0], [1, 3], [2])), 0.6
            )
        if self.chance(0.3):
            self.over_time(mesh.CreateNormalsAttr(), lambda: self.vectors(len(_BOX)), 0.5)
        corners = sum(map(len, faces))
        counts = {
            "constant": lambda: 1,
            "uniform": lambda: len(faces),
            "vertex": lambda: len(_BOX),
            "varying": lambda: len(_BOX),
            "faceVarying": lambda: corners,
        }
        self.dye(mesh.GetPrim(), counts)

    def _points(self, path: str, offset: Sequence[float]) -> None:
        points = UsdGeom.Points.Define(self.stage, path)
        self.place(points.GetPrim(), offset)
        count = self.pick((1, 3, 6))
        self.over_time(points.CreatePointsAttr(), lambda: self.vectors(count, 1.5), 0.6)
        self._widths(points, {"constant": 1, "vertex": count, "varying": count})
        self.dye(
            points.GetPrim(),
            {"constant": lambda: 1, "vertex": lambda: count, "varying": lambda: count},
        )

    def _widths(self, prim: Any, counts: dict[str, int]) -> None:
        if self.chance(0.1):
            return
        interpolation = self.pick(tuple(counts))
        prim.SetWidthsInterpolation(interpolation)
        self.over_time(
            prim.CreateWidthsAttr(),
            lambda: [self.pick((0.0, 0.2, 0.5, 0.8)) for _ in range(counts[interpolation])],
            0.5,
        )

    def _curves(self, path: str, offset: Sequence[float]) -> None:
        curves = UsdGeom.BasisCurves.Define(self.stage, path)
        self.place(curves.GetPrim(), offset)
        basis = self.pick(("linear", "bezier", "bspline", "catmullRom"))
        wrap = self.pick(("nonperiodic", "periodic", "pinned"))
        curves.CreateTypeAttr("linear" if basis == "linear" else "cubic")
        if basis != "linear":
            curves.CreateBasisAttr(basis)
        curves.CreateWrapAttr(wrap)
        each = self.pick((6, 9)) if wrap == "periodic" else self.pick((4, 7))
        number = self.pick((1, 2))
        curves.CreateCurveVertexCountsAttr([each] * number)
        total = each * number
        step = 3 if basis == "bezier" else 1
        if wrap == "periodic":
            ends = each // step
        elif basis == "linear" or (wrap == "pinned" and basis != "bezier"):
            ends = each
        else:
            ends = (each - 4) // step + 2
        self.over_time(curves.CreatePointsAttr(), lambda: self.vectors(total, 1.5), 0.6)
        sizes = {"constant": 1, "uniform": number, "vertex": total, "varying": ends * number}
        self._widths(curves, sizes)
        if self.chance(0.5):
            interpolation = self.pick(tuple(sizes))
            curves.SetNormalsInterpolation(interpolation)
            self.over_time(
                curves.CreateNormalsAttr(),
                lambda: self.vectors(sizes[interpolation]) if self.chance(0.9) else [],
                0.5,
            )
        self.dye(curves.GetPrim(), {name: partial(int, n) for name, n in sizes.items()})

    def _instancer(self, path: str, offset: Sequence[float], depth: int = 0) -> None:
        instancer = UsdGeom.PointInstancer.Define(self.stage, path)
        prim = instancer.GetPrim()
        self.place(prim, offset)
        ball = UsdGeom.Sphere.Define(self.stage, f"{path}/P/ball")
        ball.CreateRadiusAttr(0.4)
        box = UsdGeom.Mesh.Define(self.stage, f"{path}/P/box")
        UsdGeom.Xformable(box).AddScaleOp().Set((0.4, 0.4, 0.4))
        self._shape(box)
        names = ["ball", "box"]
        if self.chance(0.5):
            self.dye(ball.GetPrim(), {"constant": lambda: 1})
        if self.chance(0.5):
            bound = UsdShade.MaterialBindingAPI.Apply(ball.GetPrim())
            bound.Bind(UsdShade.Material.Get(self.stage, "/Looks/dyed"))
        if depth == 0 and self.chance(0.4):
            self._instancer(f"{path}/P/inner", (0, 0.5, 0), 1)
            names.append("inner")
        instancer.CreatePrototypesRel().SetTargets([f"{path}/P/{name}" for name in names])
        total = self.pick((1, 3, 5))
        size = 2.0 if depth == 0 else 0.7
        self.over_time(instancer.CreatePositionsAttr(), lambda: self.vectors(total, size), 0.5)
        self.over_time(
            instancer.CreateProtoIndicesAttr(),
            lambda: [self.pick(range(len(names))) for _ in range(total)],
            0.4,
        )
        if self.chance(0.4):
            self.over_time(
                instancer.CreateScalesAttr(),
                lambda: [self.pick(((1, 1, 1), (0.5, 1, 2), (-1, 1, 1))) for _ in range(total)],
                0.5,
            )
        if self.chance(0.4):
            turns = ((1, 0, 0, 0), (0.6, 0.8, 0, 0), (0.5, 0.5, 0.5, 0.5))
            single = self.chance(0.5)
            kind = Gf.Quatf if single else Gf.Quath
            attribute = (
                instancer.CreateOrientationsfAttr()
                if single
                else instancer.CreateOrientationsAttr()
            )
            self.over_time(attribute, lambda: [kind(*self.pick(turns)) for _ in range(total)], 0.5)
        if self.chance(0.5):
            ids = [7, 3, 11, 5, 2][:total]
            self.over_time(
                instancer.CreateIdsAttr(), lambda: sorted(ids, key=lambda _: self.number()), 0.5
            )
        if self.chance(0.5):
            masked: Sequence[list[int]] = ([], [0], [3, 7], [5], [2, 11])
            self.over_time(instancer.CreateInvisibleIdsAttr(), lambda: self.pick(masked), 0.8)
        if self.chance(0.2):
            self.over_time(instancer.CreateVelocitiesAttr(), lambda: self.vectors(total), 0.3)
        self.dye(
            prim,
            {name: (lambda: total) for name in ("vertex", "varying", "faceVarying")}
            | {"constant": lambda: 1, "uniform": lambda: 1},
        )

    def _skinned(self, path: str, offset: Sequence[float]) -> None:
        root = UsdSkel.Root.Define(self.stage, path)
        self.place(root.GetPrim(), offset)
        skeleton = UsdSkel.Skeleton.Define(self.stage, f"{path}/skeleton")
        skeleton.CreateJointsAttr(["a", "a/b"])
        up = Gf.Matrix4d(1).SetTranslate((0, 1, 0))
        skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1), up])
        skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1), up])
        motion = UsdSkel.Animation.Define(self.stage, f"{path}/skeleton/motion")
        motion.CreateJointsAttr(["a", "a/b"])
        self.over_time(
            motion.CreateTranslationsAttr(),
            lambda: [self.vectors_of(0.3), (0, 1 + 0.5 * self.number(), 0)],
            0.7,
        )
        motion.CreateRotationsAttr(
            [Gf.Quatf(1, 0, 0, 0), self.pick((Gf.Quatf(1, 0, 0, 0), Gf.Quatf(0.6, 0, 0, 0.8)))]
        )
        motion.CreateScalesAttr([Gf.Vec3h(1, 1, 1)] * 2)
        binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
        binding.CreateAnimationSourceRel().SetTargets([motion.GetPath()])
        mesh = UsdGeom.Mesh.Define(self.stage, f"{path}/mesh")
        self._shape(mesh)
        bound = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        bound.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
        if self.chance(0.2):
            bound.CreateJointIndicesPrimvar(True, 1).Set([1])
            bound.CreateJointWeightsPrimvar(True, 1).Set([1.0])
        else:
            bound.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * len(_BOX))
            weights = [value for p in _BOX for value in ((1 - p[1]) / 2, (1 + p[1]) / 2)]
            bound.CreateJointWeightsPrimvar(False, 2).Set(weights)
        if self.chance(0.6):
            shape = UsdSkel.BlendShape.Define(self.stage, f"{path}/mesh/smile")
            shape.CreateOffsetsAttr(self.vectors(len(_BOX), 0.5))
            bound.CreateBlendShapesAttr(["smile"])
            bound.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
            motion.CreateBlendShapesAttr(["smile"])
            self.over_time(
                motion.CreateBlendShapeWeightsAttr(), lambda: [self.pick((0.0, 0.5, 1.0))], 0.8
            )
