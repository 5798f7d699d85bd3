"""Rays: right values, shapes, and the answers of pictures."""

import numpy as np
import pytest

import rtrt


def test_hits_follow_from_arithmetic(square):
    hits = square.closest([[0.5, 0.25, 4], [5, 0, 3], [9, 9, 9]], [[0, 0, -2], [0, 0, -1], [0, 0, 1]], surfaces=True)
    assert hits["t"] == pytest.approx([2, 2, np.inf])
    assert hits["object"].tolist() == [0, 1, -1]
    assert hits["material"].tolist() == [0, 1, -1]
    assert np.allclose(hits["position"], [[0.5, 0.25, 0], [5, 0, 1], [0, 0, 0]], atol=1e-6)
    assert np.allclose(hits["normal"], [[0, 0, 1], [0, 0, 1], [0, 0, 0]], atol=1e-6)
    assert np.allclose(hits["uv"][0], [0.75, 0.375], atol=1e-6)
    # Right of the diagonal is the first triangle, (0, 1, 2).
    assert hits["triangle"][0] == 0 and hits["triangle"][2] == -1
    assert np.allclose(hits["barycentrics"][0], [0.125, 0.625], atol=1e-6)


def test_ranges_and_sides(square):
    down = [0, 0, -1]
    for far, expected in [(3.9, False), (4.1, True)]:
        assert square.occluded([0, 0, 4], down, far=far) == expected
    assert square.occluded([[0, 0, 4]] * 2, [down] * 2, far=[1, 9]).tolist() == [False, True]
    assert not square.occluded([0, 0, 4], down, near=4.5)
    assert square.occluded([0, 0, -4], [0, 0, 1]) and not square.occluded([0, 0, -4], [0, 0, 1], sides="fronts")


def test_one_origin_serves_all_and_shapes_stay(square):
    directions = np.zeros((2, 3, 3))
    directions[..., 2] = -1
    hits = square.closest((0, 0, 4), directions)
    assert hits["t"].shape == (2, 3) and hits["barycentrics"].shape == (2, 3, 2) and hits["t"] == pytest.approx(4)
    assert square.occluded(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)
    assert square.closest((0, 0, 4), (0, 0, -1))["t"].shape == ()


def test_rays_hit_what_pictures_show(glass):
    size = (40, 30)
    camera = glass.framing(size)
    frame = rtrt.render(glass, camera, size, ["object", "depth"], samples=1)
    fx, fy, cx, cy = camera.intrinsics(size)
    columns, rows = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    local = np.stack([(columns - cx) / fx, (cy - rows) / fy, np.full_like(rows, -1)], -1)
    hits = glass.closest(camera.eye, local @ camera.matrix[:3, :3].T, sides="drawn")
    same = hits["object"] == frame["object"]
    assert same.mean() > 0.98
    seen = same & (hits["object"] >= 0)
    assert seen.sum() > 100 and np.allclose(hits["t"][seen], frame["depth"][seen], rtol=1e-3)


def test_moved_objects_are_hit_where_they_are(square):
    assert square.closest((0, 0, 4), (0, 0, -1))["t"] == pytest.approx(4)
    square.set_transform(0, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]])
    assert square.closest((0, 0, 4), (0, 0, -1))["t"] == pytest.approx(3)
    square.hide(0)
    assert square.closest((0, 0, 4), (0, 0, -1))["t"] == np.inf


@pytest.mark.parametrize(
    "origins, directions, options, why",
    [
        ([0, 0], [0, 0, 1], {}, r"origins has the shape \(2,\)"),
        ([0, 0, 0], [[0, 0]], {}, r"directions has the shape \(1, 2\)"),
        ([[0, 0, 0]] * 2, [[0, 0, 1]] * 3, {}, "origins has the shape"),
        ([0, 0, 0], [[0, 0, 1], [0, 0, 0]], {}, "ray 1: .* is not the direction"),
        ([np.nan, 0, 0], [0, 0, 1], {}, "ray 0: the point .*NaN"),
        ([0, 0, 0], [0, 0, 1], {"near": np.nan}, "ray 0: a ray cannot reach"),
        ([0, 0, 0], [0, 0, 1], {"far": [1, 2]}, "far holds 2 numbers"),
        ([0, 0, 0], [0, 0, 1], {"sides": "left"}, "sides is \"left\", and not one of both, fronts"),
    ],
)
def test_wrong_rays_are_named(square, origins, directions, options, why):
    for ask in (square.closest, square.occluded):
        with pytest.raises(ValueError, match=why):
            ask(origins, directions, **options)
