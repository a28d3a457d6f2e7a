"""Programs that use GDAL: rasterio and QGIS, where they are installed and use the same GDAL."""

import importlib.util
import os
import subprocess
import sys
import unittest

import numpy as np

from driver_case import DriverCase, main
from harness import NORTH_UP, hills

# Its bindings fill the process; so it is asked in one of its own. Exit status 3: other GDAL.
QGIS = """
import os, sys
os.environ["QT_QPA_PLATFORM"] = "offscreen"
from qgis.core import QgsApplication, QgsPointXY, QgsRasterLayer
application = QgsApplication([], False)
application.initQgis()
layer = QgsRasterLayer(sys.argv[1], "dem")
assert layer.isValid(), layer.error().message()
assert (layer.width(), layer.height()) == (90, 80)
value, found = layer.dataProvider().sample(QgsPointXY(400000 + 30 * 10.5, 5200000 - 30 * 20.5), 1)
assert found and value == float(sys.argv[2]), value
assert len(layer.dataProvider().buildPyramidList()) > 0
del layer
application.exitQgis()
"""


class Clients(DriverCase):
    def setUp(self):
        super().setUp()
        self.original = hills(80, 90).astype("float32")
        self.original[30:40, 50:70] = -1
        dem = self.raster("dem.tif", self.original, nodata=-1, transform=NORTH_UP, epsg=26911)
        self.file, _ = self.encoded(dem)

    @unittest.skipUnless(importlib.util.find_spec("rasterio"), "python3-rasterio is not installed")
    def test_rasterio(self):
        import rasterio
        import rasterio.shutil

        with rasterio.open(self.file) as dataset:
            self.assertEqual((dataset.driver, dataset.count, dataset.shape),
                             ("RELIEF", 1, (80, 90)))
            self.assertEqual(dataset.crs.to_epsg(), 26911)
            self.assertEqual(dataset.overviews(1), [2, 4])
            np.testing.assert_array_equal(dataset.read(1), self.original)
            masked = dataset.read(1, masked=True)
            np.testing.assert_array_equal(masked.mask, self.original == -1)
            self.assertEqual(dataset.read(1, out_shape=(160, 180)).shape, (160, 180))
            self.assertEqual(dataset.tags(ns="RELIEF")["SCHEME"], "fvs")
        with rasterio.open(self.file, BAND="slope") as dataset:
            self.assertEqual(dataset.dtypes, ("float32",))
        with rasterio.open(self.file, OVERVIEW_LEVEL=0) as dataset:
            self.assertEqual(dataset.shape, (40, 45))
        with self.assertRaisesRegex(rasterio.errors.RasterioIOError, "no level 60"):
            rasterio.open(self.file, LEVEL=60)
        target = self.path("copy.relief")
        with rasterio.open(self.file) as dataset:
            rasterio.shutil.copy(dataset, target, driver="RELIEF", MAX_Z_ERROR=1)
        with rasterio.open(target) as dataset:
            self.assertLessEqual(np.abs(dataset.read(1) - self.original).max(), 1)

    @unittest.skipUnless(importlib.util.find_spec("qgis"), "python3-qgis is not installed")
    def test_qgis(self):
        # It asks GDAL for statistics to choose colours, which keeps them beside files of any format.
        self.side_files = [os.path.basename(self.file) + ".aux.xml"]
        done = subprocess.run([sys.executable, "-c", QGIS, self.file, repr(float(self.original[20, 10]))],
                              capture_output=True, text=True, timeout=120, check=False,
                              env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    main()
