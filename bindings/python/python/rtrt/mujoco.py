"""Pictures of MuJoCo's scenes, with the conventions of `mujoco.Renderer`.

>>> import mujoco, rtrt.mujoco
>>> model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
>>> data = mujoco.MjData(model)
>>> mujoco.mj_forward(model, data)
>>> with rtrt.mujoco.Renderer(model, 240, 320) as renderer:
...     renderer.update_scene(data)
...     renderer.render().shape
(240, 320, 3)

Colors are those of MuJoCo's own pictures as far as its model of light goes: sums of colors as they are shown. Shadows are
traced. Not drawn: reflections, haze and fog, labels, skins and flexes, lights' textures.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

import rtrt

from ._native import shown  # type: ignore[import-not-found]

__all__ = ["Renderer"]

_TYPE = mujoco.mjtGeom
_FLAG = mujoco.mjtRndFlag
_ROUND = 256
"""Corners around a cylinder."""

# Light as it is shown and as sRGB, in steps of 1/255. Pictures are computed with the former as if it were linear.
_SHOWN = np.linspace(0.0, 1.0, 256)
_FROM_SRGB = np.where(_SHOWN <= 0.04045, _SHOWN / 12.92, ((_SHOWN + 0.055) / 1.055) ** 2.4)
_TO_SRGB = np.where(_SHOWN <= 0.0031308, 12.92 * _SHOWN, 1.055 * _SHOWN ** (1 / 2.4) - 0.055)
_FROM_SRGB = np.round(255 * _FROM_SRGB).astype(np.uint8)
_TO_SRGB = np.round(255 * _TO_SRGB).astype(np.uint8)


class Renderer:
    """Renders MuJoCo scenes, as `mujoco.Renderer` does.

    Args:
        model: The model.
        height, width: Of pictures, in pixels.
        max_geom: The most geoms of a picture.
        shadows: "hard", or "soft" or "area" for lights with a bulb radius, or "off".
        samples: 1, 4 or 16 a pixel; those of the model's `visual/quality/offsamples` or the next that is possible, if not
            given. Depth and segmentation have one, in the middle of the pixel.
        backend: An `rtrt.Backend`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        height: int = 240,
        width: int = 320,
        max_geom: int = 10000,
        *,
        shadows: str = "hard",
        samples: int | None = None,
        backend: rtrt.Backend | None = None,
    ) -> None:
        if height < 1 or width < 1:
            raise ValueError(f"height and width are {height} and {width}, and each is 1 or more")
        asked = model.vis.quality.offsamples
        self._samples = samples if samples is not None else 1 if asked <= 1 else 4 if asked <= 4 else 16
        self._model, self._height, self._width = model, height, width
        self._shadows, self._backend = shadows, backend
        self._mjv = mujoco.MjvScene(model=model, maxgeom=max_geom)
        self._option = mujoco.MjvOption()
        self._depth = self._segmentation = False
        self._scene = rtrt.Scene()
        self._scene.background = None
        self._shapes: dict[Any, int] = {}
        self._materials: dict[Any, int] = {}
        self._textures: dict[int, int] = {}
        self._free: dict[Any, list[int]] = {}
        self._shown: list[tuple[Any, int]] = []
        self._numbers = np.zeros(0, int)
        self._looks: list[Any] = []
        self._recipes: dict[Any, list[_Part]] = {}
        self._parts = _Parts([])
        self._matrices = np.zeros((0, 4, 4))
        self._lights: Any = None
        self._sky = _Sky.of(model)
        self._sky_key: Any = None
        self._sky_picture = np.zeros((0, 0, 3), np.uint8)
        self._buffers: dict[str, np.ndarray] = {}
        self._is_open = True

    @property
    def model(self) -> mujoco.MjModel:
        return self._model

    @property
    def scene(self) -> mujoco.MjvScene:
        """The geoms, lights and cameras of the next picture; more can be added after `update_scene`."""
        return self._mjv

    @property
    def height(self) -> int:
        return self._height

    @property
    def width(self) -> int:
        return self._width

    def enable_depth_rendering(self) -> None:
        self._depth, self._segmentation = True, False

    def disable_depth_rendering(self) -> None:
        self._depth = False

    def enable_segmentation_rendering(self) -> None:
        self._depth, self._segmentation = False, True

    def disable_segmentation_rendering(self) -> None:
        self._segmentation = False

    def update_scene(
        self,
        data: mujoco.MjData,
        camera: int | str | mujoco.MjvCamera = -1,
        scene_option: mujoco.MjvOption | None = None,
    ) -> None:
        """Takes over where everything is.

        Args:
            data: The state.
            camera: A name, a number (-1 for the free camera), or an `MjvCamera`.
            scene_option: What is visible.
        """
        if not isinstance(camera, mujoco.MjvCamera):
            number = camera
            if isinstance(number, str):
                number = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_CAMERA.value, number)
                if number == -1:
                    raise ValueError(f'The camera "{camera}" does not exist.')
            if not -1 <= number < self._model.ncam:
                raise ValueError(f"The camera id {number} is out of range [-1, {self._model.ncam}).")
            camera = mujoco.MjvCamera()
            camera.fixedcamid = number
            if number == -1:
                camera.type = mujoco.mjtCamera.mjCAMERA_FREE
                mujoco.mjv_defaultFreeCamera(self._model, camera)
            else:
                camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        # Infinite planes are placed around the camera that the scene has already.
        mujoco.mjv_updateCamera(self._model, data, camera, self._mjv)
        mujoco.mjv_updateScene(
            self._model,
            data,
            scene_option or self._option,
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._mjv,
        )

    def render(self, *, out: np.ndarray | None = None) -> np.ndarray:
        """Renders the scene.

        Returns:
            (height, width, 3) uint8; or, with depth rendering, (height, width) float32, units of the model; or, with
            segmentation rendering, (height, width, 2) int32: object ids and types, -1 where there is nothing.

        Args:
            out: An array of that shape to be filled and returned.
        """
        if not self._is_open:
            raise RuntimeError("render cannot be called after close.")
        numbers = () if self._depth else (2,) if self._segmentation else (3,)
        shape = (self._height, self._width, *numbers)
        if out is not None and out.shape != shape:
            raise ValueError(f"Expected `out.shape == {shape}`. Got `out.shape={out.shape}` instead.")
        self._place()
        if self._depth:
            result: np.ndarray = self._depths()
        elif self._segmentation:
            result = self._ids()
        else:
            result = self._colors()
        if out is None:
            return result
        np.copyto(out, result, casting="unsafe")
        return out

    def close(self) -> None:
        self._is_open = False

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _frame(self, aov: Any, samples: Any, shadows: Any) -> np.ndarray:
        buffers = {aov: self._buffers[aov]} if aov in self._buffers else {}
        frame = rtrt.render(
            self._scene,
            self._camera(),
            (self._width, self._height),
            [aov],
            out=buffers,
            samples=samples,
            # As multisampling does.
            shading="pixel",
            shadows=shadows,
            tone_map="none",
            backend=self._backend,
        )
        self._buffers[aov] = frame[aov]
        return frame[aov]

    def _depths(self) -> Any:
        far = self._model.vis.map.zfar * self._model.stat.extent
        return np.minimum(self._frame("depth", 1, "off"), np.float32(far))

    def _ids(self) -> Any:
        objects = self._frame("object", 1, "off")
        geoms = self._mjv.geoms[: self._mjv.ngeom]
        known = [(geom.objid, geom.objtype) if geom.segid != -1 else (-1, -1) for geom in geoms]
        pairs = np.array(known + [(-1, -1)], np.int32).reshape(-1, 2)
        slots = np.full(self._numbers.max(initial=-1) + 2, -1)
        slots[self._numbers] = self._parts.geoms
        # The object -1 and the slot -1 are the last ones.
        return pairs[slots[objects]]

    def _colors(self) -> np.ndarray:
        self._light()
        shadows = self._shadows if self._mjv.flags[_FLAG.mjRND_SHADOW] else "off"
        picture = self._frame("rgba", self._samples, shadows)
        alpha = picture[..., 3]
        behind = self._behind() if alpha.min() < 255 else None
        result: np.ndarray = shown(picture, _FROM_SRGB, behind)
        return result

    def _behind(self) -> np.ndarray:
        """The sky, (height, width, 3), or black without one."""
        if self._sky is None or not self._mjv.flags[_FLAG.mjRND_SKYBOX]:
            return np.zeros((self._height, self._width, 3), np.uint8)
        camera, *edges = self._lens()
        axes = self._axes(camera).astype(np.float32)
        key = (axes.tobytes(), *edges, camera.orthographic)
        if key != self._sky_key:
            left, right, low, high = edges
            x = left + (right - left) * (np.arange(self._width, dtype=np.float32) + 0.5) / self._width
            y = high - (high - low) * (np.arange(self._height, dtype=np.float32) + 0.5) / self._height
            local = np.empty((self._height, self._width, 3), np.float32)
            local[..., 0] = 0 if camera.orthographic else x
            local[..., 1] = 0 if camera.orthographic else y[:, None]
            local[..., 2] = -1
            # Coordinates one after the other.
            ways = (axes @ local.reshape(-1, 3).T).T
            self._sky_key, self._sky_picture = key, self._sky.toward(ways).reshape(local.shape)
        return self._sky_picture

    # Cameras.

    def _lens(self) -> tuple[mujoco.MjvGLCamera, float, float, float, float]:
        """The camera, and the edges of the picture at distance 1 (left, right, bottom, top)."""
        camera = mujoco.mjv_averageCamera(self._mjv.camera[0], self._mjv.camera[1])
        low, high = camera.frustum_bottom, camera.frustum_top
        half = camera.frustum_width or 0.5 * (high - low) * self._width / self._height
        near = 1.0 if camera.orthographic else camera.frustum_near
        middle = camera.frustum_center
        return camera, (middle - half) / near, (middle + half) / near, low / near, high / near

    @staticmethod
    def _axes(camera: mujoco.MjvGLCamera) -> np.ndarray:
        forward = _unit(camera.forward.tolist())
        right = _unit(_cross(forward, camera.up.tolist()))
        return np.array([right, _cross(right, forward), [-c for c in forward]]).T

    def _camera(self) -> rtrt.Camera:
        camera, left, right, low, high = self._lens()
        matrix = np.eye(4)
        matrix[:3, :3] = self._axes(camera)
        matrix[:3, 3] = camera.pos
        depths = {"near": camera.frustum_near, "far": camera.frustum_far}
        if camera.orthographic:
            return rtrt.Camera.from_matrix(matrix, height=high - low, **depths)
        fx, fy = self._width / (right - left), self._height / (high - low)
        return rtrt.Camera.from_matrix(matrix, fx=fx, fy=fy, cx=-left * fx, cy=high * fy, **depths)

    # Lights.

    def _light(self) -> None:
        ambient = np.zeros(3)
        lights: list[tuple[Any, dict[str, Any]]] = []
        for light in self._mjv.lights[: self._mjv.nlight]:
            ambient += light.ambient
            color = np.pi * np.asarray(light.diffuse, np.float64)
            if not color.any():
                continue
            shadows = {"casts_shadows": bool(light.castshadow)}
            if light.headlight:
                # What the camera sees, its light reaches.
                known = {"position": tuple(self._lens()[0].pos), "color": tuple(color), "casts_shadows": False}
                lights.append((rtrt.Light.point, known))
                continue
            if light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL:
                known = {"direction": tuple(light.dir), "color": tuple(color)}
                lights.append((rtrt.Light.sun, known | shadows))
                continue
            constant, linear, square = light.attenuation
            fades = square > 0 and constant == 0 and linear == 0
            known = {
                "position": tuple(light.pos),
                "color": tuple(color / square if fades else color),
                "inverse_square": fades,
                "radius": float(light.bulbradius),
            } | shadows
            if light.type == mujoco.mjtLightType.mjLIGHT_SPOT and light.cutoff < 90:
                lights.append((rtrt.Light.spot, known | {"direction": tuple(light.dir), "outer": float(light.cutoff)}))
            else:
                lights.append((rtrt.Light.point, known))
        now = (tuple(ambient), lights)
        if now != self._lights:
            self._lights = now
            self._scene.ambient = ambient
            self._scene.lights = [make(**known) for make, known in lights]

    # Geoms.

    def _place(self) -> None:
        """Gives each geom the objects of its shape and material."""
        geoms = self._mjv.geoms[: self._mjv.ngeom]
        # Most geoms look as they did before.
        looks = [
            (
                geom.type, geom.dataid, geom.matid, geom.rgba.tobytes(), geom.size.tobytes(), geom.emission,
                geom.specular, geom.shininess,
            )
            for geom in geoms
        ]
        is_same = looks == self._looks
        if not is_same:
            self._looks = looks
            self._parts = _Parts([self._recipe(look, geom) for look, geom in zip(looks, geoms)])
        matrices = self._parts.matrices(geoms)
        if not is_same:
            self._choose(self._parts, matrices)
        elif len(matrices):
            moved = np.nonzero((matrices != self._matrices).any((1, 2)))[0]
            if len(moved):
                self._scene.set_transforms(self._numbers[moved], matrices[moved])
        self._matrices = matrices

    def _choose(self, parts: _Parts, matrices: np.ndarray) -> None:
        """Finds an object for each part, places it, and hides or removes the objects that are left."""
        # What shows something else now can be used for another geom.
        for place, (key, number) in enumerate(self._shown):
            if place >= len(parts.keys) or parts.keys[place] != key:
                self._free.setdefault(key, []).append(number)
        shown = []
        for place, key in enumerate(parts.keys):
            if place < len(self._shown) and self._shown[place][0] == key:
                number = self._shown[place][1]
            elif self._free.get(key):
                number = self._free[key].pop()
            else:
                number = self._add(key, matrices[place])
            shown.append((key, number))
        numbers = [number for _, number in shown]
        left = [number for free in self._free.values() for number in free]
        if len(left) > len(numbers):
            # Hidden objects take time, too.
            for number in left:
                self._scene.remove_object(number)
            self._free.clear()
        else:
            for number in {number for _, number in self._shown}.difference(numbers):
                self._scene.hide(number)
        self._shown, self._numbers = shown, np.array(numbers, int)
        self._scene.set_transforms(self._numbers, matrices)

    def _recipe(self, look: Any, geom: mujoco.MjvGeom) -> list[_Part]:
        """What a geom is made of."""
        if look not in self._recipes:
            self._recipes[look] = self._parts_of(geom)
        return self._recipes[look]

    def _parts_of(self, geom: mujoco.MjvGeom) -> list[_Part]:
        kind, rgba = geom.type, tuple(geom.rgba.tolist())
        if rgba[3] <= 0:
            return []
        size = geom.size.tolist()
        texture = self._texture(geom.matid)
        look = (rgba, geom.emission, geom.specular, geom.shininess, texture)
        half = 0.0
        shape: Any
        if kind == _TYPE.mjGEOM_PLANE:
            far = self._model.vis.map.zfar * self._model.stat.extent
            scale, shape = [size[0] or far, size[1] or far, 1.0], ("plane",)
        elif kind in (_TYPE.mjGEOM_SPHERE, _TYPE.mjGEOM_ELLIPSOID):
            scale, shape = size, ("ellipsoid",)
        elif kind == _TYPE.mjGEOM_BOX:
            scale, shape = size, ("box",)
        elif kind == _TYPE.mjGEOM_CYLINDER:
            scale, shape = size, ("cylinder",)
        elif kind == _TYPE.mjGEOM_CAPSULE:
            half = size[2]
            # One can see into a transparent one.
            if rgba[3] < 1 or texture is not None:
                scale, shape, half = [1.0] * 3, ("capsule", size[0], half), 0.0
            else:
                scale, shape = size, ("tube",)
        elif kind in (_TYPE.mjGEOM_ARROW, _TYPE.mjGEOM_ARROW1, _TYPE.mjGEOM_ARROW2):
            scale, shape = size, ("arrow",)
        elif kind == _TYPE.mjGEOM_MESH:
            scale, shape = [1.0] * 3, ("mesh", geom.dataid // 2)
        elif kind == _TYPE.mjGEOM_HFIELD:
            scale, shape = [1.0] * 3, ("hfield", geom.dataid)
        else:
            return []
        if texture is not None:
            repeat = self._model.mat_texrepeat[geom.matid].tolist()
            is_even = self._model.mat_texuniform[geom.matid] or 0 in size[:2]
            shape = shape + (texture, *repeat, tuple(scale) if is_even else (1.0, 1.0, 1.0))
        scale = [max(s, 1e-6) for s in scale]
        parts: list[_Part] = [((shape, look), scale, 1.0, 0.0)]
        for end in (-half, half) if half else ():
            parts.append(((("ellipsoid",), look), scale, size[0] / half, end / half))
        return parts

    def _add(self, key: Any, matrix: np.ndarray) -> int:
        shape, look = key
        if look not in self._materials:
            (red, green, blue, alpha), emission, specular, shininess, texture = look
            color = np.clip([red, green, blue], 0, 1)
            self._materials[look] = self._scene.add_material(
                base_color=color,
                base_color_map=texture,
                emission=color * emission,
                emission_map=texture,
                specular_strength=min(max(specular, 0.0), 1.0),
                # The exponent of Blinn and Phong as a width of GGX.
                roughness=(2 / (128 * min(max(shininess, 0.0), 1.0) + 2)) ** 0.25,
                alpha=min(alpha, 1.0),
                alpha_mode="blend" if alpha < 1 else "opaque",
                double_sided=False,
            )
        material = self._materials[look]
        if shape == ("ellipsoid",):
            return self._scene.add_sphere(material, transform=matrix)
        if shape not in self._shapes:
            self._shapes[shape] = self._mesh(shape)
        return self._scene.add_instance(self._shapes[shape], material, matrix)

    def _mesh(self, shape: Any) -> int:
        name, *rest = shape
        if name == "mesh":
            positions, normals, uvs = _model_mesh(self._model, rest[0])
        elif name == "hfield":
            (positions, normals), uvs = _hfield(self._model, rest[0]), None
        else:
            make = {"plane": _plane, "box": _box, "cylinder": _cylinder, "tube": _tube, "arrow": _arrow, "ellipsoid": _ball}
            positions, normals = _capsule(*rest[:2]) if name == "capsule" else make[name]()
            uvs = None
        count = {"capsule": 2, "mesh": 1, "hfield": 1}.get(name, 0)
        if len(rest) > count:
            number, *repeat, units = rest[count:]
            source = next(texid for texid, texture in self._textures.items() if texture == number)
            if self._model.tex_type[source] == mujoco.mjtTexture.mjTEXTURE_2D:
                if uvs is None:
                    scaled = positions * units
                    uvs = np.stack([repeat[0] * scaled[:, 0], -repeat[1] * scaled[:, 1]], -1) * 0.5 - 0.5
                else:
                    uvs = uvs * repeat
            else:
                uvs = _cube_uvs(positions, int(self._model.tex_height[source] // self._model.tex_width[source]))
        return self._scene.add_mesh(positions, normals=normals, uvs=uvs)

    def _texture(self, material: int) -> int | None:
        """The texture of a material, by its number in the scene."""
        if material < 0:
            return None
        texid = int(self._model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
        if texid < 0:
            return None
        if texid not in self._textures:
            self._textures[texid] = self._scene.add_texture(_TO_SRGB[_texels(self._model, texid)])
        return self._textures[texid]


def _cross(a: list[float], b: list[float]) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _unit(v: list[float]) -> list[float]:
    length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    return [c / length for c in v]


_Part = tuple[Any, list[float], float, float]
"""What decides on a shape and its material; how the geom's axes are scaled; by how much the third is then, and how far along
it the part is."""


class _Parts:
    """What geoms are made of, one behind the other."""

    def __init__(self, recipes: list[list[_Part]]) -> None:
        parts = [part for recipe in recipes for part in recipe]
        self.keys = [key for key, *_ in parts]
        self.geoms = np.array([geom for geom, recipe in enumerate(recipes) for _ in recipe], int)
        self._scales = np.array([scale for _, scale, *_ in parts]).reshape(-1, 1, 3)
        self._stretches = np.array([stretch for *_, stretch, _ in parts]).reshape(-1, 1)
        self._ends = np.array([end for *_, end in parts]).reshape(-1, 1)

    def matrices(self, geoms: Any) -> np.ndarray:
        """The matrix of each to the world."""
        matrices = np.zeros((len(self.keys), 4, 4))
        if not self.keys:
            return matrices
        turns = np.array([geom.mat for geom in geoms]).reshape(-1, 3, 3)[self.geoms] * self._scales
        matrices[:, :3, 3] = np.array([geom.pos for geom in geoms])[self.geoms] + turns[:, :, 2] * self._ends
        turns[:, :, 2] *= self._stretches
        matrices[:, :3, :3] = turns
        matrices[:, 3, 3] = 1
        return matrices


def _texels(model: mujoco.MjModel, texid: int) -> np.ndarray:
    height, width, channels = (int(a[texid]) for a in (model.tex_height, model.tex_width, model.tex_nchannel))
    first = int(model.tex_adr[texid])
    texels = model.tex_data[first : first + height * width * channels].reshape(height, width, channels)
    return np.repeat(texels, 3, -1) if channels == 1 else texels[..., :3]


# Faces of a cube map are +x, -x, +y, -y, +z, -z from top to bottom of its picture, as OpenGL has them.


def _cube_faces(directions: np.ndarray) -> Any:
    x, y, z = directions.T
    far_x, far_y, far_z = np.abs(x), np.abs(y), np.abs(z)
    beside = np.where(far_y >= far_z, 2 + (y < 0), 4 + (z < 0))
    return np.where((far_x >= far_y) & (far_x >= far_z), x < 0, beside)


def _cube_places(directions: np.ndarray, faces: np.ndarray) -> Any:
    """Places on these faces of a cube map: s and t, 0 to 1."""
    x, y, z = directions.T
    is_x, is_y = faces < 2, (faces == 2) | (faces == 3)
    most = np.abs(np.where(is_x, x, np.where(is_y, y, z)))
    s = np.where(is_x, np.where(x < 0, z, -z), np.where(is_y | (z >= 0), x, -x))
    t = np.where(is_y, np.where(y < 0, -z, z), -y)
    return np.stack([s, t]) / np.maximum(most, 1e-12) * 0.5 + 0.5


def _cube_uvs(positions: np.ndarray, pictures: int) -> np.ndarray:
    """Texture coordinates of corners, three a triangle, in a cube map of six pictures or of one for all faces. A triangle
    lies on one face."""
    faces = np.repeat(_cube_faces(positions.reshape(-1, 3, 3).mean(1)), 3)
    s, t = np.clip(_cube_places(positions, faces), 0.001, 0.999)
    return np.stack([s, (np.minimum(faces, pictures - 1) + t) / pictures], -1)


class _Sky:
    """What is behind everything."""

    def __init__(self, texels: np.ndarray) -> None:
        self.texels = texels

    @staticmethod
    def of(model: mujoco.MjModel) -> _Sky | None:
        skies = np.nonzero(model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX)[0]
        return _Sky(_texels(model, int(skies[0]))) if len(skies) else None

    def toward(self, directions: np.ndarray) -> Any:
        # A skybox is y up: MuJoCo turns it around x.
        x, y, z = directions.T
        turned = np.stack([x, z, -y]).T
        faces = _cube_faces(turned)
        side = self.texels.shape[1]
        columns, rows = np.minimum((_cube_places(turned, faces) * side).astype(np.int32), side - 1)
        first = np.minimum(faces * side, len(self.texels) - side)
        return np.take(self.texels.reshape(-1, 3), (first + rows) * side + columns, 0)


_Shape = tuple[Any, Any]
"""Corners, three a triangle, counterclockwise from outside, and their normals, or None for flat triangles."""


def _quads(grid: np.ndarray) -> np.ndarray:
    """The corners of the triangles of a grid of points."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.stack([a, b, c, a, c, d], 2).reshape(-1, 3)


def _plane() -> _Shape:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    return corners, np.broadcast_to([0.0, 0.0, 1.0], corners.shape)


def _box() -> _Shape:
    front, normal = _plane()
    positions, normals = [], []
    for axis in range(3):
        for sign in (1, -1):
            # Cyclic orders of axes keep the turn, and a half turn around x has z downward.
            face = (front + normal) * ([1, 1, 1] if sign == 1 else [1, -1, -1])
            positions.append(np.roll(face, axis + 1, -1))
            normals.append(np.roll(normal * sign, axis + 1, -1))
    return np.concatenate(positions), np.concatenate(normals)


def _revolved(profile: np.ndarray, normals: np.ndarray) -> _Shape:
    """A profile of (radius, height) from bottom to top, turned around z."""
    angles = np.linspace(0, 2 * np.pi, _ROUND + 1)
    angles[-1] = 0
    turns = np.stack([np.cos(angles), np.sin(angles)], -1)

    def turned(points: np.ndarray) -> np.ndarray:
        flat = points[:, None, :1] * turns[None]
        return np.concatenate([flat, np.broadcast_to(points[:, None, 1:], flat.shape[:2] + (1,))], -1)

    return _quads(turned(profile)), _quads(turned(normals))


def _joined(parts: list[_Shape]) -> _Shape:
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def _tube() -> _Shape:
    return _revolved(np.array([[1.0, -1], [1, 1]]), np.array([[1.0, 0], [1, 0]]))


def _cylinder() -> _Shape:
    parts = [
        _tube(),
        _revolved(np.array([[1.0, 1], [0, 1]]), np.array([[0.0, 1], [0, 1]])),
        _revolved(np.array([[0.0, -1], [1, -1]]), np.array([[0.0, -1], [0, -1]])),
    ]
    return _joined(parts)


def _capsule(radius: float, half: float) -> _Shape:
    angles = np.linspace(0, np.pi / 2, _ROUND // 4 + 1)
    arc = np.stack([np.cos(angles), np.sin(angles)], -1)
    arc[-1] = [0, 1]
    normals = np.concatenate([arc[::-1] * [1, -1], arc])
    ends = np.repeat([[0.0, -half], [0.0, half]], len(arc), 0)
    return _revolved(normals * radius + ends, normals)


def _ball() -> _Shape:
    return _capsule(1.0, 0.0)


def _arrow() -> _Shape:
    """An arrow of length 1 along z; its head is 0.35 of it, and 1.75 times as wide as its shaft."""
    parts = [
        _revolved(np.array([[0.0, 0], [1, 0]]), np.array([[0.0, -1], [0, -1]])),
        _revolved(np.array([[1.0, 0], [1, 0.65]]), np.array([[1.0, 0], [1, 0]])),
        _revolved(np.array([[1.0, 0.65], [1.75, 0.65]]), np.array([[0.0, -1], [0, -1]])),
        _revolved(np.array([[1.75, 0.65], [0, 1]]), np.array([[0.2, 1], [0.2, 1]])),
    ]
    return _joined(parts)


def _model_mesh(model: mujoco.MjModel, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    first, count = int(model.mesh_faceadr[number]), int(model.mesh_facenum[number])
    faces = slice(first, first + count)

    def of(values: np.ndarray, adr: np.ndarray, indices: np.ndarray) -> Any:
        return values[int(adr[number]) + indices[faces]].reshape(-1, values.shape[-1])

    positions = of(model.mesh_vert, model.mesh_vertadr, model.mesh_face)
    normals = of(model.mesh_normal, model.mesh_normaladr, model.mesh_facenormal)
    if model.mesh_texcoordadr[number] < 0:
        return positions, normals, None
    return positions, normals, of(model.mesh_texcoord, model.mesh_texcoordadr, model.mesh_facetexcoord)


def _hfield(model: mujoco.MjModel, number: int) -> _Shape:
    rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    first = int(model.hfield_adr[number])
    heights = model.hfield_data[first : first + rows * columns].reshape(rows, columns)
    half_x, half_y, top, base = model.hfield_size[number]
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    grid = np.stack([x, y, heights * top], -1)
    floor = grid.copy()
    floor[..., 2] = -base
    walls = [
        np.stack([floor[0], grid[0]]),
        np.stack([floor[-1, ::-1], grid[-1, ::-1]]),
        np.stack([floor[::-1, 0], grid[::-1, 0]]),
        np.stack([floor[:, -1], grid[:, -1]]),
        floor[:: rows - 1, :: columns - 1][:, ::-1],
    ]
    return np.concatenate([_quads(grid)] + [_quads(wall) for wall in walls]), None
