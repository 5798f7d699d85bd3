"""What is wrong is named, and nothing crashes."""

import contextlib
import itertools
import threading
import time

import numpy as np
import pytest

import rtrt

TRIANGLE = np.eye(3, dtype=np.float32)


@pytest.mark.parametrize(
    "arguments, kind, why",
    [
        (dict(positions=np.zeros(4)), ValueError, r"positions has the shape \(4,\), and not \(n, 3\)"),
        (dict(positions=np.zeros((2, 2))), ValueError, r"positions has the shape \(2, 2\)"),
        (dict(positions=np.zeros((3, 3, 1))), ValueError, r"positions has the shape \(3, 3, 1\)"),
        (dict(positions=TRIANGLE * 1j), TypeError, "positions has the dtype complex"),
        (dict(positions=np.array([["a"] * 3] * 3)), TypeError, "positions has the dtype <U1"),
        (dict(positions=np.full((3, 3), None)), TypeError, "positions has the dtype object"),
        (dict(positions="abc"), TypeError, "positions has the dtype <U3"),
        (dict(positions=[[0, 0, 0], [1]]), ValueError, "positions: "),
        (dict(positions=TRIANGLE * np.nan), ValueError, "vertex 0 has the coordinate NaN"),
        (dict(positions=TRIANGLE + np.inf), ValueError, "vertex 0 has the coordinate"),
        (dict(positions=TRIANGLE.astype(float) * 1e300), ValueError, "vertex 0 has the coordinate inf"),
        (dict(positions=TRIANGLE[:2]), ValueError, "2 indices do not make whole triangles"),
        (dict(positions=TRIANGLE, triangles=[[0, 1, 3]]), IndexError, "triangles holds 3 at place 2: there are 3 positions, 0 to 2"),
        (dict(positions=TRIANGLE, triangles=[[0, 1, -1]]), IndexError, "triangles holds -1 at place 2"),
        (dict(positions=TRIANGLE, triangles=[[0, 1, 2**40]]), IndexError, "triangles holds 1099511627776"),
        (dict(positions=TRIANGLE, triangles=[0, 1, 2]), ValueError, r"triangles has the shape \(3,\)"),
        (dict(positions=TRIANGLE, triangles=[[0.0, 1.0, 2.0]]), TypeError, "triangles has the dtype float64"),
        (dict(positions=TRIANGLE, normals=TRIANGLE[:2]), ValueError, "normals has 2 rows, but there are 3"),
        (dict(positions=TRIANGLE, normals=TRIANGLE * np.nan), ValueError, "vertex 0 has the normal"),
        (dict(positions=TRIANGLE, uvs=TRIANGLE), ValueError, r"uvs has the shape \(3, 3\), and not \(n, 2\)"),
        (dict(positions=TRIANGLE, colors=TRIANGLE), TypeError, "colors has the dtype float32"),
        (dict(positions=TRIANGLE, tangents=np.ones((2, 4))), ValueError, "3 positions but 2 attributes"),
    ],
)
def test_meshes(arguments, kind, why):
    with pytest.raises(kind, match=why):
        rtrt.Scene().add_mesh(**arguments)


def test_arrays_of_any_layout_are_the_same():
    rng = np.random.default_rng(1)
    positions = rng.normal(size=(30, 3)).astype(np.float32)
    triangles = rng.integers(0, 30, (40, 3))
    misaligned = np.zeros(30 * 12 + 1, np.uint8)[1:].view(np.float32).reshape(30, 3)
    misaligned[:] = positions
    frozen = positions.copy()
    frozen.flags.writeable = False
    layouts = [
        positions.astype(np.float64),
        np.asfortranarray(positions),
        np.repeat(positions, 2, axis=0)[::2],
        positions[::-1][::-1],
        np.stack([positions, positions], -1)[..., 0],
        positions.astype(">f4"),
        positions.tolist(),
        misaligned,
        frozen,
    ]
    pictures = set()
    for layout, kind in zip([positions] + layouts, itertools.cycle([np.int64, np.uint8, ">i2", np.uint32])):
        scene = rtrt.Scene()
        scene.add_instance(scene.add_mesh(layout, triangles.astype(kind)), scene.add_material())
        scene.light_by_default()
        pictures.add(rtrt.render(scene, rtrt.Camera((0, 0, 6), (0, 0, 0)), (32, 32))["rgba"].tobytes())
    assert len(pictures) == 1


def test_empty_arrays():
    scene = rtrt.Scene()
    mesh = scene.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert scene.add_mesh([]) == mesh + 1
    scene.add_instance(mesh, scene.add_material())
    scene.set_transforms([], np.zeros((0, 4, 4)))
    camera = rtrt.Camera((0, 0, 3), (0, 0, 0))
    assert (rtrt.render(scene, camera, (8, 8), ["object"])["object"] == -1).all()
    assert rtrt.render(scene, [], (8, 6), ["rgba", "depth"])["rgba"].shape == (0, 6, 8, 4)
    assert rtrt.render(rtrt.Scene(), size=(4, 4))["rgba"].shape == (4, 4, 4)
    with pytest.raises(ValueError, match="pixels"):
        scene.add_texture(np.zeros((0, 4, 3), np.uint8).reshape(0, 4, 3, 1))
    with pytest.raises(ValueError, match="a texture of 4 x 0"):
        scene.add_texture(np.zeros((0, 4, 3), np.uint8))


@pytest.mark.parametrize(
    "call, kind, why",
    [
        (lambda s: s.add_instance(7, 0), IndexError, "there is no mesh 7: there is one mesh, 0"),
        (lambda s: s.add_instance(-1, 0), IndexError, "there is no mesh -1"),
        (lambda s: s.add_instance(0, 9), IndexError, "no material 9"),
        (lambda s: s.add_instance(0, 0, np.zeros((4, 4))), ValueError, "cannot be inverted"),
        (lambda s: s.add_instance(0, 0, np.full((4, 4), np.nan)), ValueError, "cannot be inverted"),
        (lambda s: s.add_instance(0, 0, np.eye(3)), ValueError, r"transform has the shape \(3, 3\)"),
        (lambda s: s.add_instance(0, 0, np.zeros((2, 4, 4))), ValueError, "transform is not one matrix"),
        (lambda s: s.add_sphere(0, (0, 0), 1), ValueError, r"center has the shape \(2,\)"),
        (lambda s: s.add_sphere(0, (0, 0, 0), -1), ValueError, "radius is -1"),
        (lambda s: s.add_sphere(0, (0, 0, 0), transform=np.eye(4)), ValueError, "a center and a radius, or"),
        (lambda s: s.set_transform(5, np.eye(4)), IndexError, "there is no object 5: there are 2 objects, 0 to 1"),
        (lambda s: s.set_transforms([0, 2], np.zeros((2, 4, 4))), IndexError, "objects holds 2 at place 1: there are 2 objects"),
        (lambda s: s.set_transforms([0], np.zeros((2, 4, 4))), ValueError, "objects and transforms"),
        (lambda s: s.set_transforms([1, 0], [np.eye(4), np.zeros((4, 4))]), ValueError, r"transforms\[1\], of object 0"),
        (lambda s: s.add_material(rughness=1), TypeError, 'a material has no "rughness", but: base_color'),
        (lambda s: s.add_material(roughness=2), ValueError, "the roughness of a material is 2"),
        (lambda s: s.add_material(roughness="x"), TypeError, "roughness cannot be x"),
        (lambda s: s.add_material(base_color=(1, 2)), ValueError, "base_color has the shape"),
        (lambda s: s.add_material(base_color=(1, 2, np.nan)), ValueError, "the base color of a material is NaN"),
        (lambda s: s.add_material(base_color_map=0), IndexError, "base_color_map is texture 0: there are no textures"),
        (lambda s: s.add_material(alpha_mode="glass"), ValueError, "alpha_mode is \"glass\""),
        (lambda s: s.add_texture(np.zeros((4, 4, 3))), TypeError, "pixels has the dtype float64"),
        (lambda s: s.add_texture(np.zeros((4, 4, 7), np.uint8)), ValueError, "pixels has the shape"),
        (lambda s: s.add_texture(np.zeros((1, 20000), np.uint8)), ValueError, "a texture of 20000 x 1"),
        (lambda s: s.reshape(0, TRIANGLE), ValueError, "the shape has 1 triangles, and the mesh has 2"),
        (lambda s: s.set_environment("none.hdr"), FileNotFoundError, "there is no environment none.hdr"),
        (lambda s: s.set_environment(__file__), ValueError, "environment refused: "),
        (lambda s: s.set_environment(np.zeros((4, 3))), ValueError, "source has the shape"),
        (lambda s: s.set_environment("studio", blur=2), ValueError, "blur is 2"),
        (lambda s: s.set_environment("studio", rotation=1e9), ValueError, "rotation is 1000000000"),
        (lambda s: s.play(-1), ValueError, "time is -1"),
        (lambda s: s.add_material(shadow_catcher=True, roughness=0.5), ValueError, "takes no other properties"),
        (lambda s: s.add_material(base_color=(1, 0, 0), shadow_catcher=True), ValueError, "takes no other properties"),
        (lambda s: s.set_material(0, shadow_catcher=True, alpha=1), ValueError, "takes no other properties"),
        (lambda s: s.add_material(shadow_catcher="x"), TypeError, "shadow_catcher cannot be x"),
        (lambda s: s.seen(np.zeros((3, 3))), ValueError, "objects is no array of int32"),
        (lambda s: setattr(s, "background", "sky"), ValueError, 'background is "sky"'),
        (lambda s: setattr(s, "ambient", 3), ValueError, "ambient has the shape"),
        (lambda s: setattr(s, "lights", [1]), TypeError, "Light"),
        (lambda s: rtrt.Light.point((0, 0, np.inf)), ValueError, r"position holds inf at \[2\], which is not finite"),
        (lambda s: rtrt.Light.spot((0, 0, 0), (0, 0, 1), outer=120), ValueError, "outer is 120"),
        (lambda s: rtrt.Light.point((0, 0, 0), reach=0), ValueError, "reach is 0"),
        (lambda s: rtrt.Camera((0, 0, 0), (0, 0, 0)), ValueError, "looks nowhere"),
        (lambda s: rtrt.Camera((0, 0, np.nan), (0, 0, 0)), ValueError, "looks nowhere"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), (0, 0, 1)), ValueError, "looks nowhere"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), fov_y=180), ValueError, "fov_y is 180"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), fov_y=9, fx=1), ValueError, "one of fov_y, height and fx"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), cx=1), ValueError, "need fx"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), fx=np.nan), ValueError, "fx is NaN"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), near=2, far=1), ValueError, "near and far are 2 and 1"),
        (lambda s: rtrt.Camera((0, 0, 1), (0, 0, 0), near=np.nan), ValueError, "near and far are NaN"),
        (lambda s: rtrt.Camera.from_matrix(np.zeros((4, 4))), ValueError, "no length"),
        (lambda s: rtrt.Camera.from_matrix(np.diag([1, 1, -1, 1])), ValueError, "mirrored"),
        (lambda s: rtrt.Backend("tpu"), ValueError, 'kind is "tpu", and not one of auto, cpu, gpu'),
        (lambda s: rtrt.Backend("cpu", threads=0), ValueError, "threads is 0"),
        (lambda s: rtrt.Backend("cpu", lanes=7), ValueError, "lanes is 7"),
        (lambda s: rtrt.Backend("gpu", adapter="nothing like it"), RuntimeError, "nothing like it"),
        (lambda s: rtrt.render(s, size=(0, 5)), ValueError, "size is 0 x 5"),
        (lambda s: rtrt.render(s, size=(10**9, 5)), ValueError, "size is 1000000000 x 5"),
        (lambda s: rtrt.render(s, size=(8, 8), samples=3), ValueError, "3 samples a pixel"),
        (lambda s: rtrt.render(s, size=(8, 8), samples=-1), ValueError, "samples a pixel"),
        (lambda s: rtrt.render(s, size=(8, 8), layers=0), ValueError, "0 layers"),
        (lambda s: rtrt.render(s, size=(8, 8), exposure=np.nan), ValueError, "an exposure of NaN"),
        (lambda s: rtrt.render(s, size=(8, 8), shadows="long"), ValueError, 'shadows is "long"'),
        (lambda s: rtrt.render(s, size=(8, 8), tone_map="x"), ValueError, 'tone_map is "x"'),
        (lambda s: rtrt.render(s, 3, (8, 8)), TypeError, "camera is neither"),
        (lambda s: rtrt.render(s, [3], (8, 8)), TypeError, "camera is neither"),
        (lambda s: rtrt.render(s, None, (8, 8), "deep"), ValueError, 'aov "deep" is not one of rgba, color'),
        (lambda s: rtrt.render(s, None, (8, 8), 3), TypeError, "aov is neither"),
        (lambda s: rtrt.render(s, None, (16384, 16384), "depth"), ValueError, "rays a picture"),
    ],
)
def test_calls(square, call, kind, why):
    before = rtrt.render(square, rtrt.Camera((0, 0, 4), (0, 0, 0)), (8, 8))["rgba"]
    with pytest.raises(kind, match=why):
        call(square)
    if kind is not ValueError or "transforms" not in why:
        after = rtrt.render(square, rtrt.Camera((0, 0, 4), (0, 0, 0)), (8, 8))["rgba"]
        assert np.array_equal(before, after)


def test_an_environment_that_is_refused_changes_nothing(square):
    square.set_environment("studio")
    camera = rtrt.Camera((0, 0, 4), (0, 0, 0))
    before = rtrt.render(square, camera, (16, 12))["rgba"]
    for source in ("none.hdr", __file__, np.zeros((4, 3))):
        with pytest.raises((OSError, ValueError)):
            square.set_environment(source, rotation=90, intensity=0.1, blur=1)
    assert np.array_equal(rtrt.render(square, camera, (16, 12))["rgba"], before)


VECTOR = (0.0, 0.0, 1.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(
    "array, call",
    [
        (TRIANGLE, lambda s, a: s.add_mesh(a)),
        (TRIANGLE, lambda s, a: s.add_mesh(TRIANGLE, normals=a)),
        (TRIANGLE[:, :2], lambda s, a: s.add_mesh(TRIANGLE, uvs=a)),
        (np.ones((3, 4)), lambda s, a: s.add_mesh(TRIANGLE, uvs=TRIANGLE[:, :2], tangents=a)),
        (np.zeros((6, 3)), lambda s, a: s.reshape(0, a)),
        (np.eye(4), lambda s, a: s.set_transform(0, a)),
        (np.eye(4)[:3], lambda s, a: s.add_instance(0, 0, a)),
        (np.eye(4), lambda s, a: s.add_sphere(0, transform=a)),
        (np.eye(4)[None], lambda s, a: s.set_transforms([0], a)),
        (VECTOR, lambda s, a: s.add_sphere(0, a)),
        (1.0, lambda s, a: s.add_sphere(0, VECTOR, float(a))),
        (VECTOR, lambda s, a: setattr(s, "ambient", a)),
        (VECTOR, lambda s, a: setattr(s, "background", a)),
        (VECTOR, lambda s, a: s.framing((8, 8), a)),
        (VECTOR, lambda s, a: s.closest(a, VECTOR)),
        (VECTOR, lambda s, a: s.occluded(VECTOR, a)),
        (np.ones((4, 8, 3)), lambda s, a: s.set_environment(a)),
        (np.ones((4, 8, 3)), lambda s, a: s.set_environment(a, sun=False)),
        *[(1.0, lambda s, a, k=k: s.set_environment("studio", **{k: float(a)})) for k in ("rotation", "intensity", "blur")],
        (VECTOR, lambda s, a: rtrt.Light.point(a)),
        (VECTOR, lambda s, a: rtrt.Light.point(VECTOR, a)),
        (VECTOR, lambda s, a: rtrt.Light.sun(a)),
        (VECTOR, lambda s, a: rtrt.Light.spot(VECTOR, a)),
        (1.0, lambda s, a: rtrt.Light.point(VECTOR, radius=float(a))),
        (VECTOR, lambda s, a: rtrt.Camera(a, (0, 0, 0))),
        (VECTOR, lambda s, a: rtrt.Camera((0, 0, 0), a)),
        (VECTOR, lambda s, a: rtrt.Camera((5, 0, 0), (0, 0, 0), a)),
        (np.eye(4), lambda s, a: rtrt.Camera.from_matrix(a)),
        *[(VECTOR, lambda s, a, k=k: s.add_material(**{k: a})) for k in ("base_color", "specular", "emission")],
        *[
            (1.0, lambda s, a, k=k: s.add_material(**{k: float(a)}))
            for k in ("metallic", "roughness", "specular_strength", "normal_scale", "occlusion_strength", "alpha",
                      "alpha_cutoff", "transmission")
        ],
    ],
)
def test_numbers_that_are_not_finite_are_refused(square, array, call, value):
    bad = np.array(array, float)
    bad.flat[-1] = value
    before = square.objects, square.ambient, square.background
    with pytest.raises(ValueError):
        call(square, bad)
    assert (square.objects, square.ambient, square.background) == before
    rtrt.render(square, rtrt.Camera((0, 0, 4), (0, 0, 0)), (8, 8))


def test_a_panorama_that_is_refused_names_the_place(square):
    panorama = np.ones((4, 8, 3))
    panorama[2, 5, 1] = np.nan
    with pytest.raises(ValueError, match=r"source holds NaN at \[2, 5, 1\], which is not finite"):
        square.set_environment(panorama)


def test_a_shadow_catcher_has_no_other_properties(square):
    catcher = square.add_material(shadow_catcher=True)
    with pytest.raises(ValueError, match="shadow_catcher=False makes an ordinary one"):
        square.set_material(catcher, base_color=(1, 0, 0))
    camera, pictures = rtrt.Camera((0, 0, 4), (0, 0, 0)), []
    for material in (square.add_material(base_color=(1, 0, 0)), catcher):
        if material == catcher:
            square.set_material(catcher, shadow_catcher=False, base_color=(1, 0, 0))
        sphere = square.add_sphere(material, (0, 0, 1), 0.5)
        pictures.append(rtrt.render(square, camera, (16, 12))["rgba"])
        square.hide(sphere)
    assert np.array_equal(*pictures)
    square.set_material(catcher, shadow_catcher=True)
    square.set_material(catcher, shadow_catcher=True)


def test_buffers(glass):
    shape = (54, 96, 4)
    frozen = np.zeros(shape, np.uint8)
    frozen.flags.writeable = False
    both = np.zeros(shape, np.uint8)
    for out, kind, why in [
        ({"rgba": np.zeros(shape)}, TypeError, "has the dtype float64, and not uint8"),
        ({"rgba": np.zeros((96, 54, 4), np.uint8)}, ValueError, r"has the shape \(96, 54, 4\), and not \(54, 96, 4\)"),
        ({"rgba": np.zeros((54, 192, 4), np.uint8)[:, ::2]}, ValueError, "not contiguous"),
        ({"rgba": np.zeros(shape, np.uint8, order="F")}, ValueError, "not contiguous"),
        ({"rgba": frozen}, ValueError, "not writeable"),
        ({"rgba": [1, 2]}, TypeError, "no array of NumPy"),
        ({"rgb": both}, ValueError, 'aov "rgb"'),
        ({3: both}, TypeError, "keys of out"),
        ({"depth": np.zeros((54, 96), ">f4")}, TypeError, "has the dtype >f4"),
    ]:
        with pytest.raises(kind, match=why):
            rtrt.render(glass, size=(96, 54), out=out)
    # Two buffers that share memory.
    memory = np.zeros(54 * 96 * 4, np.uint8)
    with pytest.raises(RuntimeError, match=r'out\["material"\] is in use by another call, or twice by this one'):
        out = {"object": memory.view(np.int32).reshape(54, 96), "material": memory.view(np.int32).reshape(54, 96)}
        rtrt.render(glass, size=(96, 54), out=out)


def test_a_camera_of_a_batch_is_named(square):
    # Its edges are too far from the middle.
    wrong = rtrt.Camera((0, 0, 4), (0, 0, 0), fx=1e-9)
    with pytest.raises(ValueError, match="camera 1: the camera is not usable"):
        rtrt.render(square, [rtrt.Camera((0, 0, 4), (0, 0, 0)), wrong], (8, 8))


def test_a_scene_is_not_changed_while_it_is_rendered(glass):
    started = threading.Event()

    def work():
        started.set()
        rtrt.render(glass, size=(1280, 720), samples=16)

    thread = threading.Thread(target=work)
    thread.start()
    started.wait()
    refused = set()
    while thread.is_alive():
        try:
            glass.ambient = glass.ambient
        except RuntimeError as error:
            refused.add(str(error))
    assert len(refused) == 1 and "is in use by another call" in refused.pop()


def test_a_scene_that_is_changed_is_not_read(square):
    """A large mesh is added in one thread, while the others look at the scene."""
    positions = np.random.default_rng(1).normal(size=(300_000, 3)).astype(np.float32)
    rtrt.render(square, size=(4, 4))  # opens the backend

    def work():
        # While the others look, it is refused itself.
        while True:
            with contextlib.suppress(RuntimeError):
                return square.add_mesh(positions, make_tangents=True)

    thread = threading.Thread(target=work)
    thread.start()
    refused = set()
    while thread.is_alive():
        for call in (lambda: square.objects, lambda: rtrt.render(square, size=(4, 4)), square.copy, lambda: square.lights):
            try:
                call()
            except RuntimeError as error:
                refused.add(str(error))
        repr(square)
        time.sleep(0.001)
    assert len(refused) == 1 and "is being changed by another call" in refused.pop()


def test_what_makes_an_array_may_use_the_scene(square):
    """Arguments are arrays before the scene is looked at."""

    class Late:
        def __init__(self, array):
            self.array = array

        def __array__(self, dtype=None, copy=None):
            square.ambient = (0.5, 0.25, square.ambient[2])
            return np.asarray(self.array)

    square.set_transform(0, Late(np.eye(4)))
    square.set_transforms(Late([0]), Late(np.eye(4)[None]))
    square.reshape(0, Late(np.zeros((6, 3))))
    mesh = square.add_mesh(Late(TRIANGLE), Late([[0, 1, 2]]))
    material = square.add_material(base_color=Late([1, 0, 0]))
    square.set_material(material, emission=Late([1, 0, 0]))
    square.add_instance(mesh, material, Late(np.eye(4)))
    square.add_sphere(material, Late([0, 0, 0]))
    square.add_texture(Late(np.zeros((2, 2), np.uint8)))
    square.background = Late([0, 0, 0])
    square.ambient = Late([0, 0, 0])
    square.set_environment(Late(np.ones((4, 8, 3))))
    square.framing((4, 4), Late([0, 0, 1]))
    square.closest(Late([0, 0, 5]), Late([0, 0, -1]), far=Late(9.0))


def test_arrays_that_another_thread_fills_are_not_read(glass):
    frames = rtrt.render(glass, size=(1280, 720), aov=["rgba", "object"])
    thread = threading.Thread(target=lambda: rtrt.render(glass, size=(1280, 720), samples=16, out=frames))
    thread.start()
    refused = set()
    other = rtrt.Scene()
    while thread.is_alive():
        for call in (lambda: other.add_texture(frames["rgba"]), lambda: other.seen(frames["object"])):
            try:
                call()
            except RuntimeError as error:
                refused.add(str(error))
    assert len(refused) == 2 and all("is in use by another call" in why for why in refused)


def test_random_arguments_raise_or_work(square):
    """No argument of any kind does anything but raise an exception of Python's own kinds."""
    values = [
        None, True, -1, 0, 3, 2**70, 1.5, np.nan, np.inf, "x", "", b"x", (), [], {}, object(), 1j, np.float16(2),
        np.zeros(0), np.zeros(3), np.zeros((4, 4)), np.full((3, 3), np.nan), np.zeros((2, 3), ">i8"), [[1, 2], [3]],
        np.zeros((5, 3), [("a", int)]), np.array("2020", "M8"), np.ma.masked_array([1, 2, 3], [0, 1, 0]),
        np.broadcast_to(np.float32(1), (3, 3)), np.zeros((2, 2, 2, 2, 3)), square, rtrt.Camera((0, 0, 1), (0, 0, 0)),
    ]
    camera = rtrt.Camera((0, 0, 4), (0, 0, 0))
    calls = [
        lambda a, b: rtrt.Scene().add_mesh(a, b),
        lambda a, b: rtrt.Scene().add_texture(a, content=b),
        lambda a, b: square.set_transforms(a, b),
        lambda a, b: square.set_transform(a, b),
        lambda a, b: square.add_instance(a, b),
        lambda a, b: square.reshape(a, b),
        lambda a, b: square.closest(a, b),
        lambda a, b: square.occluded((0, 0, 0), a, far=b),
        lambda a, b: square.set_environment(a, blur=b),
        lambda a, b: square.framing(a, b),
        lambda a, b: square.seen(a),
        lambda a, b: rtrt.Scene().add_material(base_color=a, roughness=b),
        lambda a, b: rtrt.Camera(a, b),
        lambda a, b: rtrt.Camera.from_matrix(a, fx=b),
        lambda a, b: camera.project(a, b),
        lambda a, b: rtrt.Light.spot(a, b),
        lambda a, b: rtrt.Backend(a, threads=b),
        lambda a, b: rtrt.render(square, a, (8, 8), b),
        lambda a, b: rtrt.render(square, camera, a, out=b),
        lambda a, b: rtrt.render(square, camera, (8, 8), samples=a, layers=b),
        lambda a, b: rtrt.Scene.load(a, point_size=b),
    ]
    raised = 0
    for call, a, b in itertools.product(calls, values, values):
        try:
            call(a, b)
        except (ValueError, TypeError, IndexError, RuntimeError, OSError, OverflowError, MemoryError):
            raised += 1
    assert raised > 1000
