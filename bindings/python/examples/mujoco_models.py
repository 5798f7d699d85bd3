"""Models that pictures are compared with: each geom type, textures, lights, a mesh, a height field."""

import mujoco
import numpy as np

HEAD = """
<statistic center="0 0 0.5" extent="2"/>
<visual><global offwidth="1280" offheight="960"/>{quality}</visual>
<asset>
  <texture name="sky" type="skybox" builtin="gradient" rgb1="0.4 0.6 0.8" rgb2="0.05 0.05 0.1" width="256" height="1536"/>
  <texture name="grid" type="2d" builtin="checker" rgb1="0.2 0.3 0.4" rgb2="0.5 0.55 0.6" width="256" height="256"/>
  <texture name="dice" type="cube" builtin="flat" mark="cross" rgb1="0.8 0.5 0.2" markrgb="1 1 1" width="128" height="768"/>
  <material name="grid" texture="grid" texrepeat="2 2" texuniform="true"/>
  <material name="dice" texture="dice"/>
  {assets}
</asset>
"""
FLOOR = '<geom name="floor" type="plane" size="0 0 0.1" material="grid"/>'
SUN = '<light directional="true" pos="0 0 4" dir="-0.4 0.3 -1" diffuse="0.6 0.6 0.6"/>'
CAMERA = '<camera name="eye" pos="2.2 -2.6 1.9" xyaxes="0.76 0.65 0 -0.29 0.34 0.9" fovy="45"/>'

SHAPES = """
<geom type="box" pos="-0.9 -0.2 0.25" size="0.25 0.2 0.25" euler="0 0 30" material="dice"/>
<geom type="sphere" pos="-0.2 -0.5 0.3" size="0.3" rgba="0.8 0.2 0.2 1"/>
<geom type="capsule" pos="0.5 -0.5 0.4" size="0.15 0.25" euler="20 10 0" rgba="0.2 0.7 0.3 1"/>
<geom type="cylinder" pos="0.9 0.3 0.3" size="0.2 0.3" rgba="0.3 0.4 0.9 1"/>
<geom type="ellipsoid" pos="0.1 0.4 0.35" size="0.4 0.2 0.3" euler="0 20 40" rgba="0.8 0.7 0.2 1"/>
<geom type="box" pos="-0.6 0.7 0.5" size="0.3 0.05 0.5" rgba="0.6 0.8 0.9 0.4"/>
"""

ARM = """
<light pos="1 -1 3" dir="-0.3 0.3 -1" cutoff="60" exponent="2" diffuse="0.7 0.7 0.7" castshadow="true"/>
<body pos="0 0 0.1"><joint axis="0 0 1" damping="1"/><geom type="cylinder" size="0.2 0.1" rgba="0.3 0.3 0.3 1"/>
 <body pos="0 0 0.15"><joint axis="0 1 0" damping="1" range="-90 90"/><geom type="capsule" fromto="0 0 0 0 0 0.6" size="0.09" rgba="0.9 0.5 0.1 1"/>
  <body pos="0 0 0.6"><joint axis="0 1 0" damping="1"/><geom type="capsule" fromto="0 0 0 0.5 0 0.1" size="0.07" rgba="0.9 0.5 0.1 1"/>
   <body pos="0.5 0 0.1"><joint axis="1 0 0" damping="1"/><geom type="box" size="0.08 0.1 0.06" rgba="0.2 0.2 0.2 1"/>
    <geom type="box" pos="0.12 0.07 0" size="0.08 0.015 0.03" rgba="0.7 0.7 0.7 1"/>
    <geom type="box" pos="0.12 -0.07 0" size="0.08 0.015 0.03" rgba="0.7 0.7 0.7 1"/>
    <site name="grip" pos="0.15 0 0" size="0.03" rgba="1 0 0 1"/>
 </body></body></body></body>
<body pos="0.8 0.2 0.15"><freejoint/><geom type="box" size="0.1 0.1 0.1" material="dice"/></body>
"""


def pile():
    rng = np.random.default_rng(4)
    bodies = []
    for number in range(30):
        x, y = rng.uniform(-0.7, 0.7, 2)
        kind, size = [("box", "0.1 0.12 0.08"), ("sphere", "0.12"), ("capsule", "0.07 0.1"), ("cylinder", "0.1 0.08"),
                      ("ellipsoid", "0.14 0.1 0.08")][number % 5]
        color = " ".join(f"{c:.2f}" for c in rng.uniform(0.2, 0.9, 3))
        bodies.append(
            f'<body pos="{x:.3f} {y:.3f} {0.3 + 0.12 * number:.3f}"><freejoint/>'
            f'<geom type="{kind}" size="{size}" rgba="{color} 1"/></body>'
        )
    return "".join(bodies)


def humanoid():
    limbs = [
        ("0 -0.07 1.3 0 0.07 1.3", 0.07), ("0 -0.06 1.1 0 0.06 1.1", 0.06), ("0 -0.07 0.95 0 0.07 0.95", 0.09),
        ("0 -0.1 0.9 0.05 -0.12 0.5", 0.06), ("0 0.1 0.9 0.05 0.12 0.5", 0.06), ("0.05 -0.12 0.5 0 -0.12 0.12", 0.05),
        ("0.05 0.12 0.5 0 0.12 0.12", 0.05), ("-0.05 -0.12 0.05 0.14 -0.14 0.05", 0.03),
        ("-0.05 0.12 0.05 0.14 0.14 0.05", 0.03), ("0 -0.17 1.3 0.16 -0.33 1.14", 0.04), ("0 0.17 1.3 0.16 0.33 1.14", 0.04),
        ("0.16 -0.33 1.14 0.34 -0.2 1.25", 0.03), ("0.16 0.33 1.14 0.34 0.2 1.25", 0.03),
    ]
    geoms = "".join(f'<geom type="capsule" fromto="{ends}" size="{r}" rgba="0.8 0.6 0.4 1"/>' for ends, r in limbs)
    balls = "".join(f'<geom size="{r}" pos="{p}" rgba="0.8 0.6 0.4 1"/>' for p, r in
                    [("0 0 1.5", 0.1), ("0.34 -0.2 1.25", 0.045), ("0.34 0.2 1.25", 0.045)])
    return f'<body euler="0 0 -50"><freejoint/>{geoms}{balls}</body>'


def knot():
    """A torus knot, as a mesh in XML."""
    t, s = np.meshgrid(np.linspace(0, 2 * np.pi, 161)[:-1], np.linspace(0, 2 * np.pi, 17)[:-1], indexing="ij")

    def curve(t):
        radius = 0.5 + 0.2 * np.cos(3 * t)
        return np.stack([radius * np.cos(2 * t), radius * np.sin(2 * t), 0.25 * np.sin(3 * t)], -1)

    ahead = curve(t + 1e-3) - curve(t - 1e-3)
    side = np.cross(ahead, [0, 0, 1])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(side, ahead)
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    points = curve(t) + 0.1 * (side * np.cos(s)[..., None] + up * np.sin(s)[..., None])
    index = np.arange(160 * 16).reshape(160, 16)
    a, b = index, np.roll(index, -1, 1)
    c, d = np.roll(b, -1, 0), np.roll(index, -1, 0)
    faces = np.stack([a, d, c, a, c, b], -1).reshape(-1, 3)
    text = lambda values: " ".join(f"{v:.5g}" for v in values.ravel())
    return f'<mesh name="knot" vertex="{text(points)}" face="{text(faces)}"/>'


WORLDS = {
    "shapes": ("", FLOOR + SUN + SHAPES),
    "arm": ("", FLOOR + ARM),
    "pile": ("", FLOOR + SUN + pile()),
    "humanoid": ("", FLOOR + SUN + humanoid()),
    "knot": (
        knot(),
        FLOOR + SUN + '<geom type="mesh" mesh="knot" pos="0 0 0.8" euler="60 0 20" rgba="0.3 0.6 0.8 1"/>'
        '<geom type="mesh" mesh="knot" pos="-0.6 0.9 0.4" rgba="0.8 0.4 0.3 1"/>',
    ),
    "terrain": (
        '<hfield name="hills" nrow="60" ncol="80" size="1.5 1.2 0.5 0.1"/>',
        SUN + '<geom type="hfield" hfield="hills" rgba="0.4 0.6 0.3 1"/>'
        '<geom type="sphere" size="0.2" pos="0.2 -0.2 0.8" rgba="0.9 0.3 0.2 1"/>',
    ),
}
NAMES = list(WORLDS)


def load(name, fine=False):
    """A model with its state after half a second, seen by the camera "eye".

    Args:
        name: One of NAMES.
        fine: Whether MuJoCo's own renderers draw round shapes with so many facets that these hardly count.
    """
    assets, world = WORLDS[name]
    quality = '<quality numslices="256" numstacks="256"/>' if fine else ""
    head = HEAD.format(assets=assets, quality=quality)
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{head}<worldbody>{CAMERA}{world}</worldbody></mujoco>")
    if model.nhfield:
        x, y = np.meshgrid(np.linspace(0, 7, 80), np.linspace(0, 5, 60))
        model.hfield_data[:] = (0.5 + 0.25 * (np.sin(x) * np.cos(1.3 * y) + np.cos(0.7 * x + y))).ravel()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 250)
    mujoco.mj_forward(model, data)
    return model, data
