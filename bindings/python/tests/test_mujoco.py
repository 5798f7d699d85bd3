"""MuJoCo's scenes: what rays of MuJoCo itself find, its conventions, the same bytes."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
EXAMPLES = Path(__file__).parents[1] / "examples"
sys.path.insert(0, str(EXAMPLES))

import mujoco_models

import rtrt
import rtrt.mujoco

SIZE = (120, 160)


def frames(name, **options):
    model, data = mujoco_models.load(name)
    with rtrt.mujoco.Renderer(model, *SIZE, **options) as renderer:
        renderer.update_scene(data, "eye")
        color = renderer.render().copy()
        renderer.enable_depth_rendering()
        depth = renderer.render().copy()
        renderer.enable_segmentation_rendering()
        return color, depth, renderer.render().copy()


def rays(model, data, option=None):
    """Depth and geom of each pixel, by `mj_ray`."""
    height, width = SIZE
    camera = model.camera("eye").id
    turn = data.cam_xmat[camera].reshape(3, 3)
    scale = 2 * np.tan(np.radians(model.cam_fovy[camera]) / 2) / height
    depth, ids = np.full(SIZE, np.inf), np.full(SIZE, -1)
    groups = np.array([1, 1, 1, 0, 0, 0], np.uint8)
    found = np.zeros(1, np.int32)
    for row in range(height):
        for column in range(width):
            local = np.array([(column + 0.5 - width / 2) * scale, (height / 2 - row - 0.5) * scale, -1.0])
            t = mujoco.mj_ray(model, data, data.cam_xpos[camera], turn @ local, groups, 1, -1, found)
            if t >= 0:
                depth[row, column], ids[row, column] = t, found[0]
    return depth, ids


def edges(ids):
    """Pixels beside one of another object."""
    at = np.zeros(ids.shape, bool)
    for axis in (0, 1):
        for step in (1, -1):
            at |= ids != np.roll(ids, step, axis)
    return at


@pytest.mark.parametrize("name", mujoco_models.NAMES)
def test_geometry_is_what_mujocos_rays_hit(name):
    model, data = mujoco_models.load(name)
    depth, ids = rays(model, data)
    _, found, segmentation = frames(name)
    geoms = segmentation[..., 1] == mujoco.mjtObj.mjOBJ_GEOM
    # Sites are drawn, and no ray hits them.
    sites = segmentation[..., 1] == mujoco.mjtObj.mjOBJ_SITE
    objects = np.where(geoms, segmentation[..., 0], -1)
    inside = ~edges(ids) & ~edges(objects) & ~sites
    far = model.vis.map.zfar * model.stat.extent
    near = inside & (depth < 0.5 * far)
    assert near.mean() > 0.3 and np.array_equal(objects[near], ids[near])
    assert (objects != ids)[~sites].mean() < 0.01
    assert np.abs(found - depth)[near].max() < 1e-4
    sky = inside & np.isinf(depth)
    assert (segmentation[sky] == -1).all() and np.allclose(found[sky], far)


def test_conventions():
    model, data = mujoco_models.load("shapes")
    renderer = rtrt.mujoco.Renderer(model, 48, 64)
    assert (renderer.height, renderer.width, renderer.model) == (48, 64, model)
    renderer.update_scene(data)
    free = renderer.render()
    assert free.shape == (48, 64, 3) and free.dtype == np.uint8
    renderer.update_scene(data, "eye")
    named = renderer.render()
    renderer.update_scene(data, 0)
    assert np.array_equal(renderer.render(), named) and not np.array_equal(free, named)
    out = np.zeros((48, 64, 3), np.float64)
    assert renderer.render(out=out) is out and np.array_equal(out, named)
    with pytest.raises(ValueError, match="out.shape"):
        renderer.render(out=np.zeros((4, 4, 3)))
    with pytest.raises(ValueError, match='The camera "nose" does not exist.'):
        renderer.update_scene(data, "nose")
    with pytest.raises(ValueError, match="The camera id 5 is out of range"):
        renderer.update_scene(data, 5)
    renderer.enable_depth_rendering()
    assert renderer.render().shape == (48, 64) and renderer.render().dtype == np.float32
    renderer.enable_segmentation_rendering()
    assert renderer.render().shape == (48, 64, 2) and renderer.render().dtype == np.int32
    renderer.disable_segmentation_rendering()
    assert np.array_equal(renderer.render(), named)
    renderer.close()
    with pytest.raises(RuntimeError, match="after close"):
        renderer.render()


def test_pictures_follow_the_state():
    model, data = mujoco_models.load("pile")
    with rtrt.mujoco.Renderer(model, *SIZE) as renderer:
        pictures = []
        for _ in range(3):
            renderer.update_scene(data, "eye")
            pictures.append(renderer.render())
            with rtrt.mujoco.Renderer(model, *SIZE) as new:
                new.update_scene(data, "eye")
                assert np.array_equal(new.render(), pictures[-1])
            mujoco.mj_step(model, data, 50)
        assert not np.array_equal(pictures[0], pictures[2])
        # Without what is in group 0, and with a geom of the caller's own.
        option = mujoco.MjvOption()
        option.geomgroup[0] = 0
        renderer.update_scene(data, "eye", option)
        assert not renderer.scene.ngeom
        empty = renderer.render()
        mujoco.mjv_initGeom(
            renderer.scene.geoms[0], mujoco.mjtGeom.mjGEOM_SPHERE, [0.3, 0, 0], [0, 0, 0.5], np.eye(3).ravel(),
            np.float32([1, 0, 0, 1]),
        )
        renderer.scene.ngeom = 1
        assert not np.array_equal(renderer.render(), empty)
        renderer.update_scene(data, "eye")
        assert renderer.scene.ngeom == 31


@pytest.mark.parametrize("name", mujoco_models.NAMES)
def test_same_bytes(name):
    usual = frames(name)
    for options in [{"threads": 1}, {"threads": 7, "lanes": 1}]:
        again = frames(name, backend=rtrt.Backend("cpu", **options))
        assert all(np.array_equal(a, b) for a, b in zip(usual, again))


def test_same_bytes_on_a_gpu():
    try:
        gpu = rtrt.Backend("gpu")
    except RuntimeError as error:
        pytest.skip(str(error))
    for name in ("shapes", "knot"):
        assert all(np.array_equal(a, b) for a, b in zip(frames(name), frames(name, backend=gpu)))


def test_geometry_is_that_of_mujocos_renderer():
    """With OSMesa, in a process of its own: the choice of OpenGL cannot be changed."""
    environment = dict(os.environ, MUJOCO_GL="osmesa")
    script = EXAMPLES / "mujoco_compare.py"
    run = subprocess.run([sys.executable, script, "--check"], env=environment, capture_output=True, text=True)
    if "OSMesa" in run.stderr and run.returncode:
        pytest.skip("no OSMesa: " + run.stderr.splitlines()[-1])
    assert run.returncode == 0, run.stdout + run.stderr


def test_lights_cast_shadows_as_the_model_says():
    xml = """<mujoco><visual><headlight diffuse="0.1 0.1 0.1"/></visual><worldbody>
      <light {kind} pos="0.5 0.5 3" dir="-0.2 -0.2 -1" castshadow="{shadow}"/>
      <camera name="eye" pos="0 -3 2.5" xyaxes="1 0 0 0 0.64 0.77"/>
      <geom type="plane" size="2 2 0.1"/><geom type="box" size="0.4 0.4 0.1" pos="0 0 0.8"/></worldbody></mujoco>"""
    for kind in ('directional="true"', 'cutoff="60"', 'cutoff="180"'):
        pictures = []
        for shadow, is_on in [("true", 1), ("true", 0), ("false", 1)]:
            model = mujoco.MjModel.from_xml_string(xml.format(kind=kind, shadow=shadow))
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
            with rtrt.mujoco.Renderer(model, *SIZE) as renderer:
                renderer.update_scene(data, "eye")
                renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = is_on
                pictures.append(renderer.render())
        shadowed, off, shadowless = pictures
        assert np.array_equal(off, shadowless) and (shadowed != off).mean() > 0.01


def test_looks_that_are_gone_leave_no_objects():
    geoms = "".join(f'<geom type="{kind}" size="0.2 0.2 0.2" pos="{x} 0 0"/>' for x, kind in enumerate(["box", "sphere", "capsule"]))
    xml = f"""<mujoco><worldbody><light pos="1 -2 3"/><camera name="eye" pos="1 -4 1" xyaxes="1 0 0 0 0.2 1"/>
      {geoms}</worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rng, option, pictures = np.random.default_rng(1), mujoco.MjvOption(), set()
    with rtrt.mujoco.Renderer(model, *SIZE) as renderer:
        for step in range(12):
            model.geom_rgba[:, :3] = rng.uniform(0.1, 0.9, (3, 3))
            # Nothing is seen for once.
            option.geomgroup[0] = step != 5
            renderer.update_scene(data, "eye", option)
            with rtrt.mujoco.Renderer(model, *SIZE) as new:
                new.update_scene(data, "eye", option)
                for each in (renderer, new):
                    each.disable_segmentation_rendering()
                color = renderer.render().copy()
                assert np.array_equal(color, new.render())
                for each in (renderer, new):
                    each.enable_segmentation_rendering()
                ids = renderer.render()
                assert np.array_equal(ids, new.render()) and set(ids[..., 0].flat) == ({-1} if step == 5 else {-1, 0, 1, 2})
            pictures.add(color.tobytes())
            # A capsule is three objects. Not more are hidden than are seen.
            assert renderer._scene.objects <= 10
    assert len(pictures) == 12
