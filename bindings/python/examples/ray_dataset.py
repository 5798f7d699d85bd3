"""The data set of dataset.py on Ray: views are tasks, and a worker that dies changes no byte.

    python ray_dataset.py [--kill] [--workers N] [--views N] [--size WIDTHxHEIGHT] [--folder FOLDER] [SCENE]

Prints a hash over all views. With --kill, a worker ends itself in the middle of its task, once. Workers are processes that are
called `ray::view`; whoever kills some of them from outside gets the same hash, too.
"""

import argparse
import hashlib
import os
import signal
import tempfile
from pathlib import Path

import numpy as np
import ray

LAYERS = ["rgba", "depth", "object", "normal"]


def directions(count):
    return [(np.cos(2.4 * n), 0.1 + 1.2 * n / count, np.sin(2.4 * n)) for n in range(count)]


def digest(frame):
    """A hash over all layers of a view."""
    return hashlib.sha256(b"".join(frame[layer].tobytes() for layer in LAYERS)).hexdigest()


SCENES = {}
"""The scenes that this worker has loaded."""


@ray.remote(max_retries=3)
def view(name, number, direction, size, folder, killed):
    """Renders a view, and writes it once: under a name of its own first, and then in one step under that of the view."""
    import rtrt

    if name not in SCENES:
        SCENES[name] = rtrt.Scene.load(name)
    scene = SCENES[name]
    frame = rtrt.render(scene, scene.framing(size, direction), size, LAYERS)
    target = Path(folder) / f"view-{number:03}.npz"
    draft = target.with_suffix(f".{os.getpid()}.tmp")
    with open(draft, "wb") as file:
        np.savez(file, **frame)
        file.flush()
        if killed and not os.path.exists(killed):
            Path(killed).touch()
            os.kill(os.getpid(), signal.SIGKILL)
    os.replace(draft, target)
    return number, digest(frame)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", nargs="?", default="demo:matchbox")
    parser.add_argument("--kill", action="store_true")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--views", type=int, default=24)
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--folder", help="where the views are written; a folder that is removed again if not given")
    options = parser.parse_args()
    ray.init(num_cpus=options.workers, include_dashboard=False, log_to_driver=False)
    size, numbers = tuple(map(int, options.size.split("x"))), range(options.views)
    with tempfile.TemporaryDirectory() as work:
        folder = Path(options.folder or work).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        if list(folder.iterdir()):
            parser.error(f"{folder} is not empty")
        killed = os.path.join(work, "killed") if options.kill else None
        middle = options.views // 2
        tasks = [
            view.remote(options.scene, n, way, size, str(folder), killed if n == middle else None)
            for n, way in enumerate(directions(options.views))
        ]
        results = dict(ray.get(tasks))
        assert sorted(results) == list(numbers), "a view is missing"
        for draft in folder.glob("*.tmp"):
            print(f"a worker that was killed left {draft.name} and not the view")
            draft.unlink()
        files = sorted(path.name for path in folder.iterdir() if path.suffix == ".npz")
        assert files == [f"view-{n:03}.npz" for n in numbers], "a view is missing, or written twice"
        for n, name in enumerate(files):
            with np.load(folder / name) as frame:
                assert digest(frame) == results[n], f"{name} is not what was rendered"
        assert killed is None or os.path.exists(killed), "nothing was killed"
    whole = hashlib.sha256("".join(results[n] for n in numbers).encode()).hexdigest()
    print(f"{options.views} views: {whole}")


if __name__ == "__main__":
    main()
