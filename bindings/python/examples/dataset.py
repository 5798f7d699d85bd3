"""A labelled data set: 100 views of things on a table with color, depth, normals, ids and boxes. Trains nothing.

    python dataset.py [FOLDER]

Each ten views have another arrangement. In FOLDER are a .npz for each view and transforms.json: names of objects, poses and
lenses as NeRF has them, visible pixels and boxes.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

import rtrt

SIZE = (320, 240)
LAYERS = ["rgba", "depth", "normal", "object"]
ARRANGEMENTS, VIEWS = 10, 10


def box():
    """The corners of a cube from -1 to 1, three a triangle."""
    face = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, -1, 1], [1, 1, 1], [-1, 1, 1]], float)
    sides = [np.roll(face, axis, -1) for axis in range(3)]
    return np.concatenate(sides + [side[::-1] * -1 for side in sides])


def build(rng):
    """The scene, and the numbers of what is moved."""
    scene = rtrt.Scene()
    cube = scene.add_mesh(box())
    checker = np.kron([[90, 160], [160, 90]], np.ones((8, 8))).astype(np.uint8)
    top = [[-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]]
    uvs = np.array([[0, 6], [6, 6], [6, 0], [0, 0]])
    table = scene.add_mesh(top, [[0, 1, 2], [0, 2, 3]], uvs=uvs)
    scene.add_instance(table, scene.add_material(base_color_map=scene.add_texture(checker)), name="table")
    moved = []
    for number in range(12):
        color = rng.uniform(0.1, 0.9, 3)
        paint = scene.add_material(base_color=color, roughness=rng.uniform(0.2, 0.9), metallic=float(number % 5 == 0))
        if number % 2:
            moved.append(scene.add_instance(cube, paint, name=f"box {number}"))
        else:
            moved.append(scene.add_sphere(paint, name=f"ball {number}"))
    scene.light_by_default()
    return scene, moved


def arrangement(rng, count):
    """Matrices that put things of random sizes on the table."""
    matrices = np.tile(np.eye(4), (count, 1, 1))
    for matrix in matrices:
        turn, sizes = rng.uniform(0, 2 * np.pi), rng.uniform(0.15, 0.4, 3)
        axes = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
        matrix[:3, :3] = np.array(axes) * sizes
        matrix[:3, 3] = rng.uniform(-2, 2), sizes[1], rng.uniform(-2, 2)
    return matrices


def camera(rng):
    turn, height, distance = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 1.3), rng.uniform(4, 7)
    eye = distance * np.array([np.cos(height) * np.cos(turn), np.sin(height), np.cos(height) * np.sin(turn)])
    return rtrt.Camera(eye, rng.uniform(-0.5, 0.5, 3) * [1, 0, 1], fx=300)


def main(folder="dataset"):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(7)
    scene, moved = build(rng)
    views, frames, start, seconds = [], None, time.perf_counter(), 0.0
    for _ in range(ARRANGEMENTS):
        scene.set_transforms(moved, arrangement(rng, len(moved)))
        cameras = [camera(rng) for _ in range(VIEWS)]
        began = time.perf_counter()
        frames = rtrt.render(scene, cameras, SIZE, LAYERS, out=frames)
        seconds += time.perf_counter() - began
        for place, view in enumerate(cameras):
            name = f"view-{len(views):03}.npz"
            np.savez_compressed(folder / name, **{layer: frames[layer][place] for layer in LAYERS})
            fx, fy, cx, cy = view.intrinsics(SIZE)
            views.append({
                "file_path": name,
                "transform_matrix": view.matrix.tolist(),
                "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy, "w": SIZE[0], "h": SIZE[1],
                "seen": scene.seen(frames["object"][place]),
            })
    names = {entry["object"]: entry["node"] for entry in scene.labels}
    (folder / "transforms.json").write_text(json.dumps({"objects": names, "frames": views}, indent=1))
    total = time.perf_counter() - start
    print(f"{len(views)} views in {total:.1f} s, {seconds:.1f} s of which rendered: {folder}/transforms.json")


if __name__ == "__main__":
    main(*sys.argv[1:])
