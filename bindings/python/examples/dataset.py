"""A labelled data set: 100 views of a scene with color, depth, ids and boxes. Trains nothing.

    python dataset.py [SCENE] [FOLDER]
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

import rtrt

SIZE = (320, 240)
VIEWS = 100
BATCH = 20
LAYERS = ["rgba", "depth", "object", "normal"]


def cameras(scene):
    """Around the scene on a spiral, from near the ground to high above it."""
    for number in range(VIEWS):
        angle, height = 2.4 * number, 0.1 + 1.2 * number / VIEWS
        yield scene.framing(SIZE, (np.cos(angle), height, np.sin(angle)))


def describe(scene, camera, number, objects):
    """What is known of a view."""
    fx, fy, cx, cy = camera.intrinsics(SIZE)
    return {
        "file_path": f"view-{number:03}.npz",
        "transform_matrix": camera.matrix.tolist(),
        "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy, "w": SIZE[0], "h": SIZE[1],
        "seen": scene.seen(objects),
    }


def main(name="demo:matchbox", folder="dataset"):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    scene = rtrt.Scene.load(name)
    views, all_cameras, frames = [], list(cameras(scene)), None
    start = time.perf_counter()
    for first in range(0, VIEWS, BATCH):
        batch = all_cameras[first : first + BATCH]
        frames = rtrt.render(scene, batch, SIZE, LAYERS, out=frames)
        for place, camera in enumerate(batch):
            view = {layer: frames[layer][place] for layer in LAYERS}
            np.savez_compressed(folder / f"view-{first + place:03}.npz", **view)
            views.append(describe(scene, camera, first + place, view["object"]))
    (folder / "transforms.json").write_text(json.dumps({"objects": scene.labels, "frames": views}, indent=1))
    print(f"{VIEWS} views in {time.perf_counter() - start:.1f} s: {folder}/transforms.json")


if __name__ == "__main__":
    main(*sys.argv[1:])
