import os

import numpy as np
import pytest

import rtrt


@pytest.fixture(scope="session")
def cpu():
    return rtrt.Backend("cpu")


@pytest.fixture(scope="session")
def glass():
    return rtrt.Scene.load("demo:glass")


@pytest.fixture
def square():
    """A white square of side 2 in the plane z = 0, object 0, in front of a red ball of radius 1 at x = 5, object 1."""
    scene = rtrt.Scene()
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    mesh = scene.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], uvs=[[0, 1], [1, 1], [1, 0], [0, 0]])
    scene.add_instance(mesh, scene.add_material(), name="square")
    scene.add_sphere(scene.add_material(base_color=(0.8, 0.1, 0.1)), (5, 0, 0), 1.0, name="ball")
    return scene


@pytest.fixture(scope="session")
def command():
    path = os.environ.get("RTRT_COMMAND")
    if not path:
        pytest.skip("RTRT_COMMAND is not set")
    return path


def same(a, b):
    return a.keys() == b.keys() and all(np.array_equal(a[key], b[key], equal_nan=True) for key in a)
