# SPDX-License-Identifier: Apache-2.0
# Types of the module; help(sheen) says what each is.
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path = Union[str, bytes, os.PathLike[str], os.PathLike[bytes]]

__version__: str

class Error(Exception): ...
class FileError(Error, OSError): ...
class ConfigError(Error, ValueError): ...

class Camera:
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def intrinsics(self) -> NDArray[np.float64]: ...
    @property
    def camera_from_object(self) -> NDArray[np.float64]: ...
    @property
    def lens(self) -> Literal["opencv", "fisheye"]: ...
    @property
    def distortion(self) -> NDArray[np.float64]: ...

class Model:
    @property
    def path(self) -> Path: ...
    @property
    def kind(self) -> Literal["surface_light_field", "irradiance_field", "intrinsic_lumigraph"]: ...
    @property
    def images(self) -> int: ...
    @property
    def metadata(self) -> dict[str, str]: ...
    @property
    def light_kind(self) -> Literal["fixed", "directional", "point"]: ...
    @property
    def lights(self) -> NDArray[np.float64]: ...
    @property
    def cameras(self) -> list[Camera]: ...
    @property
    def bounds(self) -> NDArray[np.float64]: ...
    def mesh(self) -> tuple[NDArray[np.float64], NDArray[np.uint32]]: ...
    def render(
        self,
        *,
        eye: ArrayLike | None = None,
        target: ArrayLike | None = None,
        up: ArrayLike | None = None,
        field_of_view: float | None = None,
        intrinsics: ArrayLike | None = None,
        camera_from_object: ArrayLike | None = None,
        camera: Camera | None = None,
        width: int | None = None,
        height: int | None = None,
        light: ArrayLike | None = None,
    ) -> NDArray[np.float32]: ...
    def render_srgb8(
        self,
        *,
        eye: ArrayLike | None = None,
        target: ArrayLike | None = None,
        up: ArrayLike | None = None,
        field_of_view: float | None = None,
        intrinsics: ArrayLike | None = None,
        camera_from_object: ArrayLike | None = None,
        camera: Camera | None = None,
        width: int | None = None,
        height: int | None = None,
        light: ArrayLike | None = None,
    ) -> NDArray[np.uint8]: ...
    def render_layers(
        self,
        layers: Sequence[str],
        *,
        eye: ArrayLike | None = None,
        target: ArrayLike | None = None,
        up: ArrayLike | None = None,
        field_of_view: float | None = None,
        intrinsics: ArrayLike | None = None,
        camera_from_object: ArrayLike | None = None,
        camera: Camera | None = None,
        width: int | None = None,
        height: int | None = None,
        light: ArrayLike | None = None,
    ) -> dict[str, NDArray[np.float32]]: ...
    def evaluate(
        self,
        dataset: _Path,
        *,
        baselines: bool = False,
        truth: _Path | None = None,
        object: _Path | None = None,
    ) -> dict[str, Any]: ...
    def export(
        self,
        path: _Path,
        form: Literal["gltf", "ply", "obj", "usdz", "splats", "relight", "page", "single"] | None = None,
    ) -> dict[str, Any]: ...

def build(
    dataset: _Path,
    *,
    mesh: _Path | None = None,
    out: _Path | None = None,
    model: Literal["surface_light_field", "irradiance_field", "intrinsic_lumigraph", "auto"] | None = None,
    config: _Path | None = None,
    refine: bool | Literal["mesh", "poses"] | None = None,
    hold_out: int | None = None,
    budget: str | None = None,
    target: str | None = None,
    memory: str | None = None,
    tolerance: str | None = None,
    bytes: str | None = None,
    loss: str | None = None,
    favour: Literal["speed", "accuracy", "size"] | None = None,
) -> dict[str, Any]: ...
def open(path: _Path) -> Model: ...
