"""relief.dask on a cluster of two local processes: the file of one process, to the byte."""

import numpy as np
import pytest
from conftest import hills

import relief

distributed = pytest.importorskip("distributed")
import relief.dask  # noqa: E402


@pytest.fixture(scope="module")
def client():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1",
                                  dashboard_address=None) as cluster, distributed.Client(cluster) as connected:
        yield connected


@pytest.mark.parametrize("options", [{"max_error": 1}, {}, {"max_error": 0.5, "profile": "fast"}])
def test_a_file_is_that_of_one_process(options, client, tmp_path):
    z = hills(900, 1500).astype(np.float32)
    z[100:300, 200:900] = -9999
    relief.write(tmp_path / "dem.tif", z, nodata=-9999, unit="m", crs="EPSG:32611", transform=(0, 30, 0, 0, 0, -30))
    alone = relief.encode(tmp_path / "dem.tif", scheme="fvs", **options)
    file = relief.dask.encode(tmp_path / "dem.tif", tmp_path / "dem.relief", client=client, tiles_each=2, **options)
    assert (tmp_path / "dem.relief").read_bytes() == alone.tobytes() and file.unit == "m"
    in_memory = relief.dask.encode(tmp_path / "dem.tif", client=client, **options)
    assert in_memory.tobytes() == alone.tobytes()
    assert len(client.has_what()) == 2


def test_shards_come_from_both_workers(client):
    z = hills(800, 1300).astype(np.int16)
    first = relief.dask.plan(z, lossless=True)
    workers = list(client.scheduler_info()["workers"])
    first_there, z_there = client.scatter([first, z], broadcast=True)
    parts = [client.submit(relief.dask.shard, first_there, z_there, tiles, workers=[worker], pure=False)
             for worker, tiles in zip(workers, ([0, 3, 4], [1, 2, 5]))]
    shards = client.gather(parts)
    merged = relief.merge([shards[1], first, shards[0]])
    assert merged.tobytes() == relief.encode(z, lossless=True, scheme="fvs").tobytes()
    with pytest.raises(relief.Error, match="no shard has tile 1"):
        relief.merge([first, shards[0]])


def test_dask_arrays_are_computed_where_they_are_needed(client):
    da = pytest.importorskip("dask.array")
    z = hills(700, 1300).astype(np.float32)
    z[5:40, 7:80] = np.nan
    bands = np.stack([z, 2 * z])
    for values, chunks in ((z, (300, 500)), (bands, (1, 256, 256))):
        array = da.from_array(values, chunks=chunks)
        file = relief.dask.encode(array, max_error=1, unit="m", client=client)
        assert file.tobytes() == relief.encode(values, max_error=1, unit="m", scheme="fvs").tobytes()


def test_levels_are_decoded_by_blocks(client, tmp_path):
    da = pytest.importorskip("dask.array")
    z = hills(900, 1300).astype(np.float32)
    z[:50, :50] = np.nan
    file = relief.encode(z, tmp_path / "z.relief", max_error=1, scheme="fvs")
    for level in (0, 2):
        array = relief.dask.decode(tmp_path / "z.relief", level, tile=300)
        assert isinstance(array, da.Array) and array.shape == file.level_shape(level)
        assert np.array_equal(client.compute(array, sync=True), np.asarray(file.decode(level)), equal_nan=True)


def test_what_can_not_be_cut_is_said(client):
    with pytest.raises(relief.Error, match="one process"):
        relief.dask.encode(np.random.default_rng(1).normal(size=(9, 9)) * 10.0 ** np.arange(-150, 120, 30),
                           lossless=True, client=client)
    with pytest.raises(relief.Error, match="not a number|not finite|NODATA"):
        relief.dask.encode(np.full((9, 9), np.nan), client=client)
