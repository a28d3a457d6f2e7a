"""Real rasters of many sources, where a folder of them is at hand: the middle of each."""

import glob
import os

import numpy as np
from osgeo import gdal

from harness import DATA, Case, main, read_raster, samples


class Terrain(Case):
    def rasters(self):
        paths = sorted(glob.glob(os.path.join(DATA, "terrain", "*.tif")))
        if not paths:
            self.skipTest(f"there are no rasters in {DATA}/terrain; set RELIEF_DATA to try others")
        return paths

    def middle(self, path):
        """A cut of at most 180 x 150 samples around the middle, with all that surrounds it."""
        source = gdal.Open(path)
        cols, rows = min(180, source.RasterXSize), min(150, source.RasterYSize)
        target = self.path(os.path.basename(path))
        gdal.Translate(target, source, srcWin=[(source.RasterXSize - cols) // 2,
                                               (source.RasterYSize - rows) // 2, cols, rows])
        return target

    def test_bounds_hold_on_every_raster(self):
        for path in self.rasters():
            with self.subTest(raster=os.path.basename(path)):
                dem = self.middle(path)
                values = samples(dem)
                spread = np.nanmax(values) - np.nanmin(values)
                bound = max(0.01 * spread, 1e-6)
                file, _ = self.encoded(dem, "--max-error", bound)
                surface, _ = self.decoded(file)
                self.assertTrue(np.array_equal(np.isnan(surface), np.isnan(values)))
                self.assertLessEqual(np.nanmax(np.abs(surface - values)), bound)
                before, after = read_raster(dem), read_raster(self.path("out.tif"))
                for name in ("transform", "unit", "nodata", "names", "type"):
                    self.assertEqual(getattr(after, name), getattr(before, name), name)
                self.assertEqual(bool(after.wkt), bool(before.wkt))

    def test_rms_goals_are_met_and_used_on_every_raster(self):
        for path in self.rasters():
            with self.subTest(raster=os.path.basename(path)):
                dem = self.middle(path)
                values = samples(dem)
                # Integers can not be less than about 0.3 off on average without being exact.
                goal = max(0.02 * np.nanstd(values),
                           0.6 if read_raster(dem).type == "Int16" else 0)
                file, report = self.encoded(dem, "--rms-error", goal)
                surface, _ = self.decoded(file)
                rms = np.sqrt(np.nanmean(np.square(surface - values)))
                self.assertLessEqual(rms, goal * (1 + 1e-12))
                self.assertGreaterEqual(rms, 0.9 * goal)
                self.assertAlmostEqual(rms, report["rms_error"], delta=1e-9 * goal)

    def test_every_raster_survives_exactly(self):
        for path in self.rasters():
            with self.subTest(raster=os.path.basename(path)):
                dem = self.middle(path)
                file, _ = self.encoded(dem)
                surface, _ = self.decoded(file)
                self.assertTrue(np.array_equal(surface, samples(dem), equal_nan=True))


if __name__ == "__main__":
    main()
