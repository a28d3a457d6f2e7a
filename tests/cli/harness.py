"""What the tests of the command line program share: running it, rasters in and out through GDAL.

The environment names the program (RELIEF), and optionally a folder of real data (RELIEF_DATA).
"""

import collections
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from osgeo import gdal, osr

gdal.UseExceptions()

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RELIEF = os.environ.get("RELIEF", os.path.join(ROOT, "build/release/relief"))
DATA = os.environ.get("RELIEF_DATA", os.path.join(ROOT, "../shared/data"))

GDAL_TYPES = {
    "uint8": gdal.GDT_Byte,
    "uint16": gdal.GDT_UInt16,
    "int16": gdal.GDT_Int16,
    "uint32": gdal.GDT_UInt32,
    "int32": gdal.GDT_Int32,
    "float32": gdal.GDT_Float32,
    "float64": gdal.GDT_Float64,
}

NORTH_UP = (400000.0, 30.0, 0.0, 5200000.0, 0.0, -30.0)
ROTATED = (400000.0, 26.0, 15.0, 5200000.0, 12.0, -21.0)  # neither square nor orthogonal

Read = collections.namedtuple("Read", "planes transform wkt unit nodata names metadata type mask")


def hills(rows, cols, seed=1, rough=4.0):
    """A smooth landscape with noise: heights around 0 .. 400."""
    rng = np.random.default_rng(seed)
    i, j = np.mgrid[0:rows, 0:cols]
    z = 200 + 90 * np.sin(i / 17 + 1) * np.cos(j / 23) + 60 * np.sin((i + 2 * j) / 41)
    return z + rng.normal(0, rough, z.shape)


def write_raster(path, planes, dtype=None, nodata=None, transform=None, epsg=None, unit="",
                 names=None, metadata=None):
    """planes: one array or a list of them. dtype defaults to that of the first."""
    planes = [planes] if isinstance(planes, np.ndarray) else list(planes)
    dtype = dtype or planes[0].dtype.name
    rows, cols = planes[0].shape
    dataset = gdal.GetDriverByName("GTiff").Create(path, cols, rows, len(planes),
                                                   GDAL_TYPES[dtype])
    if transform:
        dataset.SetGeoTransform(transform)
    if epsg:
        crs = osr.SpatialReference()
        crs.ImportFromEPSG(epsg)
        dataset.SetSpatialRef(crs)
    if metadata:
        dataset.SetMetadata(metadata)
    for k, plane in enumerate(planes):
        band = dataset.GetRasterBand(k + 1)
        if unit:
            band.SetUnitType(unit)
        if nodata is not None:
            band.SetNoDataValue(nodata)
        if names:
            band.SetDescription(names[k])
        band.WriteArray(plane.astype(dtype))
    dataset.FlushCache()
    return path


def read_raster(path):
    """All of a raster file as GDAL sees it; mask is True where a sample is valid."""
    dataset = gdal.Open(path)
    bands = [dataset.GetRasterBand(k + 1) for k in range(dataset.RasterCount)]
    first = bands[0]
    return Read(
        planes=[band.ReadAsArray() for band in bands],
        transform=dataset.GetGeoTransform(can_return_null=True),
        wkt=dataset.GetProjection(),
        unit=first.GetUnitType(),
        nodata=first.GetNoDataValue(),
        names=[band.GetDescription() for band in bands],
        metadata=dataset.GetMetadata(),
        type=gdal.GetDataTypeName(first.DataType),
        mask=first.GetMaskBand().ReadAsArray() != 0,
    )


def samples(path):
    """The first band as float64, NaN in holes."""
    raster = read_raster(path)
    values = raster.planes[0].astype(np.float64)
    values[~raster.mask] = np.nan
    return values


def contents_of(path):
    with open(path, "rb") as file:
        return file.read()


def energy(values):
    return float(np.sum(np.square(values)))


class Case(unittest.TestCase):
    """A directory for each test, and assertions about runs of the program."""

    maxDiff = None

    def setUp(self):
        self.directory = tempfile.mkdtemp(prefix="relief-cli-")
        self.addCleanup(shutil.rmtree, self.directory, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.directory, name)

    def raster(self, name, planes, **about):
        return write_raster(self.path(name), planes, **about)

    def listing(self):
        return sorted(os.path.join(where, name)
                      for where, folders, files in os.walk(self.directory)
                      for name in folders + files)

    def run_raw(self, *arguments, file_limit=None, stdout=subprocess.PIPE):
        """The finished process. file_limit: the most bytes that a file may have: a full disk."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit, file_limit))

        return subprocess.run([RELIEF, *map(str, arguments)], stdout=stdout,
                              stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True,
                              preexec_fn=limit if file_limit is not None else None,
                              timeout=120, check=False)

    def text(self, *arguments):
        """Standard output of a run that must succeed silently."""
        done = self.run_raw(*arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""), arguments)
        return done.stdout

    def json(self, *arguments):
        """The one JSON object of a run that must succeed."""
        output = self.text(*arguments, "--json")
        self.assertEqual(output.count("\n"), 1, output)
        result = json.loads(output, parse_constant=self.fail)
        self.assertIsInstance(result, dict)
        return result

    def refuse(self, code, *arguments, says=(), file_limit=None):
        """A run that must fail: exit status, nothing printed, one line that says what and where,
        and no file more or less than before."""
        before = self.listing()
        done = self.run_raw(*arguments, file_limit=file_limit)
        about = f"{arguments}: {done.stderr!r}"
        self.assertEqual(done.returncode, code, about)
        self.assertEqual(done.stdout, "", about)
        self.assertRegex(done.stderr, r"\Arelief [a-z]+: [^\n]{10,}\n\Z", about)
        self.assertTrue(done.stderr.startswith(f"relief {arguments[0]}: "), about)
        for part in [says] if isinstance(says, str) else says:
            self.assertIn(part, done.stderr, about)
        self.assertEqual(self.listing(), before, about)
        return done.stderr

    def encoded(self, source, *options, name="out.relief"):
        """Encodes and returns the path of the file and the report."""
        target = self.path(name)
        return target, self.json("encode", source, target, *options)

    def decoded(self, source, *options, name="out.tif"):
        """Decodes and returns the first band as float64 (NaN: hole) and the report."""
        target = self.path(name)
        report = self.json("decode", source, target, *options)
        return samples(target), report


def finite(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def main():
    """Runs the tests of the calling file. Exit status 77: all were skipped."""
    if not os.access(RELIEF, os.X_OK):
        sys.exit(f"there is no program {RELIEF}: build it, or set RELIEF")
    result = unittest.main(exit=False).result
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(77 if result.testsRun == len(result.skipped) else 0)
