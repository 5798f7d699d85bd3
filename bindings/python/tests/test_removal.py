"""What is removed is gone, its number names nothing, and the rest is as it was."""

import threading

import numpy as np
import pytest

import rtrt
from conftest import same

SIZE = (64, 48)
CAMERA = rtrt.Camera((0, 0, 30), (0, 0, 0), fov_y=40)
# Motion needs to know how the scene was.
ALL = [name for name in rtrt.AOVS if name != "motion"]
CORNERS = np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])


def place(x, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def paints(scene):
    looks = [dict(base_color=(0.8, 0.1, 0.1)), dict(base_color=(0.1, 0.1, 0.8), alpha=0.5, alpha_mode="blend"), {}]
    return [scene.add_material(name=f"paint {number}", **look) for number, look in enumerate(looks)]


def made_anew(meshes, objects):
    """A scene of these meshes and objects, and what its numbers of objects are in the other scene."""
    scene = rtrt.Scene()
    materials = paints(scene)
    scene.lights = [rtrt.Light.sun((-1, -2, -3))]
    # The last one stands for -1, nothing.
    known, numbers = {}, np.array(sorted(objects) + [-1])
    for number in sorted(objects):
        mesh, paint, matrix, is_hidden = objects[number]
        if mesh is None:
            new = scene.add_sphere(materials[paint], transform=matrix, name=str(number))
        else:
            if mesh not in known:
                known[mesh] = scene.add_mesh(meshes[mesh], name=str(mesh))
            new = scene.add_instance(known[mesh], materials[paint], matrix, name=str(number))
        if is_hidden:
            scene.hide(new)
    return scene, numbers


def check(scene, meshes, objects):
    """The scene gives what one made anew gives: labels, matrices, boxes, pictures, rays."""
    other, numbers = made_anew(meshes, objects)
    labels = [label | {"object": numbers[label["object"]]} for label in other.labels]
    assert scene.labels == labels and [label["object"] for label in labels] == sorted(objects)
    assert np.array_equal(scene.transforms, other.transforms)
    assert (scene.objects, scene.triangles, scene.extent) == (other.objects, other.triangles, other.extent)
    assert repr(scene) == repr(other)
    ours, theirs = (rtrt.render(each, CAMERA, SIZE, ALL) for each in (scene, other))
    picture = theirs["object"]
    seen = [entry | {"object": numbers[entry["object"]]} for entry in other.seen(picture)]
    theirs["object"] = numbers[picture]
    assert same(ours, theirs) and scene.seen(ours["object"]) == seen
    origins = np.random.default_rng(len(objects)).uniform(-9, 9, (200, 3)) * [1, 1, 0] + [0, 0, 20]
    ours, theirs = (each.closest(origins, np.tile([0, 0, -1], (200, 1)), surfaces=True) for each in (scene, other))
    theirs["object"] = numbers[theirs["object"]]
    assert same(ours, theirs)
    return len(seen)


def test_random_changes_leave_what_a_scene_made_anew_has():
    rng = np.random.default_rng(7)
    scene = rtrt.Scene()
    materials, meshes, objects, given = paints(scene), {}, {}, {"mesh": 0, "object": 0}
    scene.lights = [rtrt.Light.sun((-1, -2, -3))]
    removed, most = 0, 0

    def new(kind, number):
        assert number == given[kind]
        given[kind] += 1
        return number

    for step in range(600):
        matrix, paint = place(*rng.uniform(-8, 8, 3)), rng.integers(3)
        one = rng.choice(sorted(objects)) if objects else None
        unused = sorted(set(meshes) - {mesh for mesh, *_ in objects.values()})
        kind = rng.integers(9)
        if kind == 0 and len(meshes) < 8:
            positions = rng.normal(size=(3 * rng.integers(1, 9), 3)).astype(np.float32)
            meshes[new("mesh", scene.add_mesh(positions, name=str(given["mesh"])))] = positions
        elif kind in (1, 2) and meshes and len(objects) < 30:
            mesh, name = rng.choice(sorted(meshes)), str(given["object"])
            number = scene.add_instance(mesh, materials[paint], matrix, name=name)
            objects[new("object", number)] = (mesh, paint, matrix, False)
        elif kind == 3 and len(objects) < 30:
            number = scene.add_sphere(materials[paint], transform=matrix, name=str(given["object"]))
            objects[new("object", number)] = (None, paint, matrix, False)
        elif kind in (4, 5) and objects:
            scene.remove_object(one)
            del objects[one]
            removed += 1
        elif kind == 6 and unused:
            scene.remove_mesh(unused[0])
            del meshes[unused[0]]
            removed += 1
        elif kind == 7 and objects:
            scene.hide(one)
            objects[one] = (*objects[one][:3], True)
        elif kind == 8 and objects:
            moved = [number for number in sorted(objects) if rng.integers(2)]
            matrices = np.array([place(*rng.uniform(-8, 8, 3)) for _ in moved]).reshape(-1, 4, 4)
            scene.set_transforms(moved, matrices)
            for number, matrix in zip(moved, matrices):
                objects[number] = (*objects[number][:2], matrix, False)
        if step % 30 == 29:
            most = max(most, check(scene, meshes, objects))
    assert removed > 100 and most > 5


def test_the_number_of_what_was_removed_names_nothing(square):
    old = square.add_sphere(1, (0, 0, 3), name="old")
    picture = rtrt.render(square, CAMERA, SIZE, ["object"])["object"]
    square.remove_object(old)
    new = square.add_sphere(1, (0, 0, 3), name="new")
    before = square.transforms, square.labels
    assert (old, new, square.objects) == (2, 3, 3)
    for call in [
        lambda: square.set_transform(old, place(1)),
        lambda: square.hide(old),
        lambda: square.remove_object(old),
    ]:
        with pytest.raises(IndexError, match="there is no object 2: it was removed"):
            call()
    # None is moved.
    with pytest.raises(IndexError, match="objects holds 2 at place 1: it was removed"):
        square.set_transforms([0, old, new], [place(1)] * 3)
    assert np.array_equal(square.transforms, before[0]) and square.labels == before[1]
    with pytest.raises(IndexError, match="there is no object 4: the last object that was added is 3"):
        square.remove_object(4)
    with pytest.raises(IndexError, match="there is no object -1"):
        square.remove_object(-1)
    # The new one is where the old one was, under its own number.
    again = rtrt.render(square, CAMERA, SIZE, ["object"])["object"]
    assert (picture == old).any() and np.array_equal(again, np.where(picture == old, new, picture))
    assert square.closest((0, 0, 9), (0, 0, -1))["object"] == new
    assert [label["object"] for label in square.labels] == [0, 1, 3] and square.labels[2]["node"] == "new"
    # A picture from before the removal shows two that are still there.
    assert [entry["object"] for entry in square.seen(picture)] == [0, 1]
    assert [entry["object"] for entry in square.seen(again)] == [0, 1, 3]
    assert rtrt.Scene.remove_object.__doc__ and repr(square).startswith("<rtrt.Scene of 3 objects")


def test_the_number_of_a_mesh_that_was_removed_names_nothing():
    scene = rtrt.Scene()
    paint = scene.add_material()
    # It has a mesh of its own.
    scene.add_sphere(paint)
    old, other = scene.add_mesh(CORNERS), scene.add_mesh(CORNERS + 1)
    objects = [scene.add_instance(old, paint), scene.add_instance(old, paint, place(3))]
    scene.hide(objects[1])
    for left in (2, 1):
        with pytest.raises(ValueError, match=f"^mesh 0 is in use, number of its objects: {left}; remove those first$"):
            scene.remove_mesh(old)
        scene.remove_object(objects[left - 1])
    scene.remove_mesh(old)
    new = scene.add_mesh(np.concatenate([CORNERS, CORNERS + 2]))
    assert (old, other, new) == (0, 1, 2)
    for call in [
        lambda: scene.add_instance(old, paint),
        lambda: scene.reshape(old, CORNERS),
        lambda: scene.remove_mesh(old),
    ]:
        with pytest.raises(IndexError, match="there is no mesh 0: it was removed"):
            call()
    with pytest.raises(IndexError, match="there is no mesh 3: the last mesh that was added is 2"):
        scene.remove_mesh(3)
    with pytest.raises(IndexError, match="there is no mesh 0: there are no meshes, as added by add_mesh"):
        rtrt.Scene.load("demo:glass").remove_mesh(0)
    scene.reshape(other, CORNERS + 5)
    triangles = scene.triangles
    assert scene.add_instance(new, paint) == 3
    assert (scene.labels[1]["mesh"], scene.triangles) == ("mesh 2", triangles + 2)


def test_all_can_be_removed(square):
    for number in (0, 1):
        square.remove_object(number)
    square.remove_mesh(0)
    assert (square.objects, square.triangles, square.extent, square.labels) == (0, 0, None, [])
    assert square.transforms.shape == (0, 4, 4)
    assert (rtrt.render(square, CAMERA, SIZE, ["object"])["object"] == -1).all()
    assert not square.occluded((0, 0, 9), (0, 0, -1))
    assert square.add_sphere(0) == 2
    assert (rtrt.render(square, CAMERA, SIZE, ["object"])["object"] == 2).any()


def test_copies_remove_on_their_own(square):
    other = square.copy()
    other.remove_object(0)
    other.remove_mesh(0)
    added = square.add_instance(0, 0, place(0, 0, 2)), other.add_sphere(1, (0, 0, 2))
    assert added == (2, 2) and (square.objects, other.objects) == (3, 2)
    square.set_transform(0, place(0, 0, 1))
    with pytest.raises(IndexError, match="it was removed"):
        other.set_transform(0, place(0, 0, 1))
    # A copy of what has gaps has the same ones.
    third = other.copy()
    third.remove_object(2)
    assert third.add_sphere(1) == 3 and [label["object"] for label in other.labels] == [1, 2]
    for scene, hits in [(square, 2), (other, 2), (third, 3)]:
        assert scene.closest((0, 0, 9), (0, 0, -1))["object"] == hits


def test_motion_knows_what_was_removed(square):
    # 10 pixels a unit at distance 4.
    camera = rtrt.Camera((0, 0, 4), (0, 0, 0), fx=40)
    small = square.add_mesh(0.5 * CORNERS)
    square.set_transform(0, place(50))
    kept = square.add_instance(small, 0, place(0.5))
    before = rtrt.Before(square, camera)
    # Its mesh is in front of the other in memory, and the new one is in its place.
    square.remove_object(0)
    square.remove_mesh(0)
    square.set_transform(kept, place(0.8, 0.2))
    square.reshape(small, 0.5 * CORNERS + np.float32([0.1, 0, 0]))
    new = square.add_instance(small, 0, place(-0.8))
    frame = rtrt.render(square, camera, (64, 48), ["motion", "object"], samples=1, before=before)
    for number, expected in [(kept, (4, -2)), (new, (0, 0))]:
        seen = frame["object"] == number
        assert seen.sum() > 20 and np.allclose(frame["motion"][seen], expected, atol=1e-4)


def test_what_was_removed_does_not_move_with_the_animation():
    scene = rtrt.Scene.load("demo:moving")
    scene.play(0)
    start = scene.transforms
    scene.play(0.5)
    moved = np.nonzero((scene.transforms != start).any((1, 2)))[0]
    other = scene.copy()
    scene.play(0)
    scene.remove_object(int(moved[0]))
    new = scene.add_sphere(scene.add_material(), (0, 50, 0))
    at = scene.transforms[-1]
    scene.play(0.5)
    assert np.array_equal(scene.transforms[-1], at)
    assert np.array_equal(scene.transforms[:-1], np.delete(other.transforms, moved[0], 0))
    scene.remove_object(new)
    other.hide(int(moved[0]))
    ours, theirs = (rtrt.render(each, scene.framing(SIZE), SIZE, ALL) for each in (scene, other))
    assert same(ours, theirs) and moved[0] not in ours["object"]


def test_a_gpu_follows():
    try:
        gpu = rtrt.Backend("gpu")
    except RuntimeError as error:
        pytest.skip(str(error))
    scene, cpu = rtrt.Scene(), rtrt.Backend("cpu")
    materials = paints(scene)
    meshes = [scene.add_mesh(CORNERS * size) for size in (1, 2, 3)]
    objects = [scene.add_instance(mesh, materials[mesh], place(3 * mesh - 3)) for mesh in meshes]
    scene.add_sphere(materials[0], (0, 4, 0))

    def look():
        ours, theirs = (rtrt.render(scene, CAMERA, SIZE, ALL, backend=backend) for backend in (gpu, cpu))
        assert same(ours, theirs)
        return set(ours["object"].flat)

    assert look() == {-1, 0, 1, 2, 3}
    scene.remove_object(objects[0])
    assert look() == {-1, 1, 2, 3}
    scene.remove_mesh(meshes[0])
    assert look() == {-1, 1, 2, 3}
    scene.add_instance(scene.add_mesh(CORNERS * 1.5), materials[1], place(-5))
    assert look() == {-1, 1, 2, 3, 4}


def test_nothing_is_removed_while_a_scene_is_rendered(glass):
    scene = glass.copy()
    started = threading.Event()

    def work():
        started.set()
        rtrt.render(scene, size=(1280, 720), samples=16)

    mesh = scene.add_mesh(CORNERS)
    thread = threading.Thread(target=work)
    thread.start()
    started.wait()
    refused, count = set(), scene.objects
    while thread.is_alive():
        for call in (lambda: scene.remove_object(10**6), lambda: scene.remove_mesh(10**6)):
            try:
                call()
            except RuntimeError as error:
                refused.add(str(error))
            except IndexError:
                pass
    assert len(refused) == 1 and "is in use by another call" in refused.pop()
    scene.remove_mesh(mesh)
    scene.remove_object(0)
    assert scene.objects == count - 1


def test_what_makes_an_array_may_remove(square):
    class Late:
        def __array__(self, dtype=None, copy=None):
            square.remove_object(1)
            return np.array([0, 1])

    with pytest.raises(IndexError, match="objects holds 1 at place 1: it was removed"):
        square.set_transforms(Late(), [place(1), place(2)])
    assert np.array_equal(square.transforms, [np.eye(4)])


@pytest.mark.parametrize("number", [None, "0", 0.5, 2**70, [0], object()])
def test_what_is_no_number_is_refused(square, number):
    for call in (square.remove_object, square.remove_mesh):
        with pytest.raises((TypeError, OverflowError)):
            call(number)
    assert square.objects == 2
