"""Rasters encoded and decoded tile by tile on a dask.distributed cluster.

    from distributed import Client
    import relief.dask
    with Client("scheduler:8786") as client:
        file = relief.dask.encode("/shared/dem.tif", "dem.relief", max_error=0.5, client=client)

The file is, byte for byte, that of relief.encode(..., scheme="fvs") in one process. First the calling process makes a
*plan*: it reads the raster twice or three times and encodes every 8th sample of both axes, a 64th of the work. Then
workers make *shards*, each of some tiles of 512 x 512 samples, which need not know each other. At last the shards are
joined without coding anything anew, as `relief merge` does. That is so for rasters with the goals max_error and
lossless, whose tiles are independent; others can not be cut into shards. Source: docs/rasters.md, "In shards".
"""

import functools as _functools
import os as _os

import numpy as _np
from distributed import get_client as _get_client

from . import _goal, _is_path, _relief
from . import open as _open_file

__all__ = ["decode", "encode", "plan", "shard"]


class _Computed:
    """A dask array that is computed window by window, as it is read."""

    def __init__(self, array, client):
        self.shape, self.dtype = array.shape, array.dtype
        self._array, self._client = array, client

    def __getitem__(self, key):
        return self._client.compute(self._array[key], sync=True)


class _Part:
    """A raster of which a block of samples, from (row, col) on, is at hand."""

    def __init__(self, block, shape, row, col):
        self.shape, self.dtype = shape, block.dtype
        self._block, self._row, self._col = block, row, col

    def __getitem__(self, key):
        *planes, rows, cols = key
        return self._block[(*planes, slice(rows.start - self._row, rows.stop - self._row),
                            slice(cols.start - self._col, cols.stop - self._col))]


def plan(what, *, max_error=None, lossless=False, profile="dense", valid=None, nodata=None, transform=None, crs="",
         unit="", progress=None):
    """The plan of a raster, as bytes: the first shard. Arguments as of relief.encode.

    Errors: relief.Error for samples that do not fit the integers of the closed loop (docs/codec.md).
    """
    goal = _goal(max_error, None, None, None, lossless)
    return _relief.plan_raster(what, _relief.ArrayAbout(valid, nodata, transform, crs, unit), goal, profile, progress)


def shard(plan, what, tiles, *, valid=None, nodata=None):
    """A shard, as bytes: the tiles with these numbers of the raster that was planned.

    plan: bytes or a path. what: the raster, of which only the samples of the tiles are read.
    """
    return _relief.encode_shard(_plan(plan), what, _relief.ArrayAbout(valid, nodata, None, "", ""), tiles)


@_functools.lru_cache(maxsize=2)
def _plan(data):
    """Opened once in each process: it is the same for all shards of a raster."""
    return _relief.RasterPlan(data)


def _shard_of_block(plan, block, shape, row, col, tiles, nodata):
    return shard(plan, _Part(_np.asarray(block), shape, row, col), tiles, nodata=nodata)


def _runs(plan, most):
    """Missing tiles, in groups of up to `most` neighbours of one row of tiles."""
    run = []
    for tile in plan.missing_tiles:
        if run and (len(run) == most or tile != run[-1] + 1 or tile % plan.tile_cols == 0):
            yield run
            run = []
        run.append(tile)
    if run:
        yield run


def encode(what, path=None, *, max_error=None, lossless=False, profile="dense", nodata=None, transform=None, crs="",
           unit="", tiles_each=8, client=None):
    """Encodes a raster on a cluster, and opens the file, which is in memory or at `path`.

    what: a path that all workers can read, or a dask array (rows, cols) or (bands, rows, cols), which is computed
    where it is needed: about three times. Goals: max_error or lossless (default). nodata, transform, crs and unit, of
    arrays, as of relief.encode. tiles_each: how many tiles a task has at most. client: None is the current one.
    Errors: relief.Error as of relief.encode, and for samples that do not fit the closed loop's integers.
    """
    client = client or _get_client()
    of_file = _is_path(what)
    if of_file:
        what = _os.path.abspath(what)
    source = what if of_file else _Computed(what, client)
    first = plan(source, max_error=max_error, lossless=lossless, profile=profile, nodata=nodata, transform=transform,
                 crs=crs, unit=unit)
    opened = _relief.RasterPlan(first)
    everywhere = client.scatter(first, broadcast=True, hash=False)
    shards = []
    for tiles in _runs(opened, tiles_each):
        if of_file:
            shards.append(client.submit(shard, everywhere, what, tiles, pure=False))
            continue
        row, col, rows, _ = opened.samples(tiles[0])
        _, last, _, cols = opened.samples(tiles[-1])
        block = client.compute(what[..., row:row + rows, col:last + cols])
        shards.append(client.submit(_shard_of_block, everywhere, block, what.shape, row, col, tiles, nodata,
                                    pure=False))
    return _relief.merge([first, *client.gather(shards)], path)


@_functools.lru_cache(maxsize=8)
def _opened(path, modified):
    """Opened once in each process, and again when it was written anew."""
    del modified
    return _open_file(path)


def _window(path, level, window):
    return _np.stack(_opened(path, _os.stat(path).st_mtime_ns).decode(level, window=window).planes)


def decode(path, level=0, *, tile=512):
    """A level of a file as a dask array of float64 (rows, cols) or (bands, rows, cols), NaN in holes.

    Blocks of tile x tile samples are decoded where they are needed; those of closed-loop files read their tiles only.
    path: one that all workers can read. Needs dask.array.
    """
    import dask
    import dask.array as da

    path = _os.path.abspath(path)
    file = _open_file(path)
    bands = 1 if len(file.shape) == 2 else file.shape[0]
    rows, cols = file.level_shape(level)
    decoded = dask.delayed(_window, pure=True)
    blocks = []
    for row in range(0, rows, tile):
        line = []
        for col in range(0, cols, tile):
            window = (row, col, min(tile, rows - row), min(tile, cols - col))
            shape = (bands, *window[2:])
            line.append(da.from_delayed(decoded(path, level, window), shape, dtype=_np.float64))
        blocks.append(line)
    array = da.concatenate([da.concatenate(line, axis=2) for line in blocks], axis=1)
    return array if bands > 1 else array[0]
