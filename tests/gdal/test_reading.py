"""What GDAL sees of a .relief file: samples, levels, other resolutions, derived rasters, facts."""

import math
import os

import numpy as np
from osgeo import gdal, osr

from driver_case import DriverCase, band, main, values
from harness import NORTH_UP, ROTATED, hills, read_raster

GOALS = {
    "lossless": (),
    "fast": ("--max-error", 0.5, "--profile", "fast"),
    "dense": ("--max-error", 0.5),
    "cubic": ("--rms-error", 0.5),
    "box": ("--rms-error", 0.5, "--scheme", "box"),
    "barycentric": ("--keep", 60, "--scheme", "barycentric"),
}


class Samples(DriverCase):
    def test_samples_are_those_that_the_program_decodes(self):
        # Wider than a block, with a ragged edge and more than one tile.
        dem = self.raster("dem.tif", hills(530, 801).astype("float32"), transform=NORTH_UP)
        for name, options in GOALS.items():
            with self.subTest(goal=name):
                file, _ = self.encoded(dem, *options)
                expected, _ = self.decoded(file)
                seen = band(file)
                np.testing.assert_array_equal(seen.ReadAsArray(), expected)
                np.testing.assert_array_equal(seen.ReadAsArray(500, 100, 290, 420),
                                              expected[100:520, 500:790])
                rows = [seen.ReadAsArray(0, row, 801, 1)[0] for row in range(505, 530)]
                np.testing.assert_array_equal(rows, expected[505:])
                np.testing.assert_array_equal(seen.ReadAsArray(800, 0, 1, 530), expected[:, 800:])
                blocks = np.frombuffer(seen.ReadBlock(1, 1), "float32").reshape(512, 512)
                np.testing.assert_array_equal(blocks[:18, :289], expected[512:, 512:])

    def test_every_type(self):
        for name in ("uint8", "uint16", "int16", "uint32", "int32", "float32", "float64"):
            with self.subTest(type=name):
                original = (hills(70, 50) / 2).astype(name)
                file, _ = self.encoded(self.raster("dem.tif", original))
                seen = values(file)
                self.assertEqual(seen.dtype, original.dtype)
                np.testing.assert_array_equal(seen, original)

    def test_bands(self):
        planes = [hills(60, 700, seed=k).astype("int16") for k in range(3)]
        file, _ = self.encoded(self.raster("dem.tif", planes, names=["x", "y", "z"]))
        dataset = gdal.Open(file)
        self.assertEqual(dataset.RasterCount, 3)
        np.testing.assert_array_equal(dataset.ReadAsArray(), planes)
        np.testing.assert_array_equal(dataset.ReadAsArray(5, 5, 100, 1),
                                      [plane[5:6, 5:105] for plane in planes])
        for k, name in enumerate("xyz"):
            self.assertEqual(dataset.GetRasterBand(k + 1).GetDescription(), name)
            np.testing.assert_array_equal(dataset.GetRasterBand(k + 1).ReadAsArray(), planes[k])

    def test_interleaved_buffer(self):
        planes = [hills(20, 30, seed=k).astype("float32") for k in range(2)]
        file, _ = self.encoded(self.raster("dem.tif", planes))
        out = np.zeros((20, 30, 2), "float64")
        raw = gdal.Open(file).ReadRaster(buf_type=gdal.GDT_Float64, buf_pixel_space=16,
                                         buf_line_space=16 * 30, buf_band_space=8)
        out = np.frombuffer(raw, "float64").reshape(20, 30, 2)
        for k in range(2):
            np.testing.assert_array_equal(out[:, :, k], planes[k])

    def test_large_reads_go_piece_by_piece(self):
        i, j = np.mgrid[0:4200, 0:4100]
        original = ((i // 50) * (j // 40) % 200).astype("uint8")
        file, _ = self.encoded(self.raster("dem.tif", original), "--profile", "fast")
        seen = []
        whole = band(file).ReadAsArray(callback=lambda done, *_: seen.append(done) or 1)
        np.testing.assert_array_equal(whole, original)
        self.assertGreater(len(seen), 1)
        self.assertEqual((seen, seen[-1]), (sorted(seen), 1))
        np.testing.assert_array_equal(band(file).ReadAsArray(1, 3, 4099, 4190),
                                      original[3:4193, 1:])
        with self.refuses("reading was cancelled"):
            band(file).ReadAsArray(callback=lambda *_: 0)

    def test_edited(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(90, 80).astype("float32")))
        edited = self.path("edited.relief")
        self.json("edit", file, edited, "--level", 2, "--move", "20:50")
        expected, _ = self.decoded(edited)
        np.testing.assert_array_equal(values(edited), expected)
        self.assertNotIn("RELIEF_MAX_ERROR", gdal.Open(edited).GetMetadata())
        self.assertEqual(gdal.Open(edited).GetMetadataItem("EDITS", "RELIEF"), "1")
        self.assertEqual(
            gdal.Open(edited).GetMetadataItem("COMPRESSION_REVERSIBILITY", "IMAGE_STRUCTURE"),
            "LOSSY")


class Holes(DriverCase):
    def original(self, dtype):
        original = hills(80, 90).astype(dtype)
        holes = np.zeros(original.shape, bool)
        holes[10:30, 20:60] = True
        return original, holes

    def test_nodata(self):
        original, holes = self.original("int16")
        original[holes] = -5
        file, _ = self.encoded(self.raster("dem.tif", original, nodata=-5))
        seen = band(file)
        self.assertEqual(seen.GetNoDataValue(), -5)
        self.assertEqual(seen.GetMaskFlags(), gdal.GMF_NODATA)
        np.testing.assert_array_equal(seen.ReadAsArray(), original)
        np.testing.assert_array_equal(seen.GetMaskBand().ReadAsArray() == 0, holes)

    def test_floats_without_nodata(self):
        original, holes = self.original("float32")
        original[holes] = np.nan
        file, _ = self.encoded(self.raster("dem.tif", original))
        seen = band(file)
        self.assertTrue(math.isnan(seen.GetNoDataValue()))
        np.testing.assert_array_equal(seen.ReadAsArray(), original)
        np.testing.assert_array_equal(seen.GetMaskBand().ReadAsArray() == 0, holes)

    def test_integers_without_nodata_have_a_mask_band(self):
        original, holes = self.original("uint8")
        dem = self.raster("dem.tif", original)
        dataset = gdal.Open(dem, gdal.GA_Update)
        dataset.CreateMaskBand(gdal.GMF_PER_DATASET)
        dataset.GetRasterBand(1).GetMaskBand().WriteArray((255 * ~holes).astype("uint8"))
        dataset = None
        file, _ = self.encoded(dem)
        seen = band(file)
        self.assertIsNone(seen.GetNoDataValue())
        self.assertEqual(seen.GetMaskFlags(), gdal.GMF_PER_DATASET)
        mask = seen.GetMaskBand()
        np.testing.assert_array_equal(mask.ReadAsArray(), np.where(holes, 0, 255))
        np.testing.assert_array_equal(mask.ReadAsArray(15, 9, 10, 2),
                                      np.where(holes, 0, 255)[9:11, 15:25])
        np.testing.assert_array_equal(seen.ReadAsArray()[~holes], original[~holes])
        coarse = seen.GetOverview(0)
        np.testing.assert_array_equal(coarse.GetMaskBand().ReadAsArray(),
                                      np.where(holes, 0, 255)[::2, ::2])

    def test_slopes_have_the_holes(self):
        original, holes = self.original("float32")
        original[holes] = -1
        file, _ = self.encoded(self.raster("dem.tif", original, nodata=-1))
        np.testing.assert_array_equal(np.isnan(values(file, "BAND=slope")), holes)
        np.testing.assert_array_equal(values(file, "BAND=hillshade") == 0, holes)


class Levels(DriverCase):
    def test_overviews_are_the_levels(self):
        dem = self.raster("dem.tif", hills(301, 417).astype("int16"), transform=NORTH_UP)
        for name, options in GOALS.items():
            with self.subTest(goal=name):
                file, _ = self.encoded(dem, *options)
                seen = band(file)
                sizes = []
                for k in range(seen.GetOverviewCount()):
                    overview = seen.GetOverview(k)
                    expected, _ = self.decoded(file, "--level", k + 1)
                    np.testing.assert_array_equal(overview.ReadAsArray(), expected)
                    sizes.append((overview.XSize, overview.YSize))
                self.assertEqual(sizes, [(209, 151), (105, 76), (53, 38), (27, 19)])

    def test_level_option(self):
        dem = self.raster("dem.tif", hills(301, 417).astype("float32"), transform=ROTATED)
        file, _ = self.encoded(dem, "--max-error", 1)
        for level in (0, 1, 3):
            target = self.path("level.tif")
            self.json("decode", file, target, "--level", level)
            expected = read_raster(target)
            dataset = gdal.OpenEx(file, open_options=[f"LEVEL={level}"])
            np.testing.assert_array_equal(dataset.ReadAsArray(), expected.planes[0])
            np.testing.assert_allclose(dataset.GetGeoTransform(), expected.transform, rtol=1e-14)
            self.assertEqual(dataset.GetMetadataItem("RELIEF_MAX_ERROR"),
                             expected.metadata["RELIEF_MAX_ERROR"])
        with self.refuses("no level 60", "levels 0 (finest) to"):
            gdal.OpenEx(file, open_options=["LEVEL=60"])

    def test_margin(self):
        # Interpolated from a coarser grid: the file's lattice begins before the raster.
        coarse = hills(61, 81, rough=0)
        fine = np.kron(coarse, np.ones((2, 2)))[:-1, :-1]
        fine[1::2] = (fine[:-1:2] + fine[2::2]) / 2
        fine[:, 1::2] = (fine[:, :-1:2] + fine[:, 2::2]) / 2
        shifted = fine[1:, 1:].astype("float32")
        file, _ = self.encoded(self.raster("dem.tif", shifted))
        expected, _ = self.decoded(file)
        seen = band(file)
        np.testing.assert_array_equal(seen.ReadAsArray(), shifted)
        for row in (0, 1, 60, 118):
            np.testing.assert_array_equal(seen.ReadAsArray(3, row, 150, 1),
                                          expected[row:row + 1, 3:153])
        level, _ = self.decoded(file, "--level", 1)
        np.testing.assert_array_equal(seen.GetOverview(0).ReadAsArray(), level)


class Scales(DriverCase):
    def test_the_spline_at_any_scale(self):
        dem = self.raster("dem.tif", hills(120, 160).astype("float32"), transform=NORTH_UP)
        for name, options in GOALS.items():
            file, _ = self.encoded(dem, *options)
            for scale in (1.5, 0.125):
                with self.subTest(goal=name, scale=scale):
                    expected, _ = self.decoded(file, "--scale", scale)
                    rows, cols = expected.shape
                    seen = band(file).ReadAsArray(buf_xsize=cols, buf_ysize=rows)
                    # Places are the same but for rounding.
                    np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-4)

    def test_resolution_option(self):
        dem = self.raster("dem.tif", hills(120, 160).astype("float32"), transform=NORTH_UP)
        file, _ = self.encoded(dem)
        scaled = self.path("scaled.tif")
        self.json("decode", file, scaled, "--scale", 3)
        expected = read_raster(scaled)
        dataset = gdal.OpenEx(file, open_options=["RES=10"])
        np.testing.assert_allclose(dataset.ReadAsArray(), expected.planes[0], rtol=0, atol=1e-4)
        np.testing.assert_allclose(dataset.GetGeoTransform(), expected.transform, rtol=1e-12)
        self.assertEqual(dataset.GetRasterBand(1).GetOverviewCount(), 0)
        dataset = gdal.OpenEx(file, open_options=["RES=60,90"])
        self.assertEqual((dataset.RasterXSize, dataset.RasterYSize), (80, 40))
        self.assertEqual(dataset.GetGeoTransform(), (400000, 60, 0, 5200000, 0, -90))
        for bad in ("0", "-5", "abc", "1,2,3", "1e-9"):
            with self.refuses("RES"):
                gdal.OpenEx(file, open_options=[f"RES={bad}"])
        with self.refuses("exclude each other"):
            gdal.OpenEx(file, open_options=["RES=10", "LEVEL=1"])

    def test_floats_between_integers(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(60, 60).astype("int16")))
        seen = band(file)
        as_float = seen.ReadAsArray(buf_xsize=240, buf_ysize=240, buf_type=gdal.GDT_Float32)
        self.assertGreater(np.count_nonzero(as_float % 1), 50000)
        as_integer = seen.ReadAsArray(buf_xsize=240, buf_ysize=240)
        np.testing.assert_array_equal(as_integer, np.rint(as_float))

    def test_averages_are_left_to_gdal(self):
        original = hills(64, 64).astype("float32")
        file, _ = self.encoded(self.raster("dem.tif", original))
        seen = band(file, "LEVEL=0").ReadAsArray(0, 0, 64, 64, buf_xsize=60, buf_ysize=60,
                                                resample_alg=gdal.GRIORA_Average)
        memory = gdal.GetDriverByName("MEM").Create("", 64, 64, 1, gdal.GDT_Float32)
        memory.GetRasterBand(1).WriteArray(original)
        expected = memory.ReadAsArray(0, 0, 64, 64, buf_xsize=60, buf_ysize=60,
                                      resample_alg=gdal.GRIORA_Average)
        np.testing.assert_array_equal(seen, expected)


class Derived(DriverCase):
    """Of a plane that rises by 3/4 to the east and falls by 1 to the north, and of a level one."""

    def plane(self, transform, east, north, epsg=32617, unit="m"):
        i, j = np.mgrid[0:40, 0:50]
        t = transform
        x = t[1] * (j + 0.5) + t[2] * (i + 0.5)
        y = t[4] * (j + 0.5) + t[5] * (i + 0.5)
        # Decimals, which the closed loop keeps.
        dem = self.raster("plane.tif", np.round(east * x + north * y, 6), transform=transform,
                          epsg=epsg, unit=unit)
        return self.encoded(dem)[0]

    def check(self, file, quantity, expected):
        np.testing.assert_allclose(values(file, f"BAND={quantity}"), np.full((40, 50), expected),
                                   rtol=0, atol=1e-3)

    def test_plane(self):
        for transform in (NORTH_UP, ROTATED):
            file = self.plane(transform, 0.75, -1)
            self.check(file, "dx", 0.75)
            self.check(file, "dy", -1)
            self.check(file, "slope", math.degrees(math.atan(1.25)))
            # Downhill is towards (-3/4, 1).
            self.check(file, "aspect", 360 - math.degrees(math.atan(0.75)))
            light = (0.5 * (0.75 + 1) + math.sqrt(0.5)) / math.hypot(1, 1.25)
            self.check(file, "hillshade", round(1 + 254 * light))

    def test_level_ground(self):
        file = self.plane(NORTH_UP, 0, 0)
        self.check(file, "slope", 0)
        self.check(file, "hillshade", round(1 + 254 * math.sqrt(0.5)))
        self.assertTrue(np.isnan(values(file, "BAND=aspect")).all())

    def test_feet(self):
        file = self.plane(NORTH_UP, 1, 0, unit="ft")
        self.check(file, "slope", math.degrees(math.atan(0.3048)))
        self.check(file, "dx", 1)

    def test_degrees(self):
        step = 1 / 3600
        file = self.plane((10, step, 0, 20 * step, 0, -step), 30 * 3600, 0, epsg=4326)
        # A degree of longitude has so many metres on the equator.
        self.check(file, "slope", math.degrees(math.atan(30 * 3600 / 111319.49079327358)))

    def test_at_a_level_and_as_names(self):
        file = self.plane(NORTH_UP, 0.75, -1)
        np.testing.assert_allclose(values(file, "BAND=slope", "LEVEL=1"),
                                   np.full((20, 25), math.degrees(math.atan(1.25))), atol=1e-3)
        listed = gdal.Open(file).GetMetadata("DERIVED_SUBDATASETS")
        self.assertEqual(listed["DERIVED_SUBDATASET_1_NAME"], f'RELIEF:"{file}":slope')
        for name in (f'RELIEF:"{file}":slope', f"RELIEF:{file}:slope"):
            np.testing.assert_array_equal(values(name), values(file, "BAND=slope"))
        with self.refuses("nothing is called 'height'", "slope, aspect, hillshade"):
            gdal.Open(f"RELIEF:{file}:height")
        seen = band(file, "BAND=slope")
        self.assertEqual((seen.GetUnitType(), seen.GetDescription()), ("degree", "slope"))


class Facts(DriverCase):
    def test_georeference_and_descriptions(self):
        for transform in (NORTH_UP, ROTATED):
            dem = self.raster("dem.tif", hills(50, 40).astype("float32"), transform=transform,
                              epsg=26911, unit="ft", names=["height"],
                              metadata={"SOURCE": "a survey", "AREA_OR_POINT": "Point"})
            file, _ = self.encoded(dem, "--max-error", 0.25)
            dataset = gdal.Open(file)
            self.assertEqual(dataset.GetGeoTransform(), transform)
            crs = osr.SpatialReference()
            crs.ImportFromEPSG(26911)
            self.assertTrue(dataset.GetSpatialRef().IsSame(crs))
            self.assertEqual(dataset.GetMetadata(), {
                "SOURCE": "a survey", "AREA_OR_POINT": "Point", "RELIEF_SCHEME": "fvs order 2",
                "RELIEF_LEVELS": dataset.GetMetadataItem("LEVELS", "RELIEF"),
                "RELIEF_MAX_ERROR": "0.25"})
            self.assertEqual(dataset.GetRasterBand(1).GetUnitType(), "ft")
            self.assertEqual(dataset.GetRasterBand(1).GetDescription(), "height")
            self.assertEqual(dataset.GetFileList(), [file])

    def test_nothing_is_made_up(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(50, 40).astype("float32")))
        dataset = gdal.Open(file)
        self.assertIsNone(dataset.GetGeoTransform(can_return_null=True))
        self.assertIsNone(dataset.GetSpatialRef())
        seen = dataset.GetRasterBand(1)
        self.assertIsNone(seen.GetNoDataValue())
        self.assertEqual(seen.GetMaskFlags(), gdal.GMF_ALL_VALID)
        self.assertEqual((seen.GetUnitType(), seen.GetScale(), seen.GetOffset()), ("", None, None))
        self.assertEqual(dataset.GetMetadata("IMAGE_STRUCTURE"),
                         {"COMPRESSION": "RELIEF", "COMPRESSION_REVERSIBILITY": "LOSSLESS"})

    def test_range(self):
        original = hills(50, 40).astype("int16")
        file, _ = self.encoded(self.raster("dem.tif", original))
        seen = band(file)
        self.assertEqual((seen.GetMinimum(), seen.GetMaximum()), (original.min(), original.max()))
        file, _ = self.encoded(self.raster("dem.tif", original), "--rms-error", 1)
        self.assertIsNone(band(file).GetMinimum())

    def test_bounds_of_levels(self):
        file, report = self.encoded(self.raster("dem.tif", hills(150, 140).astype("float32")),
                                    "--max-error", 0.5)
        facts = gdal.Open(file).GetMetadata("RELIEF")
        self.assertEqual((facts["SCHEME"], facts["PROFILE"], facts["GOAL"], facts["GOAL_VALUE"]),
                         ("fvs", "DENSE", "MAX_Z_ERROR", "0.5"))
        self.assertEqual(int(facts["BYTES"]), report["bytes"])
        self.assertEqual(facts["LEVEL_0_BOUND"], "0.5")
        self.assertEqual(facts["LEVEL_2_SIZE"], "35,38")
        self.assertLess(int(facts["LEVEL_3_BYTES"]), int(facts["LEVEL_1_BYTES"]))
        self.assertLess(float(facts["LEVEL_1_SURFACE_BOUND"]),
                        float(facts["LEVEL_4_SURFACE_BOUND"]))

    def test_gdalinfo_leaves_nothing_behind(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(90, 80).astype("float32"), nodata=-1,
                                           transform=NORTH_UP, epsg=32617))
        before = self.listing()
        text = self.tool("gdalinfo", "-mdd", "all", "-checksum", file)
        self.assertIn("Driver: RELIEF/", text)
        self.assertIn("Overviews: 40x45, 20x23", text)
        for option in ("LEVEL=1", "BAND=aspect", "RES=17"):
            self.tool("gdalinfo", "-oo", option, "-checksum", file)
        self.assertEqual(self.listing(), before)

    def test_statistics_stay_with_what_they_are_of(self):
        self.side_files = ["out.relief.aux.xml"]
        file, _ = self.encoded(self.raster("dem.tif", hills(90, 80).astype("float32")))
        slopes = gdal.OpenEx(file, open_options=["BAND=slope"])
        mean = slopes.GetRasterBand(1).ComputeStatistics(False)[2]
        slopes = None
        kept = band(file, "BAND=slope").GetMetadata()
        self.assertAlmostEqual(float(kept["STATISTICS_MEAN"]), mean, places=6)
        self.assertEqual(band(file).GetMetadata(), {})

    def test_update_is_refused(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(20, 20).astype("float32")))
        with self.refuses("not written in place", "gdal_translate"):
            gdal.Open(file, gdal.GA_Update)

    def test_external_overviews_win(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(90, 80).astype("float32")))
        dataset = gdal.Open(file)
        dataset.BuildOverviews("AVERAGE", [4])
        dataset = None
        self.assertTrue(os.path.exists(file + ".ovr"))
        self.assertEqual(band(file).GetOverviewCount(), 1)


if __name__ == "__main__":
    main()
