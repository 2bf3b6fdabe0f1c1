# SPDX-License-Identifier: Apache-2.0
"""UsdRenderSettings, products and vars, as UsdRenderComputeSpec reads them.

A product's authored values override those of its settings. Attributes of other renderers are
ignored. Nothing here needs time but the products' names: the schema's other attributes are uniform.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdRender

from irt_usd.aovs import ALIASES, BEAUTY_SOURCES, LPE, PRIMVARS, is_aov, primvar_aov
from irt_usd.choices import PURPOSES as ALL_PURPOSES
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.framing import POLICIES, WHOLE

PURPOSES = ("default", "render")
"""UsdGeom's purposes that are rendered, as UsdRenderSettings has it by default."""

BINDING_PURPOSES = ("full", "")
"""Purposes of material bindings, the first being preferred, as UsdRenderSettings has it."""

_KNOWN_BINDING_PURPOSES = ("full", "preview", "")

_SOURCE_TYPES = ("raw", "primvar", "lpe", "intrinsic")

_BASE = (
    "resolution",
    "pixelAspectRatio",
    "aspectRatioConformPolicy",
    "dataWindowNDC",
    "disableMotionBlur",
    "disableDepthOfField",
    "instantaneousShutter",
)


@dataclass(frozen=True)
class RenderVar:
    """What a product wants of each pixel."""

    path: str
    source: str
    source_type: str
    data_type: str
    layer: str
    """Name of its EXR layer."""

    @property
    def aov(self) -> str:
        """The AOV that it asks for; empty where there is none of that kind."""
        if self.source_type == "lpe" or self.source.startswith(LPE):
            name = LPE + self.source.removeprefix("color ").removeprefix(LPE)
            return name if is_aov(name) else ""
        primvar = self.source.removeprefix(PRIMVARS)
        if self.source_type == "primvar" or primvar != self.source:
            return primvar_aov(primvar, self.data_type)
        name = ALIASES.get(self.source, self.source)
        return name if is_aov(name) else ""


@dataclass(frozen=True)
class Product:
    """An image that the settings ask for. None: not authored, and to be found elsewhere."""

    path: str = ""
    """Empty where no product is authored."""
    camera: str | None = None
    resolution: tuple[int, int] | None = None
    pixel_aspect: float = 1.0
    policy: str = "adjustApertureHeight"
    data_window: tuple[float, float, float, float] = WHOLE
    motion_blur: bool = True
    depth_of_field: bool = True
    variables: tuple[RenderVar, ...] = ()
    name: Usd.AttributeQuery | None = field(default=None, compare=False)

    def name_at(self, time: float) -> str:
        """The product's file name at `time`; empty where none is authored."""
        value = self.name.Get(Usd.TimeCode(time)) if self.name is not None else None
        return str(value) if value else ""

    @property
    def place(self) -> str:
        """Where its file name is authored, for messages."""
        if self.name is None:
            return self.path
        return where(self.name.GetAttribute().GetPrim(), "productName", Usd.TimeCode.Default())


@dataclass(frozen=True)
class Settings:
    """What the stage's render settings say of the shot; the defaults where it has none."""

    path: str = ""
    products: tuple[Product, ...] = (Product(),)
    purposes: tuple[str, ...] = PURPOSES
    binding_purposes: tuple[str, ...] = BINDING_PURPOSES


def list_settings(stage: Usd.Stage) -> list[str]:
    """Paths of the stage's RenderSettings."""
    return [str(prim.GetPath()) for prim in stage.Traverse() if prim.IsA(UsdRender.Settings)]


def read_settings(
    stage: Usd.Stage,
    wanted: str | None,
    source: str,
    report: Report,
    camera_given: bool = False,
) -> Settings:
    """The render settings `wanted` (a path or a bare name), or else those that the stage names.

    `camera_given`: theirs is overridden, whatever it is.

    Raises InputError where there are none of the name `wanted`, or values show nothing.
    """
    if wanted is None:
        prim = UsdRender.Settings.GetStageRenderSettings(stage).GetPrim()
        if not prim:
            path = stage.GetMetadata("renderSettingsPrimPath")
            if path:
                message = "the stage's renderSettingsPrimPath names no RenderSettings prim"
                report.skipped(message, str(path))
            return Settings()
    else:
        found = list_settings(stage)
        named = [path for path in found if wanted in (path, path.rsplit("/", 1)[1])]
        if len(named) != 1:
            listed = "\n  ".join(["its render settings:", *found]) if found else "it has none"
            what = "no" if not named else "several"
            raise InputError(f"{source}: {what} RenderSettings '{wanted}'; {listed}")
        prim = stage.GetPrimAtPath(named[0])
    return _Reader(stage, prim, source, report, camera_given).read()


class _Reader:
    def __init__(
        self,
        stage: Usd.Stage,
        prim: Usd.Prim,
        source: str,
        report: Report,
        camera_given: bool,
    ) -> None:
        self._camera_given = camera_given
        self._stage = stage
        self._prim = prim
        self._source = source
        self._report = report

    def read(self) -> Settings:
        names = (*_BASE, "includedPurposes", "materialBindingPurposes")
        values = self._values(self._prim, names)
        products = []
        for target in self._targets(self._prim, "products"):
            prim = self._stage.GetPrimAtPath(target)
            if not prim or not prim.IsA(UsdRender.Product):
                message = "a render product that does not exist"
                self._report.skipped(message, f"<{target}> of {self._place('products')}")
                continue
            products.append(self._product(prim, values))
        path = str(self._prim.GetPath())
        if not products:
            products = [self._product(None, values)]
        purposes = self._known(values, "includedPurposes", ALL_PURPOSES)
        binding = self._known(values, "materialBindingPurposes", _KNOWN_BINDING_PURPOSES)
        binding = binding or BINDING_PURPOSES
        return Settings(path, tuple(products), purposes, binding)

    def _product(self, prim: Usd.Prim | None, settings: dict[str, Any]) -> Product:
        values = dict(settings)
        authored = {n for n in _BASE if self._prim.GetAttribute(n).HasAuthoredValue()}
        holder = dict.fromkeys((*_BASE, "camera"), self._prim)
        cameras = self._targets(self._prim, "camera")
        name: Usd.AttributeQuery | None = None
        variables: tuple[RenderVar, ...] = ()
        if prim is not None:
            own = self._values(prim, (*_BASE, "productType"))
            for key in _BASE:
                if prim.GetAttribute(key).HasAuthoredValue():
                    values[key] = own[key]
                    authored.add(key)
                    holder[key] = prim
            if self._targets(prim, "camera"):
                cameras = self._targets(prim, "camera")
                holder["camera"] = prim
            if own["productType"] != "raster":
                kind = f"productType {own['productType']} (a flat image written)"
                self._report.unsupported(kind, str(prim.GetPath()))
            name = Usd.AttributeQuery(prim, "productName")
            variables = self._variables(prim)
        self._check(values, holder)
        self._check_camera(cameras, where(holder["camera"], "camera", Usd.TimeCode.Default()))
        shutter = values["disableMotionBlur"] or values["instantaneousShutter"]
        return Product(
            path=str(prim.GetPath()) if prim is not None else "",
            camera=str(cameras[0]) if cameras else None,
            resolution=values["resolution"] if "resolution" in authored else None,
            pixel_aspect=values["pixelAspectRatio"],
            policy=values["aspectRatioConformPolicy"],
            data_window=values["dataWindowNDC"],
            motion_blur=not shutter,
            depth_of_field=not values["disableDepthOfField"],
            variables=variables,
            name=name,
        )

    def _check_camera(self, targets: list[Sdf.Path], place: str) -> None:
        if not targets or self._camera_given:
            return
        prim = self._stage.GetPrimAtPath(targets[0])
        if not prim or not prim.IsA(UsdGeom.Camera):
            fault = f"is no Camera but a {prim.GetTypeName()}" if prim else "does not exist"
            raise InputError(
                f"{self._source}: no camera <{targets[0]}>: the target of {place} {fault}; mend it"
                " or give --camera"
            )
        if len(targets) > 1:
            self._report.skipped("more than one camera, the first is rendered", place)

    def _known(self, values: dict[str, Any], name: str, known: Iterable[str]) -> tuple[str, ...]:
        """The tokens of `name` that are among `known`; others are reported."""
        found = _tokens(values[name])
        for token in found:
            if token not in known:
                message = (
                    f"{name} holds '{token}'; expected some of {', '.join(filter(None, known))}"
                )
                self._report.skipped(message, self._place(name))
        return tuple(token for token in found if token in known)

    def _check(self, values: dict[str, Any], holder: dict[str, Usd.Prim]) -> None:
        def refuse(name: str, wanted: str) -> None:
            place = where(holder[name], name, Usd.TimeCode.Default())
            value = values[name]
            raise InputError(f"{self._source}: {name} is {value}; expected {wanted}: {place}")

        aspect, window = values["pixelAspectRatio"], values["dataWindowNDC"]
        if not (isfinite(aspect) and aspect > 0):
            refuse("pixelAspectRatio", "a positive finite number")
        if values["aspectRatioConformPolicy"] not in POLICIES:
            refuse("aspectRatioConformPolicy", f"one of {', '.join(POLICIES)}")
        if not (all(map(isfinite, window)) and window[0] < window[2] and window[1] < window[3]):
            refuse("dataWindowNDC", "left, bottom, right, top, in that order")

    def _variables(self, product: Usd.Prim) -> tuple[RenderVar, ...]:
        found: list[RenderVar] = []
        for target in self._targets(product, "orderedVars"):
            prim = self._stage.GetPrimAtPath(target)
            if not prim or not prim.IsA(UsdRender.Var):
                place = where(product, "orderedVars", Usd.TimeCode.Default())
                self._report.skipped("a render var that does not exist", f"<{target}> of {place}")
                continue
            values = self._values(prim, ("sourceName", "sourceType", "dataType"))
            layer = prim.GetAttribute("driver:parameters:aov:name")
            authored = layer.Get() if layer and layer.HasAuthoredValue() else None
            if values["sourceType"] not in _SOURCE_TYPES:
                message = (
                    f"sourceType is {values['sourceType']}; expected {', '.join(_SOURCE_TYPES)}"
                )
                place = where(prim, "sourceType", Usd.TimeCode.Default())
                self._report.skipped(f"{message}: the var is left out", place)
                continue
            if not Sdf.ValueTypeNames.Find(str(values["dataType"])):
                message = f"dataType is {values['dataType']}; expected a type such as color3f"
                place = where(prim, "dataType", Usd.TimeCode.Default())
                self._report.skipped(f"{message}: the AOV's own is written", place)
            variable = RenderVar(
                str(target),
                str(values["sourceName"] or prim.GetName()),
                str(values["sourceType"]),
                str(values["dataType"]),
                str(authored or prim.GetName()),
            )
            if self._is_new_layer(variable, found):
                found.append(variable)
        return tuple(found)

    def _is_new_layer(self, variable: RenderVar, others: list[RenderVar]) -> bool:
        """Whether no other var of the product has the layer; reported, if one has."""
        if variable.source in BEAUTY_SOURCES:
            return True
        for other in others:
            if other.layer == variable.layer and other.source not in BEAUTY_SOURCES:
                message = f"a render var whose layer {variable.layer} another has"
                self._report.skipped(message, f"{variable.path}, after {other.path}")
                return False
        return True

    def _values(self, prim: Usd.Prim, names: Iterable[str]) -> dict[str, Any]:
        attributes = Attributes(prim, names, self._report)
        attributes.update(Usd.TimeCode.EarliestTime())
        return dict(attributes.values)

    def _targets(self, prim: Usd.Prim, name: str) -> list[Sdf.Path]:
        return list(prim.GetRelationship(name).GetForwardedTargets())

    def _place(self, name: str) -> str:
        return where(self._prim, name, Usd.TimeCode.Default())


def _tokens(value: Any) -> tuple[str, ...]:
    return tuple(map(str, np.ravel(value))) if value is not None else ()
