"""CreateCopy: the same files as the program's, goals, what is kept beside, cancelling, refusals."""

import os

import numpy as np
from osgeo import gdal

from driver_case import DriverCase, band, main, values
from harness import NORTH_UP, contents_of, hills


class Writing(DriverCase):
    def setUp(self):
        super().setUp()
        self.driver = gdal.GetDriverByName("RELIEF")
        self.original = hills(120, 150).astype("float32")
        self.original[10:20, 30:40] = -99
        self.dem = self.raster("dem.tif", self.original, nodata=-99, transform=NORTH_UP,
                               epsg=26911, unit="m", names=["height"], metadata={"A": "b"})

    def copy(self, *options, name="copy.relief", **more):
        target = self.path(name)
        copied = self.driver.CreateCopy(target, gdal.Open(self.dem), options=list(options), **more)
        self.assertIsNotNone(copied)
        return target

    def test_bytes_are_those_of_the_program(self):
        for options, arguments in [((), ()),
                                   (("LOSSLESS=YES",), ("--lossless",)),
                                   (("MAX_Z_ERROR=0.5",), ("--max-error", 0.5)),
                                   (("MAX_Z_ERROR=0.5", "PROFILE=FAST"),
                                    ("--max-error", 0.5, "--profile", "fast")),
                                   (("RMSE=1",), ("--rms-error", 1)),
                                   (("BYTES=3000",), ("--bytes", 3000)),
                                   (("RMSE=2", "SCHEME=BOX"), ("--rms-error", 2, "--scheme", "box"))]:
            with self.subTest(options=options):
                expected, _ = self.encoded(self.dem, *arguments)
                self.assertEqual(contents_of(self.copy(*options)), contents_of(expected))

    def test_round_trip_through_tools(self):
        file, back = self.path("a.relief"), self.path("b.tif")
        self.tool("gdal_translate", "-of", "RELIEF", self.dem, file)
        self.tool("gdal_translate", file, back)
        report = self.tool("/usr/bin/python3", "-m", "osgeo_utils.gdalcompare", file, file)
        self.assertIn("Differences Found: 0", report)
        np.testing.assert_array_equal(values(back), self.original)
        for get in ("GetGeoTransform", "GetProjection"):
            self.assertEqual(getattr(gdal.Open(back), get)(), getattr(gdal.Open(self.dem), get)())
        self.assertEqual(gdal.Open(back).GetMetadataItem("A"), "b")
        seen = band(back)
        self.assertEqual((seen.GetNoDataValue(), seen.GetUnitType(), seen.GetDescription()),
                         (-99, "m", "height"))

    def test_bound(self):
        seen = values(self.copy("MAX_Z_ERROR=2"))
        valid = self.original != -99
        np.testing.assert_array_equal(seen == -99, ~valid)
        self.assertLessEqual(np.abs(seen - self.original)[valid].max(), 2)

    def test_zero_is_lossless(self):
        self.assertEqual(contents_of(self.copy("MAX_Z_ERROR=0")),
                         contents_of(self.copy(name="other.relief")))

    def test_in_memory(self):
        target = "/vsimem/copy.relief"
        self.driver.CreateCopy(target, gdal.Open(self.dem))
        np.testing.assert_array_equal(values(target), self.original)
        self.driver.Delete(target)
        self.assertIsNone(gdal.VSIStatL(target))

    def test_of_a_derived_raster(self):
        slopes = gdal.OpenEx(self.copy(), open_options=["BAND=slope"])
        expected = slopes.ReadAsArray()
        target = self.path("slopes.relief")
        self.driver.CreateCopy(target, slopes)
        np.testing.assert_array_equal(values(target), expected)

    def test_what_the_file_can_not_hold_is_kept_beside(self):
        self.side_files = ["copy.relief.aux.xml"]
        dataset = gdal.GetDriverByName("MEM").CreateCopy("", gdal.Open(self.dem))
        dataset.GetRasterBand(1).SetCategoryNames(["a", "b"])
        target = self.path("copy.relief")
        self.driver.CreateCopy(target, dataset)
        self.assertEqual(band(target).GetCategoryNames(), ["a", "b"])
        with open(target + ".aux.xml", encoding="utf-8") as file:
            beside = file.read()
        for known in ("GeoTransform", "SRS", "NoDataValue", "UnitType", "Metadata"):
            self.assertNotIn(f"<{known}", beside)

    def test_progress_and_cancel(self):
        seen = []
        self.copy(callback=lambda done, message, data: seen.append(done) or 1)
        self.assertEqual(seen, sorted(seen))
        self.assertEqual(seen[-1], 1)
        before = self.listing()
        for stop_at in (0, 0.5):
            with self.refuses("cancelled"):
                self.driver.CreateCopy(self.path("not.relief"), gdal.Open(self.dem),
                                       callback=lambda done, *_: 0 if done >= stop_at else 1)
            self.assertEqual(self.listing(), before)

    def test_refusals(self):
        before = self.listing()
        for options, says in [
                (["MAX_Z_ERROR=1", "RMSE=1"], "give one of MAX_Z_ERROR, RMSE, BYTES"),
                (["LOSSLESS=NO"], "LOSSLESS=NO needs"),
                (["MAX_Z_ERROR=-1"], "not.relief"),
                (["MAX_Z_ERROR=much"], "MAX_Z_ERROR takes a number, not 'much'"),
                (["BYTES=3"], "not.relief"),
                (["PROFILE=SLOW"], "PROFILE is DENSE or FAST"),
                (["SCHEME=WAVES"], "waves")]:
            with self.subTest(options=options), self.refuses(says):
                self.driver.CreateCopy(self.path("not.relief"), gdal.Open(self.dem),
                                       options=options)
        memory = gdal.GetDriverByName("MEM")
        for dataset, says in [(memory.Create("", 5, 5, 5), "5 bands, at most 4"),
                              (memory.Create("", 5, 5, 1, gdal.GDT_CFloat32), "CFloat32"),
                              (memory.Create("", 5, 5, 0), "no raster band")]:
            with self.subTest(says=says), self.refuses(says):
                self.driver.CreateCopy(self.path("not.relief"), dataset)
        with self.refuses("there is no directory"):
            self.driver.CreateCopy(self.path("nowhere/not.relief"), gdal.Open(self.dem))
        self.assertEqual(self.listing(), before)

    def test_damaged_source(self):
        cut = self.path("cut.tif")
        with open(cut, "wb") as file:
            file.write(contents_of(self.dem)[:30000])
        with self.refuses("can not read the samples"):
            self.driver.CreateCopy(self.path("not.relief"), gdal.Open(cut))
        self.assertFalse(os.path.exists(self.path("not.relief")))


if __name__ == "__main__":
    main()
