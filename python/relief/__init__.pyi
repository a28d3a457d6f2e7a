import os
from typing import Any, Callable, Iterable, Mapping, Sequence, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path = str | os.PathLike[str]
_Buffer = bytes | bytearray | memoryview
_Progress = Callable[[float], object] | None
_Window = tuple[int, int, int, int]
_Transform = Sequence[float]
_Faces = ArrayLike | tuple[ArrayLike, ArrayLike]
_FaceArrays = NDArray[np.int32] | tuple[NDArray[np.int32], NDArray[np.int64]]
_MeshLike = Mesh | tuple[ArrayLike, _Faces]

__version__: str

class Error(ValueError):
    code: str
    where: str
    message: str

class Raster:
    def __init__(
        self,
        values: Any,
        valid: ArrayLike | None = ...,
        nodata: float | None = ...,
        transform: _Transform | None = ...,
        crs: str = ...,
        unit: str = ...,
        dtype: str | None = ...,
    ) -> None: ...
    def __array__(self, dtype: Any = ..., copy: bool | None = ...) -> NDArray[Any]: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def planes(self) -> tuple[NDArray[np.float64], ...]: ...
    @property
    def valid(self) -> NDArray[np.bool_] | None: ...
    nodata: float | None
    transform: list[float] | None
    crs: str
    unit: str
    scale: float
    offset: float
    band_names: list[str]
    metadata: list[tuple[str, str]]

class _File:
    @property
    def levels(self) -> int: ...
    @property
    def size(self) -> int: ...
    @property
    def goal(self) -> tuple[str, float]: ...
    @property
    def max_error(self) -> float: ...
    @property
    def rms_error(self) -> float: ...
    @property
    def finest_level(self) -> int: ...
    @property
    def edited(self) -> bool: ...
    @property
    def chunks(self) -> list[dict[str, Any]]: ...
    @property
    def report(self) -> dict[str, Any] | None: ...
    def bytes_for(self, level: int) -> int: ...
    def bound(self, level: int = ...) -> float | None: ...
    def checksums_ok(self) -> bool: ...
    def tobytes(self) -> bytes: ...
    def write(self, path: _Path) -> None: ...

class _Surface:
    def evaluate(self, places: ArrayLike, derivatives: int = ...) -> Any: ...
    def __call__(self, x: ArrayLike, y: ArrayLike, dx: int = ..., dy: int = ...) -> Any: ...
    def surface_bound(self, level: int = ...) -> float | None: ...

class RasterFile(_File, _Surface):
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def crs(self) -> str: ...
    @property
    def transform(self) -> list[float] | None: ...
    @property
    def unit(self) -> str: ...
    @property
    def nodata(self) -> float | None: ...
    @property
    def scheme(self) -> str: ...
    @property
    def order(self) -> int: ...
    @property
    def profile(self) -> str: ...
    def level_shape(self, level: int) -> tuple[int, int]: ...
    def decode(
        self, level: int = ..., window: _Window | None = ..., bytes: int | None = ..., allow_damage: bool = ...
    ) -> Raster: ...
    def decode_part(
        self, level: int = ..., window: _Window | None = ..., bytes: int | None = ..., allow_damage: bool = ...
    ) -> tuple[Raster, float | None, list[_Window]]: ...
    def coefficients(self, level: int = ...) -> tuple[Any, tuple[int, int]]: ...

class Mesh:
    def __init__(
        self,
        vertices: ArrayLike,
        faces: _Faces,
        creases: Sequence[tuple[int, int, float]] = ...,
        corners: Sequence[tuple[int, float]] = ...,
    ) -> None: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> _FaceArrays: ...
    @property
    def attributes(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.int32] | None]]: ...
    @property
    def labels(self) -> dict[str, tuple[list[str], NDArray[np.int32]]]: ...
    @property
    def creases(self) -> list[tuple[int, int, float]]: ...
    @property
    def corners(self) -> list[tuple[int, float]]: ...
    def repair(self) -> Mesh: ...

class MeshFile(_File):
    def decode(self, level: int = ..., bytes: int | None = ...) -> Mesh: ...

class QuadFile(_File, _Surface):
    def decode(self, level: int = ..., bytes: int | None = ...) -> Mesh: ...

class SplineFile(_File, _Surface):
    @property
    def components(self) -> int: ...
    @property
    def extent(self) -> list[float]: ...
    @property
    def crs(self) -> str: ...
    @property
    def unit(self) -> str: ...
    def decode(self, level: int = ..., bytes: int | None = ...) -> Mesh: ...
    def grid(
        self, first: Sequence[float], step: Sequence[float], shape: Sequence[int], level: int = ...
    ) -> Any: ...

class Pyramid:
    @property
    def levels(self) -> int: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def bands(self) -> list[Any]: ...
    @property
    def layout(self) -> list[dict[str, Any]]: ...
    @property
    def norms(self) -> NDArray[np.float64]: ...
    def synthesise(self, level: int = ...) -> Any: ...
    def coefficients(self, level: int = ...) -> tuple[Any, tuple[int, int]]: ...
    def threshold(self, keep: int | None = ..., above: float | None = ..., metric: str = ...) -> int: ...
    def move(self, level: int, row: int, col: int, delta: float | Sequence[float]) -> None: ...

class MeshPyramid:
    @property
    def levels(self) -> int: ...
    @property
    def scheme(self) -> str: ...
    @property
    def bands(self) -> list[NDArray[np.float64]]: ...
    @property
    def numbers(self) -> NDArray[np.int32]: ...
    def faces(self, level: int = ...) -> _FaceArrays: ...
    def synthesise(self, level: int = ...) -> NDArray[np.float64]: ...

class EditSession:
    def __init__(self, file: RasterFile | MeshFile | QuadFile | SplineFile | _Path | _Buffer) -> None: ...
    def run(self, command: Mapping[str, Any]) -> dict[str, int]: ...
    def replay(self, script: Sequence[Mapping[str, Any]] | Mapping[str, Any]) -> None: ...
    def script(self) -> list[dict[str, Any]]: ...
    @property
    def description(self) -> dict[str, Any]: ...
    @property
    def history(self) -> dict[str, Any]: ...
    def at(self, x: float, y: float) -> dict[str, Any] | None: ...
    def net(
        self, level: int, window: _Window | None = ...
    ) -> tuple[NDArray[np.float32], NDArray[np.uint32]]: ...
    def surface(self, level: int = ...) -> tuple[NDArray[np.float32], NDArray[np.uint32]]: ...
    def measure(self) -> dict[str, Any]: ...
    def compress(self, max_error: float, progress: _Progress = ...) -> Any: ...
    def file(self) -> Any: ...

def open(file: _Path | _Buffer, bytes: int | None = ...) -> Any: ...
def read(
    path: _Path, *, window: _Window | None = ..., columns: Iterable[str] = ..., progress: _Progress = ...
) -> Any: ...
def write(
    path: _Path,
    what: Any,
    *,
    valid: ArrayLike | None = ...,
    nodata: float | None = ...,
    transform: _Transform | None = ...,
    crs: str = ...,
    unit: str = ...,
    driver: str = ...,
    creation_options: Iterable[str] = ...,
    ascii: bool = ...,
    progress: _Progress = ...,
) -> list[str] | None: ...
def encode(
    what: Any,
    path: _Path | None = ...,
    *,
    max_error: float | None = ...,
    rms_error: float | None = ...,
    bytes: float | None = ...,
    keep: float | None = ...,
    lossless: bool = ...,
    scheme: str | None = ...,
    order: int = ...,
    levels: int = ...,
    family: str = ...,
    dual: int = ...,
    map: str = ...,
    exact: bool = ...,
    profile: str = ...,
    effort: int = ...,
    valid: ArrayLike | None = ...,
    nodata: float | None = ...,
    transform: _Transform | None = ...,
    crs: str = ...,
    unit: str = ...,
    lift: str = ...,
    alpha: float | None = ...,
    surface: bool = ...,
    original: _MeshLike | None = ...,
    keep_order: bool = ...,
    over_uv: bool = ...,
    remesh: bool = ...,
    base_faces: int | None = ...,
    features: float | None = ...,
    tolerance: float | None = ...,
    progress: _Progress = ...,
) -> Any: ...
def merge(shards: Iterable[_Path | _Buffer], path: _Path | None = ...) -> RasterFile: ...
def compare(reference: Raster, other: Raster) -> dict[str, Any]: ...
def analyse(
    samples: ArrayLike,
    scheme: str = ...,
    *,
    order: int = ...,
    levels: int = ...,
    family: str = ...,
    dual: int = ...,
    map: str = ...,
    exact: bool = ...,
) -> Pyramid: ...
def fit(
    x: ArrayLike,
    y: ArrayLike,
    z: ArrayLike,
    *,
    weights: ArrayLike | None = ...,
    max_error: float | None = ...,
    rms_error: float | None = ...,
    bytes: float | None = ...,
    lossless: bool = ...,
    vertices: int | None = ...,
    mesh: _MeshLike | None = ...,
    smoothing: float | None = ...,
    energy: str = ...,
    gradients: str = ...,
    levels: int = ...,
    crs: str = ...,
    unit: str = ...,
    path: _Path | None = ...,
    progress: _Progress = ...,
) -> SplineFile: ...
@overload
def subdivide(
    mesh: Mesh,
    faces: None = ...,
    *,
    scheme: str = ...,
    levels: int = ...,
    alpha: float | None = ...,
    limit: bool = ...,
    boundary_corners: bool = ...,
) -> Mesh: ...
@overload
def subdivide(
    mesh: ArrayLike,
    faces: _Faces,
    *,
    scheme: str = ...,
    levels: int = ...,
    alpha: float | None = ...,
    limit: bool = ...,
    boundary_corners: bool = ...,
) -> tuple[NDArray[Any], NDArray[np.int32]]: ...
def remesh(
    mesh: Mesh | ArrayLike,
    faces: _Faces | None = ...,
    *,
    base_faces: int | None = ...,
    levels: int | None = ...,
    features: float | None = ...,
    tolerance: float = ...,
    progress: _Progress = ...,
) -> tuple[Mesh, dict[str, Any]]: ...
def reverse(
    mesh: Mesh | ArrayLike,
    faces: _Faces | None = ...,
    *,
    scheme: str = ...,
    levels: int = ...,
    lift: str = ...,
    boundary_corners: bool = ...,
    omega: float = ...,
) -> MeshPyramid: ...
def set_thread_count(threads: int) -> None: ...
def thread_count() -> int: ...
