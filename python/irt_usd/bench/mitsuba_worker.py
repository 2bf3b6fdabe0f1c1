# SPDX-License-Identifier: Apache-2.0
"""Mitsuba 3's side of `irt bench trace`, in a process of its own (it brings its own Embree, LLVM).

`python -m irt_usd.bench.mitsuba_worker VARIANT SCENE.npz IMAGE.npy`: renders the scene that
`irt_usd.bench.peers` wrote, saves the image and prints Mitsuba's version; then renders once for
each line on standard input and prints the seconds.
"""

import json
import sys
import time
from typing import Any

import drjit
import mitsuba
import numpy as np


def build(scene: Any, settings: dict[str, Any]) -> Any:
    """Mitsuba's scene: facets of one Lambert material under one point light."""
    mi = mitsuba
    world_from_camera = np.array(settings["world_from_camera"]).T @ np.diag([-1.0, 1, -1, 1])
    width, height = settings["size"]
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
        "sensor": {
            "type": "perspective",
            "fov": settings["fov_degrees"],
            "fov_axis": "x",
            "near_clip": 0.1,
            "far_clip": 1e6,
            "to_world": mi.ScalarTransform4f(world_from_camera.tolist()),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent", "sample_count": settings["samples"]},
        },
        "light": {
            "type": "point",
            "position": settings["light_position"],
            "intensity": {"type": "rgb", "value": settings["light_intensity"]},
        },
    }
    matt = mi.load_dict(
        {
            "type": "twosided",
            "bsdf": {
                "type": "diffuse",
                "reflectance": {"type": "rgb", "value": settings["reflectance"]},
            },
        }
    )
    for i in range(settings["meshes"]):
        points, triangles = scene[f"points_{i}"], scene[f"triangles_{i}"]
        properties = mi.Properties()
        properties["bsdf"] = matt
        properties["face_normals"] = True
        mesh = mi.Mesh(f"mesh_{i}", len(points), len(triangles), props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = points.ravel()
        parameters["faces"] = triangles.ravel()
        parameters.update()
        parts[f"mesh_{i}"] = mesh
    return mi.load_dict(parts)


def main(variant: str, scene_file: str, image_file: str) -> None:
    """Serves renders until standard input ends."""
    mitsuba.set_variant(variant)
    with np.load(scene_file) as arrays:
        settings = json.loads(str(arrays["settings"]))
        drjit.set_thread_count(settings["threads"])
        scene = build(arrays, settings)

    def render(seed: int) -> Any:
        return np.array(mitsuba.render(scene, spp=settings["samples"], seed=seed))

    np.save(image_file, render(0))
    print(mitsuba.__version__, flush=True)
    for seed, _ in enumerate(sys.stdin, start=1):
        start = time.perf_counter()
        render(seed)
        print(time.perf_counter() - start, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
