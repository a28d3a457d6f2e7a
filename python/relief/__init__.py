"""Multiresolution spline surfaces: terrain rasters, meshes and scattered points as small files of smooth surfaces.

    import relief
    file = relief.encode("dem.tif", max_error=0.5)     # every sample within 0.5, verified
    heights = file(x, y)                               # the smooth surface anywhere
    slopes = file(x, y, dx=1)
    coarse = file.decode(level=3)                      # a quarter of a quarter of a quarter

Rasters go in as paths, as NumPy arrays (rows, cols) or (bands, rows, cols), or as anything with a shape, a dtype and
slices, and come out as relief.Raster, which NumPy takes as an array. Nothing large is copied on the way; long calls
leave the interpreter to other threads and end with Ctrl-C. What is wrong with data or arguments is a relief.Error, a
ValueError that says what, where and what to do. docs/python.md is the guide.
"""

import os as _os

import numpy as _np

from . import _relief
from ._relief import (EditSession, Error, Mesh, MeshFile, MeshPyramid, Pyramid, QuadFile, Raster, RasterFile,
                      SplineFile, __version__, set_thread_count, thread_count)

__all__ = ["EditSession", "Error", "Mesh", "MeshFile", "MeshPyramid", "Pyramid", "QuadFile", "Raster", "RasterFile",
           "SplineFile", "analyse", "compare", "encode", "fit", "merge", "open", "read", "remesh", "reverse",
           "set_thread_count", "subdivide", "thread_count", "write"]


def _is_path(thing):
    return isinstance(thing, (str, _os.PathLike))


def _goal(max_error, rms_error, bytes, keep, lossless, default="lossless"):
    """The one goal that is given."""
    given = {"max_error": max_error, "rms_error": rms_error, "bytes": bytes, "keep": keep}
    chosen = [(kind, value) for kind, value in given.items() if value is not None]
    if lossless:
        chosen.append(("lossless", 0.0))
    if len(chosen) > 1:
        raise ValueError("give one goal, not " + " and ".join(kind for kind, _ in chosen))
    if not chosen and default is None:
        return None
    return _relief.Goal(*(chosen[0] if chosen else (default, 0.0)))


def _spec(scheme, order, levels, family, dual, map, exact):
    """None: the best scheme for the goal."""
    plain = (order, levels, family, dual, map, exact) == (2, -1, "compact", 0, "interpolate", False)
    if scheme is None and plain:
        return None
    return _relief.SchemeSpec(scheme or "box", order, levels, family, dual, map, exact)


def _mesh(thing):
    """A mesh, or a pair of vertices and faces as one; else None."""
    if isinstance(thing, Mesh):
        return thing
    if isinstance(thing, tuple) and len(thing) == 2:
        return Mesh(*thing)
    return None


def open(file, bytes=None):
    """Opens a .relief file: RasterFile, MeshFile, QuadFile or SplineFile, by what it holds.

    file: a path, or bytes or another object with a buffer, which is kept and not copied. bytes: sees the first so many
    bytes only; levels that they do not complete are filled in from coarser ones. Nothing that a file says is trusted.
    Errors: relief.Error for damage, and for what is no such file. Source: docs/format.md.

    >>> import numpy as np, relief
    >>> data = relief.encode(np.eye(9), lossless=True).tobytes()
    >>> relief.open(data).shape
    (9, 9)
    >>> relief.open(b"not a file")
    Traceback (most recent call last):
    relief.Error: byte 0: this is not a .relief file
    """
    return _relief.open(file, bytes)


def read(path, *, window=None, columns=(), progress=None):
    """What a file of another format holds.

    A raster of any format of GDAL gives a Raster (of `window` (row, col, rows, cols) only); OBJ, OFF, PLY and STL a
    Mesh; .xyz, .csv and .txt (places (n, 2), values (n,), weights or None), of the columns that are named: x, y, value
    and perhaps weight, or u, v, x, y, z likewise. A .relief file is opened. progress: called with the fraction done.
    Errors: relief.Error naming the file, and its line or byte.
    """
    kind = _relief.kind_of(path)
    if kind == "relief":
        return _relief.open(path, None)
    if kind == "mesh":
        return _relief.read_mesh(path)
    if kind == "points":
        return _relief.read_points(path, list(columns))
    return _relief.read_raster(path, window, progress)


def write(path, what, *, valid=None, nodata=None, transform=None, crs="", unit="", driver="", creation_options=(),
          ascii=False, progress=None):
    """Writes a file, which appears when it is complete.

    what: a Raster, an array (rows, cols) or (bands, rows, cols), or anything with a shape, a dtype and slices, for
    which the other arguments are as for `encode`, becomes a raster of the format of the extension or of GDAL's
    `driver`, with its creation_options; a Mesh or (vertices, faces) .obj, .off, .ply, .stl or .glb; a dict of columns
    (n,) a .csv; an open .relief file itself. Returns, for meshes, the names of what the format can not hold.
    Errors: relief.Error for what can not be written.

    >>> import numpy as np, os, relief, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "slope.tif")
    >>> relief.write(path, np.arange(12, dtype=np.float32).reshape(3, 4), unit="m", transform=(0, 30, 0, 90, 0, -30))
    >>> relief.read(path).unit
    'm'
    """
    mesh = _mesh(what)
    if mesh is not None:
        return _relief.write_mesh(path, mesh, ascii)
    if isinstance(what, dict):
        return _relief.write_columns(path, what)
    if isinstance(what, (RasterFile, MeshFile, QuadFile, SplineFile)):
        return what.write(path)
    about = _relief.ArrayAbout(valid, nodata, transform, crs, unit)
    return _relief.write_raster(path, what, about, driver, list(creation_options), progress)


def encode(what, path=None, *, max_error=None, rms_error=None, bytes=None, keep=None, lossless=False, scheme=None,
           order=2, levels=-1, family="compact", dual=0, map="interpolate", exact=False, profile="dense", effort=1,
           valid=None, nodata=None, transform=None, crs="", unit="", lift="chebyshev", alpha=None, surface=False,
           original=None, keep_order=True, over_uv=False, remesh=False, base_faces=None, features=None, tolerance=None,
           progress=None):
    """Encodes a raster or a mesh, and opens the file, which is in memory or at `path`. Its `report` says what was
    reached, measured on the decoded file.

    what: a path, a Raster, an array (rows, cols) or (bands, rows, cols) of uint8, uint16, int16, uint32, int32, float32
    or float64, masked or not, anything with a shape, a dtype and slices; a Mesh or (vertices, faces).

    One goal: max_error (of any sample or vertex, verified), rms_error, bytes (of the file), keep (coefficients in per
    cent of the samples) or lossless (default); errors in data units.

    Rasters: scheme 'fvs', 'cubic', 'box' or 'barycentric' (None: the best for the goal) with order, levels, family,
    dual, map and exact as of `relief encode`; profile 'dense' or 'fast' of scheme fvs; effort 0 to 2. Of arrays: valid
    (rows, cols), False in holes, which NaN, infinities and the value `nodata` are too; transform, crs and unit as of
    Raster.

    Meshes: scheme 'loop', 'sqrt3' or 'catmull-clark' (None: what makes the smallest file), 'fvs' for quads and
    'powell-sabin' for triangles over the plane (over_uv: of texture coordinates); lift; alpha of sqrt3; surface: errors
    are distances of the surfaces, from the mesh `original` if one is given, of which this is a remesh; keep_order: of
    vertices and faces. remesh: of meshes without levels, with base_faces, levels, features and tolerance as of `remesh`
    (None: what the goal needs), errors being distances from the mesh; effort 0: one remesh, 1: a finer one where the
    goal needs it, 2: the base and levels of the smallest file. The report then has that of the `remesh`.

    progress: called with the fraction done, from 0 to 1; False stops. Errors: relief.Error naming option or element.
    Source: docs/codec.md, docs/reverse-subdivision.md.

    >>> import numpy as np, relief
    >>> heights = 100 * np.hypot(*np.mgrid[-1:1:65j, -1:1:65j])
    >>> file = relief.encode(heights, max_error=0.5)
    >>> bool(np.abs(np.asarray(file.decode()) - heights).max() <= 0.5)
    True
    >>> file.report["bound"]
    0.5
    >>> relief.encode(heights, max_error=-1)
    Traceback (most recent call last):
    relief.Error: the goal max-error must be a number that is not negative
    """
    if not remesh and not (base_faces is features is tolerance is None):
        raise ValueError("base_faces, features and tolerance are for remesh=True")
    kind = _relief.kind_of(what) if _is_path(what) else ""
    mesh = _relief.read_mesh(what) if kind == "mesh" else _mesh(what)
    goal = _goal(max_error, rms_error, bytes, keep, lossless)
    if mesh is not None:
        options = {"lift": lift, "alpha": alpha, "surface": surface, "original": _mesh(original),
                   "keep_order": keep_order, "over_uv": over_uv, "remesh": remesh, "base_faces": base_faces,
                   "features": features, "tolerance": tolerance, "effort": effort}
        return _relief.encode_mesh(mesh, path, goal, scheme or "", levels, options, progress)
    if kind == "points":
        raise ValueError(f"{what}: holds scattered points; relief.fit makes a surface of them")
    spec = _spec(scheme, order, levels, family, dual, map, exact)
    about = _relief.ArrayAbout(valid, nodata, transform, crs, unit)
    return _relief.encode_raster(what, path, about, goal, spec, profile, effort, progress)


def merge(shards, path=None):
    """Joins the plan and the shards of a raster (relief.dask), in any order: paths, or bytes. Opens the file, which is
    in memory or at `path`. Nothing is coded anew. Errors: relief.Error naming the shard by its place in the list.
    """
    return _relief.merge(shards, path)


def compare(reference, other):
    """How far one Raster is from another: a dict of samples, max_error, rms_error, psnr_db, worst (row, col), ..

    Errors: relief.Error when sizes differ or no sample is valid in both.

    >>> import numpy as np, relief
    >>> a, b = relief.Raster(np.zeros((2, 2))), relief.Raster(np.array([[0, 0], [0, 3.0]]))
    >>> relief.compare(a, b)["max_error"], relief.compare(a, b)["worst"]
    (3.0, (1, 1))
    """
    return _relief.compare(reference, other)


def analyse(samples, scheme="cubic", *, order=2, levels=-1, family="compact", dual=0, map="interpolate", exact=False):
    """The pyramid of coefficients of samples (rows, cols) or (components, rows, cols), which must be finite.

    float32 and float64 are read where they lie and give coefficients of the same type; others are taken for float64.
    Options are those of `encode`; levels: -1 is as many as are useful. Errors: relief.Error naming the sample or the
    option. Source: docs/cubic.md, docs/box.md, docs/barycentric.md, docs/fvs-raster.md.

    >>> import numpy as np, relief
    >>> z = np.random.default_rng(1).normal(size=(33, 33)).astype(np.float32)
    >>> pyramid = relief.analyse(z, "box", order=2, levels=3)
    >>> pyramid.dtype, pyramid.threshold(keep=200)
    (dtype('float32'), 200)
    """
    spec = _relief.SchemeSpec(scheme, order, levels, family, dual, map, exact)
    return _relief.analyse(_np.asarray(samples), spec)


def fit(x, y, z, *, weights=None, max_error=None, rms_error=None, bytes=None, lossless=False, vertices=None, mesh=None,
        smoothing=None, energy="", gradients="", levels=0, crs="", unit="", path=None, progress=None):
    """A smooth surface (C1) of scattered points, to be called as s(x, y, dx=0, dy=0). Its `report` says how near it is.

    x, y: (n,). z: (n,) values, or (components, n), 1 to 3 of them: surfaces in space over a plane of parameters.
    weights: (n,), from 0 on. Without more it passes through all points; with max_error it has as many vertices as that
    takes, `vertices` at most; else `vertices` (about so many) or `mesh` (triangles over the plane) ask for least
    squares, with `levels` refinements of them, smoothing (None: by cross validation) and energy 'plate' or 'jumps'.
    gradients: 'adaptive', 'quadratic', 'plane' or 'zero', for surfaces through the points. crs, unit: kept in the file,
    which is in memory or at `path`. Errors: relief.Error naming the point. Source: docs/scattered.md,
    docs/powell-sabin.md.

    >>> import numpy as np, relief
    >>> x, y = np.random.default_rng(1).uniform(size=(2, 500))
    >>> s = relief.fit(x, y, x * y)
    >>> bool(abs(s(0.5, 0.25) - 0.125) < 1e-9), bool(abs(s(0.5, 0.25, dx=1) - 0.25) < 1e-6)
    (True, True)
    >>> s(7, 7)
    nan
    """
    goal = _goal(max_error, rms_error, bytes, None, lossless, default=None)
    if mesh is not None:
        mesh = _mesh(mesh)
    options = _relief.FitOptions(vertices, mesh, smoothing, energy, gradients, levels)
    return _relief.fit(x, y, z, weights, goal, options, crs, unit, path, progress)


def subdivide(mesh, faces=None, *, scheme="loop", levels=1, alpha=None, limit=False, boundary_corners=False):
    """Subdivides a mesh `levels` times: 'loop' and 'sqrt3' for triangles, 'catmull-clark' for all polygons.

    A Mesh gives a Mesh, with its creases, corners, attributes and labels; vertices (n, 3) and faces (m, k), or (indices,
    offsets), give arrays (vertices, faces) in the type of the vertices, float32 or float64, and are read where they lie.
    Vertices keep their numbers, new ones follow. For a Mesh, limit: vertices go to where they go in the end, with
    normals; boundary_corners: boundary vertices of one face stay. alpha: weight of sqrt3, in [0, 2/3).
    Errors: relief.Error naming the face or vertex. Source: docs/reverse-subdivision.md.

    >>> import relief
    >>> vertices, faces = relief.subdivide([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> vertices[3:].tolist()
    [[2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]
    >>> faces.tolist()
    [[0, 3, 5], [1, 4, 3], [2, 5, 4], [3, 4, 5]]
    """
    if isinstance(mesh, Mesh):
        return _relief.subdivide_mesh(mesh, scheme, levels, alpha, limit, boundary_corners)
    if limit or boundary_corners:
        raise ValueError("limit and boundary_corners are for a relief.Mesh")
    return _relief.subdivide_arrays(mesh, faces, scheme, levels, alpha)


def remesh(mesh, faces=None, *, base_faces=None, levels=None, features=None, tolerance=2e-3, progress=None):
    """A mesh of the same shape that is `levels` times the subdivision of a coarse one, and a report of what was reached.

    A Mesh, or vertices (n, 3) and faces as of `subdivide`, of any kind that is an oriented manifold (Mesh.repair). The
    result is a Mesh as `reverse` and `encode` take it. base_faces, levels: of the coarse mesh, about (None: such that
    the result has as many faces as the mesh); features: edges that turn by more degrees stay sharp; tolerance: the
    largest distance of the surfaces, both ways, as a fraction of the diagonal of the mesh. Report: base_faces, levels,
    rms_error and max_error between the surfaces, worst (x, y, z), flips, quality, diagonal, attempts; lengths in the
    units of the mesh. Errors: relief.Error with the place, where the tolerance is not met, or naming the element.
    Source: docs/remeshing.md.

    >>> import numpy as np, relief
    >>> u, v = np.meshgrid(np.arange(40), np.arange(20), indexing="ij")
    >>> a, b = np.pi * u / 20, np.pi * v / 10
    >>> ring = np.stack([(3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)], -1).reshape(-1, 3)
    >>> corner = lambda i, j: (i % 40 * 20 + j % 20).ravel()
    >>> quads = np.stack([corner(u, v), corner(u + 1, v), corner(u + 1, v + 1), corner(u, v + 1)], -1)
    >>> mesh, report = relief.remesh(ring, quads, levels=2, tolerance=0.01)
    >>> report["flips"], report["max_error"] <= 0.01 * report["diagonal"]
    (0, True)
    >>> relief.reverse(mesh).levels
    2
    """
    whole = mesh if isinstance(mesh, Mesh) else Mesh(mesh, faces)
    return _relief.remesh(whole, base_faces, levels, features, tolerance, progress)


def reverse(mesh, faces=None, *, scheme="loop", levels=-1, lift="chebyshev", boundary_corners=False, omega=1.0):
    """The MeshPyramid of a mesh that is the subdivision of a coarser one, whatever its numbering.

    A Mesh, or vertices (n, 3) and faces as of `subdivide`. levels: at most so many (-1: all that there are). lift:
    'none', 'ring', 'chebyshev' or 'least-squares': how coarse meshes are brought near to the fine one; omega in (0, 1]
    smooths them below 1. Errors: relief.Error `no_subdivision_connectivity` and others naming the element.
    Source: docs/reverse-subdivision.md.

    >>> import numpy as np, relief
    >>> tetrahedron = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    >>> vertices, faces = relief.subdivide(*tetrahedron, levels=3)
    >>> pyramid = relief.reverse(vertices, faces)
    >>> pyramid.levels, [len(band) for band in pyramid.bands]
    (3, [4, 6, 24, 96])
    >>> bool(np.allclose(pyramid.bands[0], tetrahedron[0])), bool(abs(pyramid.bands[3]).max() < 1e-12)
    (True, True)
    """
    if isinstance(mesh, Mesh):
        mesh, faces = mesh.vertices, mesh.faces
    return _relief.reverse(mesh, faces, scheme, levels, lift, boundary_corners, omega)
