from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypedDict, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
AOVS: list[str]

_Aov = Literal[
    "rgba", "color", "depth", "normal", "albedo", "object", "material", "triangle", "source", "barycentrics", "uv",
    "position", "shadow", "motion",
]
_Shading = Literal["sample", "pixel"]
_Shadows = Literal["off", "hard", "soft", "area"]
_ToneMap = Literal["neutral", "agx", "aces", "none"]
_Sides = Literal["both", "fronts", "backs", "drawn"]
_Size = tuple[int, int]

class _Label(TypedDict):
    object: int
    node: str
    mesh: str
    material: str
    material_id: int
    box: tuple[list[float], list[float]]

class _Seen(TypedDict):
    object: int
    pixels: int
    box_2d: list[int]
    box_3d: list[list[float]]

@final
class Backend:
    def __new__(
        cls,
        kind: Literal["auto", "cpu", "gpu"] = "auto",
        *,
        adapter: str | None = None,
        threads: int | None = None,
        lanes: Literal[1, 8, 16] | None = None,
    ) -> Backend: ...
    @property
    def kind(self) -> str: ...
    @property
    def adapter(self) -> str: ...
    @property
    def threads(self) -> int: ...
    @property
    def why(self) -> str: ...

@final
class Camera:
    def __new__(
        cls,
        eye: ArrayLike,
        look_at: ArrayLike,
        up: ArrayLike | None = None,
        *,
        fov_y: float | None = None,
        height: float | None = None,
        fx: float | None = None,
        fy: float | None = None,
        cx: float | None = None,
        cy: float | None = None,
        near: float = 0.0,
        far: float = ...,
    ) -> Camera: ...
    @staticmethod
    def from_matrix(
        matrix: ArrayLike,
        *,
        axes: Literal["opengl", "opencv"] = "opengl",
        fov_y: float | None = None,
        height: float | None = None,
        fx: float | None = None,
        fy: float | None = None,
        cx: float | None = None,
        cy: float | None = None,
        near: float = 0.0,
        far: float = ...,
    ) -> Camera: ...
    @property
    def name(self) -> str: ...
    @property
    def size(self) -> _Size | None: ...
    @property
    def time(self) -> float | None: ...
    @property
    def clip(self) -> tuple[float, float]: ...
    @property
    def eye(self) -> NDArray[np.float32]: ...
    @property
    def matrix(self) -> NDArray[np.float64]: ...
    def intrinsics(self, size: _Size) -> tuple[float, float, float, float] | None: ...
    def project(self, points: ArrayLike, size: _Size) -> NDArray[np.float64]: ...

@final
class Before:
    def __new__(cls, scene: Scene, camera: Camera | Iterable[Camera] | None = None) -> Before: ...

@final
class Light:
    @staticmethod
    def point(
        position: ArrayLike,
        color: ArrayLike | None = None,
        *,
        reach: float | None = None,
        inverse_square: bool = False,
        radius: float = 0.0,
        casts_shadows: bool = True,
    ) -> Light: ...
    @staticmethod
    def spot(
        position: ArrayLike,
        direction: ArrayLike,
        color: ArrayLike | None = None,
        *,
        outer: float = 45.0,
        inner: float = 0.0,
        reach: float | None = None,
        inverse_square: bool = False,
        radius: float = 0.0,
        casts_shadows: bool = True,
    ) -> Light: ...
    @staticmethod
    def sun(
        direction: ArrayLike, color: ArrayLike | None = None, *, radius: float = 0.0, casts_shadows: bool = True
    ) -> Light: ...
    @property
    def kind(self) -> Literal["point", "spot", "sun"]: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    @property
    def direction(self) -> tuple[float, float, float]: ...
    @property
    def color(self) -> tuple[float, float, float]: ...
    @property
    def casts_shadows(self) -> bool: ...

@final
class Scene:
    ambient: Any
    """Linear RGB; what is assigned is any three numbers."""
    background: Any
    """A color (linear RGB), "environment", or None for nothing."""
    def __new__(cls) -> Scene: ...
    @staticmethod
    def load(path: str | PathLike[str], *, light: bool = True, point_size: float | None = None) -> Scene: ...
    def copy(self) -> Scene: ...
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, _memo: Any) -> Scene: ...
    def light_by_default(self) -> None: ...
    def add_mesh(
        self,
        positions: ArrayLike,
        triangles: ArrayLike | None = None,
        *,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        tangents: ArrayLike | None = None,
        make_tangents: bool = False,
        name: str | None = None,
    ) -> int: ...
    def reshape(
        self,
        mesh: int,
        positions: ArrayLike,
        triangles: ArrayLike | None = None,
        *,
        normals: ArrayLike | None = None,
    ) -> None: ...
    def remove_mesh(self, mesh: int) -> None: ...
    def add_texture(
        self,
        pixels: ArrayLike,
        *,
        content: Literal["color", "cutout", "numbers", "normals"] = "color",
        wrap: Literal["repeat", "clamp", "mirror"] = "repeat",
    ) -> int: ...
    def add_material(
        self,
        *,
        name: str | None = None,
        base_color: ArrayLike = (1.0, 1.0, 1.0),
        base_color_map: int | None = None,
        metallic: float = 0.0,
        roughness: float = 1.0,
        metallic_roughness_map: int | None = None,
        specular: ArrayLike = (0.04, 0.04, 0.04),
        specular_strength: float = 1.0,
        specular_map: int | None = None,
        specular_color_map: int | None = None,
        emission: ArrayLike = (0.0, 0.0, 0.0),
        emission_map: int | None = None,
        normal_map: int | None = None,
        normal_scale: float = 1.0,
        occlusion_map: int | None = None,
        occlusion_strength: float = 1.0,
        alpha: float = 1.0,
        alpha_mode: Literal["opaque", "mask", "blend"] = "opaque",
        alpha_cutoff: float = 0.5,
        double_sided: bool = True,
        unlit: bool = False,
        transmission: float = 0.0,
        transmission_map: int | None = None,
        shadow_catcher: bool = False,  # with no other property
    ) -> int: ...
    def set_material(
        self,
        material: int,
        *,
        base_color: ArrayLike = ...,
        base_color_map: int | None = ...,
        metallic: float = ...,
        roughness: float = ...,
        metallic_roughness_map: int | None = ...,
        specular: ArrayLike = ...,
        specular_strength: float = ...,
        specular_map: int | None = ...,
        specular_color_map: int | None = ...,
        emission: ArrayLike = ...,
        emission_map: int | None = ...,
        normal_map: int | None = ...,
        normal_scale: float = ...,
        occlusion_map: int | None = ...,
        occlusion_strength: float = ...,
        alpha: float = ...,
        alpha_mode: Literal["opaque", "mask", "blend"] = ...,
        alpha_cutoff: float = ...,
        double_sided: bool = ...,
        unlit: bool = ...,
        transmission: float = ...,
        transmission_map: int | None = ...,
        shadow_catcher: bool = ...,
    ) -> None: ...
    def add_instance(
        self, mesh: int, material: int, transform: ArrayLike | None = None, *, name: str | None = None
    ) -> int: ...
    @overload
    def add_sphere(
        self, material: int, center: ArrayLike | None = None, radius: float | None = None, *, transform: None = None,
        name: str | None = None,
    ) -> int: ...
    @overload
    def add_sphere(self, material: int, *, transform: ArrayLike, name: str | None = None) -> int: ...
    def set_transform(self, object: int, transform: ArrayLike) -> None: ...
    def set_transforms(self, objects: ArrayLike, transforms: ArrayLike) -> None: ...
    def remove_object(self, object: int) -> None: ...
    def hide(self, object: int) -> None: ...
    @property
    def transforms(self) -> NDArray[np.float32]: ...
    @property
    def lights(self) -> list[Light]: ...
    @lights.setter
    def lights(self, lights: Sequence[Light]) -> None: ...
    def add_light(self, light: Light) -> None: ...
    def set_environment(
        self,
        source: str | PathLike[str] | ArrayLike,
        *,
        rotation: float = 0.0,
        intensity: float = 1.0,
        blur: float = 0.0,
        sun: bool = True,
    ) -> None: ...
    @property
    def cameras(self) -> list[Camera]: ...
    def load_cameras(self, path: str | PathLike[str], size: _Size | None = None) -> list[Camera]: ...
    def orbit(self, count: int, camera: Camera | None = None, size: _Size | None = None) -> list[Camera]: ...
    @property
    def origin(self) -> tuple[float, float, float]: ...
    def framing(self, size: _Size, direction: ArrayLike | None = None) -> Camera: ...
    @property
    def labels(self) -> list[_Label]: ...
    def seen(self, objects: NDArray[np.int32]) -> list[_Seen]: ...
    def play(self, time: float) -> None: ...
    @property
    def duration(self) -> float | None: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def files(self) -> list[Path]: ...
    @property
    def objects(self) -> int: ...
    @property
    def triangles(self) -> int: ...
    @property
    def extent(self) -> tuple[list[float], list[float]] | None: ...
    def closest(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        near: float = 0.0,
        far: ArrayLike | None = None,
        sides: _Sides = "both",
        surfaces: bool = False,
    ) -> dict[str, NDArray[Any]]: ...
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        near: float = 0.0,
        far: ArrayLike | None = None,
        sides: _Sides = "both",
    ) -> NDArray[np.bool_]: ...

def render(
    scene: Scene,
    camera: Camera | Iterable[Camera] | None = None,
    size: _Size | None = None,
    aov: _Aov | Sequence[_Aov] | None = None,
    *,
    out: dict[str, NDArray[Any]] | None = None,
    samples: Literal[1, 4, 16] = 4,
    shading: _Shading = "sample",
    shadows: _Shadows = "soft",
    layers: int = 8,
    exposure: float = 0.0,
    tone_map: _ToneMap = "neutral",
    before: Before | None = None,
    backend: Backend | None = None,
) -> dict[str, NDArray[Any]]: ...
def meter(
    scene: Scene,
    camera: Camera | None = None,
    size: _Size | None = None,
    *,
    shadows: _Shadows = "soft",
    backend: Backend | None = None,
) -> float: ...
