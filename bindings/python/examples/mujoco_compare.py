"""Compares `rtrt.mujoco.Renderer` with `mujoco.Renderer`: geometry, time, pictures side by side.

    MUJOCO_GL=osmesa python mujoco_compare.py [--check] [--times] [--pictures FOLDER]
"""

import argparse
import os
import platform
import time
from pathlib import Path

import mujoco
import numpy as np

import mujoco_models
import rtrt
import rtrt.mujoco

SIZES = [(64, 64), (128, 128), (256, 256), (480, 640)]


def frames(kind, model, data, size):
    with kind(model, *size) as renderer:
        renderer.update_scene(data, "eye")
        color = renderer.render().copy()
        renderer.enable_depth_rendering()
        depth = renderer.render().copy()
        renderer.disable_depth_rendering()
        renderer.enable_segmentation_rendering()
        return color, depth, renderer.render().copy()


def beside_another(ids):
    """Pixels with another object within two pixels."""
    at = np.zeros(ids.shape[:2], bool)
    for rows in range(-2, 3):
        for columns in range(-2, 3):
            at |= (ids != np.roll(ids, (rows, columns), (0, 1))).any(-1)
    return at


def check(size=(240, 320)):
    """Whether geometry agrees; round shapes of MuJoCo have many facets."""
    is_right = True
    print("| model | other ids | of them inside | largest difference of depth |\n|---|---|---|---|")
    for name in mujoco_models.NAMES:
        model, data = mujoco_models.load(name, fine=True)
        (_, depth, ids), (_, own_depth, own_ids) = (
            frames(kind, model, data, size) for kind in (mujoco.Renderer, rtrt.mujoco.Renderer)
        )
        inside = ~beside_another(ids) & ~beside_another(own_ids)
        differs = (ids != own_ids).any(-1)
        # Far away, depths of OpenGL's buffer have steps of their own.
        near = inside & (depth < 10)
        most = np.abs(depth - own_depth)[near].max()
        print(f"| {name} | {differs.mean():.2%} | {(differs & inside).sum()} | {most:.1e} |")
        is_right &= not (differs & inside).any() and most < 1e-4
    return is_right


def milliseconds(kind, model, data, size, **options):
    """Of a frame with the update of the scene: of work, all threads summed, and until it is there. Medians."""
    with kind(model, *size, **options) as renderer:
        times, end = [], time.perf_counter() + 1.5
        while len(times) < 6 or time.perf_counter() < end:
            start = time.process_time(), time.perf_counter()
            renderer.update_scene(data, "eye")
            renderer.render()
            times.append((time.process_time() - start[0], time.perf_counter() - start[1]))
        return 1e3 * np.median(times[1:], 0)


def measure():
    gl = os.environ.get("MUJOCO_GL")
    print(f"{platform.machine()}, {os.cpu_count()} threads, rtrt on {rtrt.Backend()}, MUJOCO_GL={gl}")
    print("\nMilliseconds of work, and until the picture is there.\n")
    print("| model | size | mujoco.Renderer | rtrt | times faster | rtrt, 1 sample | times faster |\n|---|---|---|---|---|---|---|")
    text = lambda times: f"{times[0]:.1f}, {times[1]:.1f}"
    ratio = lambda a, b: f"{a[0] / b[0]:.1f}, {a[1] / b[1]:.1f}"
    for name in mujoco_models.NAMES:
        model, data = mujoco_models.load(name)
        for size in SIZES:
            theirs = milliseconds(mujoco.Renderer, model, data, size)
            ours = milliseconds(rtrt.mujoco.Renderer, model, data, size)
            single = milliseconds(rtrt.mujoco.Renderer, model, data, size, samples=1)
            print(
                f"| {name} | {size[1]} x {size[0]} | {text(theirs)} | {text(ours)} | {ratio(theirs, ours)}"
                f" | {text(single)} | {ratio(theirs, single)} |",
                flush=True,
            )


def pictures(folder):
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    for name in mujoco_models.NAMES:
        model, data = mujoco_models.load(name)
        colors = [frames(kind, model, data, (480, 640))[0] for kind in (mujoco.Renderer, rtrt.mujoco.Renderer)]
        Image.fromarray(np.concatenate(colors, 1)).save(folder / f"{name}.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--times", action="store_true")
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    if options.pictures:
        pictures(options.pictures)
    if options.times:
        measure()
    if options.check:
        raise SystemExit(0 if check() else "geometry differs")
