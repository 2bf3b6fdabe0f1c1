# SPDX-License-Identifier: Apache-2.0
"""Value clips: read like any time samples, and an error where a layer of them is missing."""

import re

import pytest

from conftest import MakeShot, WriteLayer
from irt_usd.errors import InputError

CLIP = """
def Xform "M"
{
    def Sphere "S"
    {
        double radius.timeSamples = { 1: 0.5, 3: 1.5 }
        token visibility.timeSamples = { 1: "inherited", 3: "invisible" }
    }
}
"""
MANIFEST = """
over "M"
{
    over "S"
    {
        double radius
        token visibility
    }
}
"""
WITH_MANIFEST = "asset manifestAssetPath = @./manifest.usda@"


def clipped(body: str = "", manifest: str = WITH_MANIFEST) -> str:
    return f"""
def Xform "X" (
    clips = {{
        dictionary default = {{
            asset[] assetPaths = [@./clip.usda@, @./later.usda@]
            {manifest}
            string primPath = "/M"
            double2[] active = [(1, 0), (10, 1)]
            double2[] times = [(1, 1), (20, 20)]
        }}
    }}
)
{{
    def Sphere "S"
    {{
        {body}
    }}
}}
"""


@pytest.mark.parametrize("body", ["", "double radius\ntoken visibility"])
def test_clips_are_read_wherever_the_attribute_is_declared(
    shot: MakeShot, usda: WriteLayer, body: str
) -> None:
    usda(CLIP, "clip.usda")
    usda(MANIFEST, "manifest.usda")
    made = shot(clipped(body))
    assert made.read(1).objects["/X/S"].shape.attributes["radius"] == 0.5
    assert made.read(2).objects["/X/S"].shape.attributes["radius"] == 1
    assert "/X/S" not in made.read(3).objects


def test_a_clip_is_missed_at_the_frame_that_needs_it(shot: MakeShot, usda: WriteLayer) -> None:
    usda(CLIP, "clip.usda")
    usda(MANIFEST, "manifest.usda")
    made = shot(clipped())
    made.read(1)
    with pytest.raises(InputError, match=r"/X in .*shot\.usda: @.*later\.usda@ \(no such file as"):
        made.read(12)


def test_a_clip_that_is_missed_for_want_of_a_manifest(shot: MakeShot, usda: WriteLayer) -> None:
    usda(CLIP, "clip.usda")
    with pytest.raises(InputError, match=r"later\.usda@ \(no such file as"):
        shot(clipped(manifest=""))


def test_a_manifest_that_is_missing(shot: MakeShot, usda: WriteLayer) -> None:
    usda(CLIP, "clip.usda")
    with pytest.raises(InputError, match=r"/X in .*manifest\.usda@ \(no such file as"):
        shot(clipped()).read(1)


def test_a_clip_that_does_not_parse(
    shot: MakeShot, usda: WriteLayer, capfd: pytest.CaptureFixture[str]
) -> None:
    broken = usda("def Sphere {", "clip.usda")
    usda(MANIFEST, "manifest.usda")
    with pytest.raises(InputError, match=rf"/X in .*{re.escape(str(broken))}:\d+:\d+: "):
        shot(clipped()).read(1)
    assert capfd.readouterr() == ("", "")
