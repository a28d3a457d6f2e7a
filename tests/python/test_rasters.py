"""Rasters as arrays: the same files as the command line makes, values, views, holes, errors, memory."""

import os
import resource
import subprocess
import sys
import threading

import numpy as np
import pytest
from conftest import hills

import relief

TRANSFORM = (400000.0, 30.0, 0.0, 5200000.0, 0.0, -30.0)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "int16", "uint32", "int32", "float32", "float64"])
def test_all_types_come_back_exactly(dtype, tmp_path):
    z = hills(70, 90).astype(dtype)
    assert np.array_equal(np.asarray(relief.encode(z).decode(), dtype), z)
    path = tmp_path / "z.tif"
    relief.write(path, z, transform=TRANSFORM, crs="EPSG:32611", unit="m")
    back = relief.read(path)
    assert back.dtype == z.dtype and back.unit == "m" and back.crs == "EPSG:32611" and back.transform == list(TRANSFORM)
    assert np.array_equal(np.asarray(back, dtype), z)


@pytest.mark.parametrize("options, flags", [
    ({"max_error": 0.5}, ["--max-error", 0.5]),
    ({"rms_error": 2, "scheme": "box", "levels": 4}, ["--rms-error", 2, "--scheme", "box", "--levels", 4]),
    ({"bytes": 2000}, ["--bytes", 2000]),
    ({"max_error": 1, "profile": "fast"}, ["--max-error", 1, "--profile", "fast"]),
    ({}, []),
])
@pytest.mark.parametrize("order", ["C", "F", "step"])
def test_same_bytes_as_the_program(options, flags, order, program, tmp_path):
    z = hills(130, 117).astype(np.float32)
    relief.write(tmp_path / "z.tif", z)
    program("encode", tmp_path / "z.tif", tmp_path / "z.relief", *flags)
    expected = (tmp_path / "z.relief").read_bytes()
    wide = np.zeros((260, 234), np.float32)
    wide[::2, ::2] = z
    array = {"C": z, "F": np.asfortranarray(z), "step": wide[::2, ::2]}[order]
    assert relief.encode(tmp_path / "z.tif", **options).tobytes() == expected
    # The .tif says what stands for holes, too; only the header knows that.
    file = relief.encode(array, tmp_path / "python.relief", nodata=np.nan, **options)
    assert file.chunks == relief.open(expected).chunks and file.report["bytes"] == file.size
    assert (tmp_path / "python.relief").read_bytes() == file.tobytes()
    assert np.array_equal(np.asarray(file.decode()), np.asarray(relief.open(expected).decode()))


def test_windows_levels_and_prefixes_are_those_of_the_program(program, tmp_path):
    relief.write(tmp_path / "z.tif", hills(600, 700).astype(np.float32), transform=TRANSFORM)
    file = relief.encode(tmp_path / "z.tif", tmp_path / "z.relief", max_error=1)
    program("decode", tmp_path / "z.relief", tmp_path / "w.tif", "--level", 2, "--window", "30,20,50,40")
    expected = relief.read(tmp_path / "w.tif")
    window = file.decode(2, window=(20, 30, 40, 50))
    assert np.array_equal(np.asarray(window), np.asarray(expected)) and window.transform == expected.transform
    need = file.bytes_for(3)
    assert np.array_equal(np.asarray(file.decode(3, bytes=need)), np.asarray(file.decode(3)))
    assert relief.open(tmp_path / "z.relief", bytes=need).finest_level == 3
    assert file.bound(0) <= 1 and relief.open(file.tobytes()).finest_level == 0


def test_sliced_objects_are_read_in_windows():
    z = hills(900, 700).astype(np.int16)

    class Sliced:
        shape, dtype = z.shape, z.dtype
        asked = []

        def __getitem__(self, key):
            self.asked.append(key)
            return z[key]

    expected = relief.encode(z, max_error=2, scheme="fvs").tobytes()
    assert relief.encode(Sliced(), max_error=2, scheme="fvs").tobytes() == expected
    assert {512, 388} <= {rows.stop - rows.start for rows, _ in Sliced.asked}  # strips, not all at once

    class Failing(Sliced):
        def __getitem__(self, key):
            raise OSError("disk gone")

    with pytest.raises(relief.Error, match="disk gone"):
        relief.encode(Failing(), max_error=2)


def test_holes_by_nan_mask_nodata_and_valid():
    z = hills(64, 80)
    holes = np.zeros(z.shape, bool)
    holes[10:20, 30:50] = True
    with_nan = np.where(holes, np.nan, z)
    expected = relief.encode(with_nan, max_error=0.5).tobytes()
    assert relief.encode(np.ma.MaskedArray(z, holes), max_error=0.5).tobytes() == expected
    assert relief.encode(z, valid=~holes, max_error=0.5).tobytes() == expected
    back = relief.encode(np.where(holes, -9999.0, z), nodata=-9999, max_error=0.5).decode()
    assert back.nodata == -9999 and np.array_equal(back.valid, ~holes)
    assert np.array_equal(np.isnan(np.asarray(back)), holes)
    with pytest.raises(relief.Error, match="shape \\(rows, cols\\)"):
        relief.encode(z, valid=holes[:5])


def test_bands_and_views():
    bands = np.stack([hills(40, 50, seed) for seed in (1, 2, 3)])
    raster = relief.Raster(bands)
    assert raster.shape == (3, 40, 50) and np.array_equal(np.asarray(raster), bands)
    plane = raster.planes[1]
    plane[3, 4] = 7
    assert np.asarray(raster)[1, 3, 4] == 7 and raster.planes[1].base is not None
    single = relief.Raster(bands[0])
    assert np.asarray(single).ctypes.data == single.planes[0].ctypes.data  # not copied
    view = single.planes[0]
    del single
    assert np.array_equal(view, bands[0])  # keeps the raster alive
    decoded = relief.encode(bands, max_error=0.5).decode()
    assert np.abs(np.asarray(decoded) - bands).max() <= 0.5


def test_evaluation_is_that_of_the_program(program, tmp_path):
    relief.write(tmp_path / "z.tif", hills(60, 50), transform=TRANSFORM)
    file = relief.encode(tmp_path / "z.tif", tmp_path / "z.relief", rms_error=1)
    places = np.array([[400123.4, 5199000.5], [400700.0, 5198500.0], [0.0, 0.0]])
    listed = [f"--at={x!r},{y!r}" for x, y in places.tolist()]
    expected = np.array(program("eval", tmp_path / "z.relief", "--derivatives", 2, *listed)["values"], float)
    values, gradients, hessians = file.evaluate(places, derivatives=2)
    assert np.array_equal(values, expected[:, 0], equal_nan=True)
    assert np.array_equal(gradients, expected[:, 1:3], equal_nan=True)
    assert np.array_equal(hessians.reshape(3, 4), expected[:, [3, 4, 4, 5]], equal_nan=True)
    assert np.array_equal(file(places[:, 0], places[:, 1], dx=1, dy=1), expected[:, 4], equal_nan=True)
    assert file(*places[0]) == expected[0, 0]
    assert file.evaluate(places.reshape(3, 1, 2)).shape == (3, 1)
    with pytest.raises(relief.Error, match="order 0 to 2"):
        file(0, 0, dx=3)
    with pytest.raises(relief.Error, match=r"\(.., 2\)"):
        file.evaluate(np.zeros(3))


def test_one_component_of_several_is_that_component():
    bands = np.stack([hills(40, 50, seed) for seed in (1, 2)])
    file = relief.encode(bands, max_error=0.1, scheme="fvs")
    at = np.array([[3.25, 7.5], [20.0, 30.0]])
    values, gradients = file.evaluate(at, derivatives=1)
    assert values.shape == (2, 2) and gradients.shape == (2, 2, 2)
    for c in range(2):
        alone = relief.encode(bands[c], max_error=0.1, scheme="fvs")
        assert np.array_equal(alone.evaluate(at), values[:, c])


@pytest.mark.parametrize("make", [
    lambda: relief.encode(np.zeros((0, 5))),
    lambda: relief.encode(np.zeros(5)),
    lambda: relief.encode(np.zeros((5, 2, 2))),
    lambda: relief.encode(np.zeros((2, 2), complex)),
    lambda: relief.encode(np.zeros((2, 2), ">f8")),
    lambda: relief.encode(np.full((2, 2), np.nan)),
    lambda: relief.encode(np.zeros((2, 2)), max_error=1, bytes=5),
    lambda: relief.encode(np.zeros((2, 2)), scheme="wavelet"),
    lambda: relief.encode(np.zeros((2, 2)), profile="slow"),
    lambda: relief.encode(np.zeros((2, 2)), max_error=float("nan")),
    lambda: relief.encode("/nowhere/dem.tif"),
    lambda: relief.open("/nowhere/dem.relief"),
    lambda: relief.open(b""),
    lambda: relief.read("/nowhere/dem.tif"),
    lambda: relief.write("/nowhere/dem.tif", np.zeros((2, 2))),
    lambda: relief.encode(np.zeros((9, 9))).decode(level=99),
    lambda: relief.encode(np.zeros((9, 9))).decode(window=(0, 0, 99, 99)),
    lambda: relief.encode(np.zeros((9, 9))).decode(window=(-1, 0, 3, 3)),
    lambda: relief.encode(np.zeros((9, 9))).bytes_for(-1),
])
def test_wrong_calls_are_value_errors(make):
    with pytest.raises(ValueError) as caught:
        make()
    assert len(str(caught.value)) > 10


def test_errors_say_code_where_and_message(tmp_path):
    bad = tmp_path / "bad.relief"
    bad.write_bytes(b"RELIEF no")
    with pytest.raises(relief.Error) as caught:
        relief.open(bad)
    assert caught.value.code == "bad_file" and str(bad) in caught.value.where and caught.value.message


@pytest.mark.parametrize("options", [{"max_error": 1}, {"rms_error": 2}])
def test_damage_is_an_error_and_no_crash(options):
    data = relief.encode(hills(90, 80), **options).tobytes()
    rng = np.random.default_rng(5)
    for _ in range(300):
        damaged = bytearray(data)
        for at in rng.integers(0, len(data), 3):
            damaged[at] ^= 1 << rng.integers(8)
        damaged = damaged[:rng.integers(len(data) // 2, len(data) + 1)]
        try:
            file = relief.open(damaged)
            file.decode(allow_damage=True)
            file.evaluate([[3.0, 4.0]])
        except relief.Error as error:
            assert str(error)


def test_arrays_are_not_copied_on_the_way_in(tmp_path):
    """A process that encodes 128 MB of float64 to a file needs far less than another 128 MB."""
    program = """
import resource, sys, numpy as np, relief
z = np.zeros((4096, 4096)); z += np.arange(4096.0)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
relief.encode(z, sys.argv[1], max_error=1, profile="fast", scheme="fvs")
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)
"""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", program, tmp_path / "z.relief"], env=environment, text=True,
                          capture_output=True, check=True)
    assert int(done.stdout) < 100  # MB: rows of tiles and their coders


def test_other_threads_run_meanwhile_and_progress_is_told():
    """The interpreter's lock is free during a long call: another thread counts."""
    counted = []
    stop = threading.Event()

    def count():
        while not stop.wait(0.001):
            counted.append(1)

    thread = threading.Thread(target=count)
    thread.start()
    told = []
    relief.encode(hills(1100, 600), max_error=0.1, progress=told.append)
    stop.set()
    thread.join()
    assert len(counted) > 20 and told and told == sorted(told) and told[-1] == 1


def test_progress_ends_a_call():
    with pytest.raises(relief.Error, match="cancelled") as caught:
        relief.encode(hills(600, 600), max_error=0.1, progress=lambda done: False)
    assert caught.value.code == "cancelled"

    class Stop(Exception):
        pass

    def raising(done):
        raise Stop

    with pytest.raises(Stop):
        relief.encode(hills(600, 600), max_error=0.1, progress=raising)


def test_interrupt_ends_a_call(tmp_path):
    program = """
import os, signal, sys, threading, numpy as np, relief
z = np.random.default_rng(1).normal(size=(3000, 3000))
threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    relief.encode(z, sys.argv[1], max_error=0.001)
except KeyboardInterrupt:
    print("interrupted", os.listdir(os.path.dirname(sys.argv[1])))
"""
    done = subprocess.run([sys.executable, "-c", program, tmp_path / "z.relief"], capture_output=True, text=True,
                          check=True, timeout=120)
    assert done.stdout == "interrupted []\n"  # and nothing is left behind


def test_pickles_and_memory_is_bounded():
    import pickle
    file = relief.encode(hills(50, 50), max_error=0.5)
    again = pickle.loads(pickle.dumps(file))
    assert np.array_equal(np.asarray(again.decode()), np.asarray(file.decode()))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(200):  # views, capsules and files are given back
        file.decode().planes[0][0, 0]
        file.evaluate(np.zeros((1000, 2)), derivatives=2)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20 * 1024


def test_compare_is_that_of_the_program(program, tmp_path):
    z = hills(60, 70)
    relief.write(tmp_path / "a.tif", z)
    relief.write(tmp_path / "b.tif", np.round(z))
    expected = program("compare", tmp_path / "a.tif", tmp_path / "b.tif")
    measured = relief.compare(relief.Raster(z), relief.Raster(np.round(z)))
    assert measured["max_error"] == expected["max_error"] and measured["rms_error"] == expected["rms_error"]
    assert measured["worst"] == (expected["worst"]["row"], expected["worst"]["col"])
