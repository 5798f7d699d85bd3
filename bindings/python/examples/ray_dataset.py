"""The data set of dataset.py on Ray: views are tasks, and a worker that dies changes no byte.

    python ray_dataset.py [--kill] [--workers N] [SCENE]

Prints a hash over all views. With --kill, a worker ends itself in the middle of its task, once.
"""

import argparse
import hashlib
import os
import signal
import tempfile
from pathlib import Path

import ray

SIZE = (160, 120)
VIEWS = 24
LAYERS = ["rgba", "depth", "object", "normal"]


def directions():
    import numpy as np

    return [(np.cos(2.4 * n), 0.1 + 1.2 * n / VIEWS, np.sin(2.4 * n)) for n in range(VIEWS)]


SCENES = {}
"""The scenes that this worker has loaded."""


@ray.remote(max_retries=3)
def view(name, number, direction, folder, killed):
    """Renders a view, and writes it once: under a name of its own first, and then in one step under that of the view."""
    import numpy as np

    import rtrt

    if name not in SCENES:
        SCENES[name] = rtrt.Scene.load(name)
    scene = SCENES[name]
    frame = rtrt.render(scene, scene.framing(SIZE, direction), SIZE, LAYERS)
    target = Path(folder) / f"view-{number:03}.npz"
    draft = target.with_suffix(f".{os.getpid()}.tmp")
    with open(draft, "wb") as file:
        np.savez(file, **frame)
        file.flush()
        if killed and number == VIEWS // 2 and not os.path.exists(killed):
            Path(killed).touch()
            os.kill(os.getpid(), signal.SIGKILL)
    os.replace(draft, target)
    digest = hashlib.sha256()
    for layer in LAYERS:
        digest.update(frame[layer].tobytes())
    return number, digest.hexdigest()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", nargs="?", default="demo:matchbox")
    parser.add_argument("--kill", action="store_true")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    ray.init(num_cpus=options.workers, include_dashboard=False, log_to_driver=False)
    with tempfile.TemporaryDirectory() as folder:
        killed = os.path.join(folder, "killed") if options.kill else None
        tasks = [view.remote(options.scene, n, way, folder, killed) for n, way in enumerate(directions())]
        results = dict(ray.get(tasks))
        assert sorted(results) == list(range(VIEWS)), "a view is missing"
        files = sorted(path.name for path in Path(folder).glob("*.npz"))
        assert files == [f"view-{n:03}.npz" for n in range(VIEWS)], "a view is missing, or written twice"
        if killed:
            assert os.path.exists(killed), "nothing was killed"
            drafts = list(Path(folder).glob("*.tmp"))
            print(f"one worker was killed; it left {len(drafts)} draft and no view")
    whole = hashlib.sha256("".join(results[n] for n in range(VIEWS)).encode()).hexdigest()
    print(f"{VIEWS} views: {whole}")


if __name__ == "__main__":
    main()
