"""Pictures: the bytes of the command, right values, batches, buffers."""

import base64
import contextlib
import copy
import hashlib
import json
import multiprocessing
import os
import pickle
import signal
import subprocess
import threading
import time

import numpy as np
import pytest

import rtrt
from conftest import same

SIZE = (96, 54)
# Motion needs to know how the scene was.
ALL = [name for name in rtrt.AOVS if name != "motion"]


def digest(array):
    return hashlib.sha256(array.tobytes()).hexdigest()


@pytest.mark.parametrize("scene", ["demo:matchbox", "demo:glass", "demo:spheres"])
def test_hash_is_that_of_the_command(command, scene):
    report = subprocess.run(
        [command, "render", scene, "--size", "96x54", "--backend", "cpu", "--hash", "--json"],
        check=True,
        capture_output=True,
    )
    pixels = rtrt.render(rtrt.Scene.load(scene), size=SIZE)["rgba"]
    assert digest(pixels) == json.loads(report.stdout)["hash"]


def test_camera_and_layers_are_those_of_the_command(command, tmp_path):
    camera = {"eye": [3, 2, 4], "look_at": [0, 0.5, 0], "fl_x": 90, "cx": 40, "cy": 30}
    (tmp_path / "cameras.json").write_text(json.dumps({"cameras": [camera]}))
    subprocess.run(
        [command, "render", "demo:matchbox", "--size", "96x54", "--cameras", tmp_path / "cameras.json"]
        + ["--aov", tmp_path / "layers.npz", "-o", tmp_path / "picture.png", "--quiet"],
        check=True,
    )
    expected = np.load(tmp_path / "layers.npz")
    view = rtrt.Camera(camera["eye"], camera["look_at"], fx=90, cx=40, cy=30)
    frame = rtrt.render(rtrt.Scene.load("demo:matchbox"), view, SIZE, list(expected.keys()))
    for name in expected.keys():
        assert frame[name].tobytes() == expected[name].tobytes(), name


def test_kinds_and_shapes(glass):
    frame = rtrt.render(glass, size=SIZE, aov=ALL)
    wide = {"rgba": 4, "color": 4, "normal": 3, "albedo": 3, "position": 3, "uv": 2, "barycentrics": 2}
    for name in ALL:
        components = (wide[name],) if name in wide else ()
        assert frame[name].shape == (54, 96) + components
        kind = {"rgba": "u1", "object": "i4", "material": "i4", "triangle": "i4", "source": "i4"}
        assert frame[name].dtype == np.dtype(kind.get(name, "f4"))
    assert np.array_equal(rtrt.render(glass, size=SIZE)["rgba"], frame["rgba"])


def test_depth_ids_and_positions_follow_from_arithmetic(square):
    # 10 pixels a unit at distance 4: the square covers 20 x 20 pixels around the middle.
    camera = rtrt.Camera((0, 0, 4), (0, 0, 0), fx=40)
    frame = rtrt.render(square, camera, (64, 48), ALL, samples=1)
    inside = np.zeros((48, 64), bool)
    inside[14:34, 22:42] = True
    assert np.array_equal(frame["object"] == 0, inside)
    assert np.allclose(frame["depth"][inside], 4, atol=1e-6)
    ball = frame["object"] == 1
    assert not ball.any() and np.isinf(frame["depth"][~inside]).all()
    x = (np.arange(64) + 0.5 - 32) / 10
    y = (24 - np.arange(48) - 0.5) / 10
    expected = np.stack(np.broadcast_arrays(x[None, :], y[:, None], np.zeros(1)), -1)
    assert np.allclose(frame["position"][inside], expected[inside], atol=1e-5)
    assert np.allclose(frame["normal"][inside], [0, 0, 1], atol=1e-6)
    assert np.allclose(frame["uv"][inside], (expected[inside][:, :2] * [1, -1] + 1) / 2, atol=1e-5)
    assert np.array_equal(frame["material"] == 0, inside) and frame["object"].min() == -1
    assert [entry["node"] for entry in square.labels] == ["square", "ball"]
    assert square.seen(frame["object"]) == [
        {"object": 0, "pixels": 400, "box_2d": [22, 14, 42, 34], "box_3d": [[-1, -1, 0], [1, 1, 0]]}
    ]


def test_samples_of_a_triangle_can_have_one_color(square):
    def draw(**how):
        return rtrt.render(square, size=(203, 77), shadows="hard", **how)["rgba"]

    each, one = draw(), draw(shading="pixel")
    assert not np.array_equal(each, one)
    assert np.abs(each.astype(int) - one).mean() < 4
    # With layers too, and where a pixel has one sample anyway.
    both = rtrt.render(square, size=(203, 77), aov=["rgba", "depth"], shadows="hard", shading="pixel")
    assert np.array_equal(both["rgba"], one)
    assert np.array_equal(draw(samples=1), draw(samples=1, shading="pixel"))
    with pytest.raises(ValueError, match='shading is "quad", and not one of sample, pixel'):
        draw(shading="quad")


def test_project_finds_pixels(square):
    camera = rtrt.Camera((1, 2, 6), (0, 0, 0), fx=70, cx=20, cy=30)
    frame = rtrt.render(square, camera, (64, 48), ["position", "object"], samples=1)
    rows, columns = np.nonzero(frame["object"] == 0)
    places = camera.project(frame["position"][rows, columns], (64, 48))
    assert np.allclose(places, np.stack([columns + 0.5, rows + 0.5], -1), atol=1e-3)
    assert np.isnan(camera.project([[1, 2, 7]], (64, 48))).all()
    assert camera.intrinsics((64, 48)) == pytest.approx((70, 70, 20, 30))


def test_cameras_draw_what_is_between_their_planes(square):
    for near, far, seen in [(0, 4.5, True), (3.5, np.inf, True), (4.5, 9, False), (0, 3.5, False)]:
        camera = rtrt.Camera((0, 0, 4), (0, 0, 0), near=near, far=far)
        assert (rtrt.render(square, camera, (8, 8), ["object"])["object"][4, 4] == 0) == seen


def test_matrices_are_cameras(square):
    placed = rtrt.Camera((1, 2, 6), (0, 1, 0), fov_y=50)
    turned = placed.matrix @ np.diag([1, -1, -1, 1])
    frames = [
        rtrt.render(square, camera, (40, 30), ["object", "depth"])
        for camera in [
            placed,
            rtrt.Camera.from_matrix(placed.matrix, fov_y=50),
            rtrt.Camera.from_matrix(turned[:3], axes="opencv", fov_y=50),
        ]
    ]
    for frame in frames[1:]:
        assert np.array_equal(frame["object"], frames[0]["object"])
        seen = frame["object"] >= 0
        assert np.allclose(frame["depth"][seen], frames[0]["depth"][seen], rtol=1e-5)


def test_a_batch_is_its_pictures(glass):
    cameras = [glass.framing(SIZE, (np.sin(angle), 0.4, np.cos(angle))) for angle in np.linspace(0, 6, 7)]
    batch = rtrt.render(glass, cameras, SIZE, ALL)
    for number, camera in enumerate(cameras):
        one = rtrt.render(glass, camera, SIZE, ALL)
        assert same({name: batch[name][number] for name in ALL}, one)
    assert len({digest(picture) for picture in batch["rgba"]}) == 7


def test_threads_lanes_and_backends_change_no_byte(glass):
    cameras = [glass.framing(SIZE, direction) for direction in [(0, 0.3, 1), (1, 0.3, 0), (-1, 0.5, 0.2)]]
    options = [{"threads": 1}, {"threads": 5}, {"lanes": 1}, {}]
    frames = [rtrt.render(glass, cameras, SIZE, ALL, backend=rtrt.Backend("cpu", **how)) for how in options]
    assert all(same(frame, frames[0]) for frame in frames[1:])


def test_a_gpu_changes_no_byte(glass, cpu):
    try:
        gpu = rtrt.Backend("gpu")
    except RuntimeError as error:
        pytest.skip(str(error))
    assert gpu.kind == "gpu"
    for aov in (["rgba"], ALL):
        assert same(rtrt.render(glass, None, SIZE, aov, backend=gpu), rtrt.render(glass, None, SIZE, aov, backend=cpu))


def test_buffers_are_used_again(glass):
    out = rtrt.render(glass, size=SIZE, aov=["rgba", "depth"])
    first = {name: (array.ctypes.data, array.copy()) for name, array in out.items()}
    for array in out.values():
        array[:] = 7
    again = rtrt.render(glass, size=SIZE, out=out)
    assert again is out
    for name, (address, values) in first.items():
        assert out[name].ctypes.data == address and np.array_equal(out[name], values)
    assert set(rtrt.render(glass, None, SIZE, ["object"], out=out)) == {"rgba", "depth", "object"}
    # A part of a larger array.
    film = np.zeros((3, 54, 96, 4), np.uint8)
    rtrt.render(glass, size=SIZE, out={"rgba": film[1]})
    assert np.array_equal(film[1], out["rgba"]) and not film[0].any() and not film[2].any()


def test_transforms_move_what_they_name(square):
    camera = rtrt.Camera((0, 0, 20), (0, 0, 0), fov_y=50)
    away = np.tile(np.eye(4), (2, 1, 1))
    away[0, :3, 3] = (3, 1, 0)
    away[1, :3, 3] = (-4, -1, 0)
    square.set_transforms([0, 1], away)
    moved = rtrt.render(square, camera, (80, 60), ["object"])["object"]
    assert np.array_equal(square.transforms, away.astype(np.float32))
    assert moved[30 - 3, 40 + 9] == 0 and moved[30 + 3, 40 - 12] == 1
    square.hide(1)
    assert 1 not in rtrt.render(square, camera, (80, 60), ["object"])["object"]
    square.set_transform(1, away[1][:3])
    assert np.array_equal(rtrt.render(square, camera, (80, 60), ["object"])["object"], moved)


def test_lights_materials_and_backgrounds_count(square):
    camera = rtrt.Camera((0, 0, 4), (0, 0, 0))
    color = lambda: rtrt.render(square, camera, (8, 8), ["color"], samples=1)["color"][4, 4, :3]
    square.ambient = (0, 0, 0)
    assert np.array_equal(color(), [0, 0, 0])
    square.lights = [rtrt.Light.sun((0, 0, -1))]
    white = color()
    assert (white > 0.9).all() and (white < 1.1).all()
    square.set_material(0, base_color=(1, 0, 0), specular_strength=0)
    assert np.allclose(color(), [1, 0, 0], atol=1e-6)
    texture = square.add_texture(np.full((2, 2, 3), [0, 255, 0], np.uint8))
    square.set_material(0, base_color=(1, 1, 1), base_color_map=texture)
    assert np.allclose(color(), [0, 1, 0], atol=1e-6)
    square.background = None
    assert rtrt.render(square, camera, (8, 8))["rgba"][0, 0].tolist() == [0, 0, 0, 0]
    square.background = (1, 1, 1)
    assert rtrt.render(square, camera, (8, 8))["rgba"][0, 0].tolist() == [255] * 4


def test_animations_play():
    scene = rtrt.Scene.load("demo:moving")
    assert scene.duration > 0
    camera = scene.framing(SIZE)
    pictures = []
    for time in [0, scene.duration / 3, 0]:
        scene.play(time)
        pictures.append(digest(rtrt.render(scene, camera, SIZE)["rgba"]))
    assert pictures[0] == pictures[2] != pictures[1]


def test_files_are_read(tmp_path):
    path = tmp_path / "one.obj"
    path.write_text("o corner\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = rtrt.Scene.load(path)
    assert (scene.objects, scene.triangles, scene.extent) == (1, 1, ([0, 0, 0], [1, 1, 0]))
    assert scene.lights and not rtrt.Scene.load(path, light=False).lights
    with pytest.raises(FileNotFoundError, match="none.obj"):
        rtrt.Scene.load(tmp_path / "none.obj")
    path.write_bytes(b"\0\1\2")
    with pytest.raises(ValueError, match="one.obj"):
        rtrt.Scene.load(path)


def test_the_interpreter_is_free_meanwhile(glass):
    done, counted = threading.Event(), 0

    def work():
        rtrt.render(glass, size=(640, 480), samples=16)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.wait(0.001):
        counted += 1
    thread.join()
    assert counted > 5


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("size, count", [((320, 240), 2000), ((2048, 2048), 20)])
def test_ctrl_c_ends_a_call(glass, cpu, size, count):
    expected = rtrt.render(glass, size=SIZE)["rgba"]
    cameras = [glass.framing(size)] * count
    # Memory that is never touched costs nothing.
    out = {"rgba": np.zeros((count, *size[::-1], 4), np.uint8)}
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    began = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        rtrt.render(glass, cameras, size, out=out, samples=16, backend=cpu)
    assert time.monotonic() - began < 10
    assert np.array_equal(rtrt.render(glass, size=SIZE, backend=cpu)["rgba"], expected)


def test_threads_share_scenes_and_backends(glass):
    expected, results = rtrt.render(glass, size=SIZE)["rgba"], []
    threads = [
        threading.Thread(target=lambda: results.append(rtrt.render(glass, size=SIZE)["rgba"])) for _ in range(6)
    ]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(results) == 6 and all(np.array_equal(result, expected) for result in results)


def forked(queue):
    scene = rtrt.Scene.load("demo:glass")
    hits = scene.closest((0, 1, 9), (0, 0, -1))
    queue.put((digest(rtrt.render(scene, size=SIZE)["rgba"]), float(hits["t"])))


def test_forked_processes_render(glass):
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("no fork")
    expected = digest(rtrt.render(glass, size=SIZE)["rgba"]), float(glass.closest((0, 1, 9), (0, 0, -1))["t"])
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    processes = [context.Process(target=forked, args=(queue,)) for _ in range(2)]
    [process.start() for process in processes]
    assert [queue.get(timeout=60) for _ in processes] == [expected] * 2
    [process.join() for process in processes]


def asked(queue, scene, backend):
    pictures = [rtrt.render(scene, size=SIZE, **how)["rgba"] for how in ({}, {"backend": backend})]
    queue.put((*map(digest, pictures), float(scene.closest((0, 1, 9), (0, 0, -1))["t"])))


def test_processes_forked_while_threads_work_render(glass, cpu):
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("no fork")
    picture = digest(rtrt.render(glass, size=SIZE)["rgba"])
    expected = picture, picture, float(glass.closest((0, 1, 9), (0, 0, -1))["t"])
    done = threading.Event()

    def work(call):
        while not done.is_set():
            call()

    rays = np.broadcast_to(np.float32([0, 0, -1]), (100_000, 3))
    calls = [
        lambda: rtrt.render(glass, size=(640, 480), samples=16),
        lambda: rtrt.render(glass, size=(640, 480), samples=16, backend=cpu),
        lambda: glass.closest((0, 1, 9), rays),
    ]
    threads = [threading.Thread(target=work, args=(call,)) for call in calls]
    [thread.start() for thread in threads]
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    # Each finds other locks taken.
    processes = [context.Process(target=asked, args=(queue, glass, cpu), daemon=True) for _ in range(4)]
    for process in processes:
        process.start()
        done.wait(0.1)
    done.set()
    [thread.join() for thread in threads]
    try:
        assert [queue.get(timeout=60) for _ in processes] == [expected] * 4
    finally:
        [process.kill() for process in processes]


def opened(queue):
    queue.put(rtrt.Backend().kind)


@pytest.mark.skipif(not hasattr(os, "register_at_fork"), reason="no fork")
def test_processes_forked_while_threads_open_backends_open_some():
    """What loads drivers has locks, which a forked process would wait for."""
    done, opening = threading.Event(), threading.Event()

    def work():
        while not done.is_set():
            opening.set()
            rtrt.Backend()

    threads = [threading.Thread(target=work) for _ in range(2)]
    [thread.start() for thread in threads]
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    processes = [context.Process(target=opened, args=(queue,), daemon=True) for _ in range(6)]
    for number, process in enumerate(processes):
        opening.wait()
        # In another part of it.
        time.sleep(0.02 + 0.03 * number)
        process.start()
    done.set()
    [thread.join() for thread in threads]
    try:
        assert len({queue.get(timeout=60) for _ in processes}) == 1
    finally:
        [process.kill() for process in processes]


def test_copies_have_the_same_numbers_and_nothing_in_common(square):
    camera = rtrt.Camera((0, 0, 12), (0, 0, 0))

    def look(scene):
        frame = rtrt.render(scene, camera, (40, 30), ["rgba", "object"])
        return {"t": scene.closest((0, 0, 9), (0, 0, -1))["t"], **frame}

    before = look(square)
    for make in (rtrt.Scene.copy, copy.copy, copy.deepcopy):
        other = make(square)
        assert same(look(other), before) and other.labels == square.labels
        away = np.eye(4)
        away[0, 3] = -3
        other.set_transform(0, away)
        other.set_material(1, base_color=(0, 0, 1))
        other.lights = [rtrt.Light.sun((0, 0, -1))]
        added = other.add_instance(0, 1, name="more")
        after = look(other)
        assert same(look(square), before) and not same(after, before)
        assert (square.objects, other.objects, other.labels[added]["node"]) == (2, 3, "more")
        square.hide(1)
        assert same(look(other), after)
        square.set_transform(1, [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0]])
    moving = rtrt.Scene.load("demo:moving")
    moving.play(0)
    still, other = digest(rtrt.render(moving, size=SIZE)["rgba"]), moving.copy()
    other.play(0.5)
    assert digest(rtrt.render(moving, size=SIZE)["rgba"]) == still != digest(rtrt.render(other, size=SIZE)["rgba"])


def test_a_copy_is_changed_while_its_scene_is_rendered(glass):
    thread = threading.Thread(target=rtrt.render, args=(glass,), kwargs=dict(size=(1280, 720), samples=16))
    thread.start()
    changes = 0
    while thread.is_alive():
        other = glass.copy()
        other.ambient = (changes, 0, 0)
        changes += 1
    assert changes > 0


def test_cameras_are_pickled(square, tmp_path):
    (tmp_path / "cameras.json").write_text(json.dumps({"cameras": [
        {"name": "a", "eye": [3, 2, 4], "look_at": [0, 0, 0], "size": [32, 24], "time": 0.5},
        {"name": "b", "eye": [3, 2, 4], "look_at": [0, 0, 0], "size": [32, 24], "parallel": 4}]}))
    cameras = [
        rtrt.Camera((3, 2, 4), (0, 0, 0), (0.1, 1, 0), fov_y=40, near=2),
        rtrt.Camera((3, 2, 4), (0, 0, 0), fx=40, cy=3),
        *square.load_cameras(tmp_path / "cameras.json"),
        *square.orbit(2),
    ]
    again = pickle.loads(pickle.dumps(cameras))
    for one, other in zip(cameras, again):
        assert (one.name, one.size, one.time, one.clip, repr(one)) == (other.name, other.size, other.time, other.clip, repr(other))
        assert same(*(rtrt.render(square, camera, (32, 24), ["rgba", "depth"]) for camera in (one, other)))
    for state in [(), (3,), ("a", [[0] * 3] * 3, [1, 2, 3], None, None, [0, 1], None, None),
                  ("a", [[0] * 3] * 3, [1], None, None, [0, 1], [0, 5], None)]:
        with pytest.raises((TypeError, ValueError)):
            rtrt.Camera._of_pickle(state)
    broken = ("a", [[np.nan] * 3] * 3, [9], None, (0, -1, None, None), [3, 1], None, np.nan)
    with pytest.raises(ValueError):
        rtrt.render(square, rtrt.Camera._of_pickle(broken), (8, 8))
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(square)


def test_motion_is_that_of_the_command(command, tmp_path):
    subprocess.run(
        [command, "render", "demo:moving", "--size", "96x54", "--frames", "2", "--fps", "4"]
        + ["--aov", tmp_path / "{n}.npz", "--quiet"],
        check=True,
    )
    expected = np.load(tmp_path / "1.npz")["motion"]
    scene = rtrt.Scene.load("demo:moving")
    scene.play(0)
    before = rtrt.Before(scene)
    scene.play(0.25)
    frame = rtrt.render(scene, None, SIZE, ["motion", "object"], before=before)
    assert frame["motion"].tobytes() == expected.tobytes()
    assert np.abs(frame["motion"]).max() > 1 and not frame["motion"][frame["object"] == -1].any()


def test_motion_follows_objects_and_cameras(square):
    # 10 pixels a unit at distance 4.
    cameras = [rtrt.Camera((x, 0, 4), (x, 0, 0), fx=40) for x in (0, 0.5)]
    before = rtrt.Before(square, [cameras[0], cameras[0]])
    square.set_transform(0, [[1, 0, 0, 0.3], [0, 1, 0, 0.2], [0, 0, 1, 0], [0, 0, 0, 1]])
    frames = rtrt.render(square, cameras, (64, 48), ["motion", "object"], samples=1, before=before)
    for number, expected in enumerate([[3, -2], [-2, -2]]):
        seen = frames["object"][number] == 0
        assert seen.sum() > 300 and np.allclose(frames["motion"][number][seen], expected, atol=1e-4)
    for wrong, why in [(None, "needs before"), (before, "before has 2 cameras, but there are 1")]:
        with pytest.raises(ValueError, match=why):
            rtrt.render(square, cameras[0], (64, 48), ["motion"], before=wrong)
    with pytest.raises(ValueError, match="before is of another scene"):
        rtrt.render(rtrt.Scene.load("demo:glass"), cameras, (8, 8), ["motion"], before=before)
    with pytest.raises(ValueError, match="camera is missing"):
        rtrt.Before(square)


def hashes(command, *options):
    lines = subprocess.run([command, "render", *options, "--hash", "--quiet"], check=True, capture_output=True, text=True)
    columns = [line.split("  ") for line in lines.stdout.splitlines()]
    return [column[0] for column in columns if column[1] == "pixels"]


def test_files_of_cameras_are_read_as_the_command_reads_them(command, tmp_path):
    ours = {"fov_y": 40, "cameras": [
        {"name": "a", "eye": [3, 2, 4], "look_at": [0, 0.5, 0], "size": [80, 60], "time": 0.5, "near": 4.5, "far": 5.5},
        {"name": "b", "eye": [-3, 2, 4], "look_at": [0, 0.5, 0], "parallel": 4}]}
    nerf = {"camera_angle_x": 0.8, "w": 64, "h": 48, "k1": 0.1, "frames": [
        {"file_path": "./train/r_0", "transform_matrix": np.eye(4).tolist(), "cx": 20}]}
    scene = rtrt.Scene.load("demo:moving")
    for name, poses, warnings in [("ours.json", ours, 0), ("transforms.json", nerf, 1)]:
        (tmp_path / name).write_text(json.dumps(poses))
        with pytest.warns(UserWarning, match="distortion") if warnings else contextlib.nullcontext():
            cameras = scene.load_cameras(tmp_path / name, SIZE)
        found = []
        for camera in cameras:
            scene.play(camera.time or 0)
            found.append(digest(rtrt.render(scene, camera)["rgba"]))
        assert found == hashes(command, "demo:moving", "--size", "96x54", "--cameras", str(tmp_path / name))
    assert (cameras[0].name, cameras[0].size, cameras[0].time) == ("train_r_0", (64, 48), None)
    cameras = scene.load_cameras(tmp_path / "ours.json")
    assert [(c.name, c.size, c.time) for c in cameras] == [("a", (80, 60), 0.5), ("b", (640, 360), None)]
    assert [c.clip for c in cameras] == [(4.5, 5.5), (0, np.inf)]
    with pytest.raises(ValueError, match="camera 1 has another size than camera 0"):
        rtrt.render(scene, cameras)
    assert rtrt.render(scene, cameras, (8, 6))["rgba"].shape == (2, 6, 8, 4)
    with pytest.raises(FileNotFoundError, match="none.json"):
        scene.load_cameras(tmp_path / "none.json")
    (tmp_path / "bad.json").write_text('{"cameras": [{"eye": [0, 0, 1]}]}')
    with pytest.raises(ValueError, match=r"camera 0 \(0\): it has neither a matrix nor eye"):
        scene.load_cameras(tmp_path / "bad.json")


def test_orbits_are_those_of_the_command(command, tmp_path):
    path = tmp_path / "one.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")
    for name in ["demo:glass", str(path)]:
        scene = rtrt.Scene.load(name)
        cameras = scene.orbit(3, size=SIZE)
        frames = rtrt.render(scene, cameras)
        assert frames["rgba"].shape == (3, 54, 96, 4)
        assert [digest(picture) for picture in frames["rgba"]] == hashes(command, name, "--size", "96x54", "--orbit", "3")
    around = scene.orbit(4, rtrt.Camera((3, 0, 0), (0, 0, 0)))
    assert np.allclose([camera.eye for camera in around], [[3, 0, 0], [0, 0, -3], [-3, 0, 0], [0, 0, 3]], atol=1e-6)
    clipped = scene.orbit(2, rtrt.Camera((3, 0, 0), (0, 0, 0), near=2.5, far=3.5))
    assert [camera.clip for camera in clipped] == [(2.5, 3.5)] * 2
    with pytest.raises(ValueError, match="count is not within 1"):
        scene.orbit(0)


def test_cameras_of_files_keep_their_planes(command, tmp_path):
    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32).tobytes()
    gltf = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"name": "lens", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 1, "zfar": 3.5}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + base64.b64encode(corners).decode()}],
    }
    path = tmp_path / "planes.gltf"
    for far, is_seen in [(3.5, False), (4.5, True)]:
        gltf["cameras"][0]["perspective"]["zfar"] = far
        path.write_text(json.dumps(gltf))
        scene = rtrt.Scene.load(path)
        assert scene.cameras[0].clip == (1, far)
        for camera in (None, scene.cameras[0]):
            assert (rtrt.render(scene, camera, SIZE, ["object"])["object"] >= 0).any() == is_seen
        found = digest(rtrt.render(scene, None, SIZE)["rgba"])
        assert [found] == hashes(command, str(path), "--size", "96x54")


def test_objects_have_labels(tmp_path):
    scene = rtrt.Scene()
    mesh = scene.add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], name="sail")
    plain = scene.add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    red, other = scene.add_material(name="red", base_color=(1, 0, 0)), scene.add_material()
    scene.add_instance(mesh, red, name="boat")
    scene.add_instance(plain, other)
    scene.add_sphere(red)
    names = [(entry["node"], entry["mesh"], entry["material"]) for entry in scene.labels]
    assert names == [("boat", "sail", "red"), ("object 1", "mesh 1", "material 1"), ("object 2", "sphere", "red")]
    for name in ["matchbox", "glass", "spheres", "levels", "moving"]:
        labels = rtrt.Scene.load(f"demo:{name}").labels
        assert all(entry[key] for entry in labels for key in ("node", "mesh", "material"))
