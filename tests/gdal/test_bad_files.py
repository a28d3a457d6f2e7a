"""Bad files: always relief's own error through GDAL, never a crash, never wrong samples."""

import random

import numpy as np
from osgeo import gdal

from driver_case import DriverCase, main, values
from harness import contents_of, hills


class BadFiles(DriverCase):
    @classmethod
    def setUpClass(cls):
        cls.original = hills(150, 140).astype("float32")
        cls.original[5:12, 20:31] = -1

    def setUp(self):
        super().setUp()
        self.dem = self.raster("dem.tif", self.original, nodata=-1)
        gdal.FileFromMemBuffer("/vsimem/bad.relief", b"")
        self.addCleanup(gdal.Unlink, "/vsimem/bad.relief")

    def opened(self, content):
        """What GDAL reads from these bytes, whole and in parts; its message if it does not."""
        gdal.FileFromMemBuffer("/vsimem/bad.relief", bytes(content))
        try:
            dataset = gdal.Open("/vsimem/bad.relief")
            dataset.ReadAsArray(buf_xsize=50, buf_ysize=60)
            seen = dataset.GetRasterBand(1)
            if seen.GetOverviewCount():
                seen.GetOverview(0).ReadAsArray()
            return dataset.ReadAsArray(), ""
        except RuntimeError as error:
            return None, str(error)

    def check(self, good, content):
        """Says why not, or gives the samples of the whole file."""
        seen, message = self.opened(content)
        if seen is None:
            self.assertGreater(len(message), 20)
            self.assertIn("/vsimem/bad.relief", message)
        else:
            np.testing.assert_array_equal(seen, good)

    def files(self):
        for options in (("--max-error", 0.5), ("--max-error", 0.5, "--profile", "fast"),
                        ("--rms-error", 1), ("--rms-error", 1, "--scheme", "box")):
            file, _ = self.encoded(self.dem, *options)
            yield contents_of(file), values(file)

    def test_cut(self):
        for content, good in self.files():
            size = len(content)
            for length in [10, 11, 32, 33, size - 1, *range(40, size, size // 12)]:
                with self.subTest(length=length):
                    seen, message = self.opened(content[:length])
                    self.assertIsNone(seen)
                    self.assertIn("bad.relief", message)
            seen, message = self.opened(content + b"\0")
            self.assertIn("bytes behind the last chunk", message)

    def test_messages_are_those_of_the_program(self):
        file, _ = self.encoded(self.dem)
        content = bytearray(contents_of(file))
        for change in (lambda c: c[:len(c) // 2], lambda c: c[:40], lambda c: c + b"x",
                       lambda c: c[:20] + bytes([c[20] ^ 1]) + c[21:],
                       lambda c: c[:10] + b"\7\0" + c[12:]):
            bad = self.path("bad.relief")
            with open(bad, "wb") as out:
                out.write(change(content))
            said = self.refuse(1, "decode", bad, self.path("new.tif"))
            with self.refuses(said.split(": ", 2)[2].strip()):
                gdal.Open(bad)

    def test_altered(self):
        generator = random.Random(11)
        for content, good in self.files():
            for _ in range(25):
                place = generator.randrange(10, len(content))
                with self.subTest(byte=place):
                    broken = bytearray(content)
                    broken[place] ^= 1 << generator.randrange(8)
                    self.check(good, broken)

    def test_damaged_tiles_are_errors_of_their_windows(self):
        original = hills(600, 1100).astype("float32")
        file, _ = self.encoded(self.raster("large.tif", original), "--profile", "fast")
        content = bytearray(contents_of(file))
        content[-1] ^= 1  # the last chunk of a tile of the finest level
        gdal.FileFromMemBuffer("/vsimem/bad.relief", bytes(content))
        dataset = gdal.Open("/vsimem/bad.relief")
        for read in (lambda: dataset.ReadAsArray(),
                     lambda: dataset.GetRasterBand(1).ReadAsArray(1099, 0, 1, 600),
                     lambda: dataset.ReadAsArray(buf_xsize=2200, buf_ysize=1200)):
            with self.refuses("/vsimem/bad.relief", "are damaged"):
                read()
        whole = []
        for col in (0, 800):
            try:
                whole.append(np.array_equal(dataset.ReadAsArray(col, 0, 200, 200),
                                            original[:200, col:col + 200]))
            except RuntimeError:
                whole.append(None)
        self.assertEqual(sorted(whole, key=str), [None, True])

    def test_other_contents(self):
        points = self.path("points.xyz")
        places = np.random.default_rng(1).uniform(size=(60, 2))
        np.savetxt(points, np.column_stack([places, places.sum(axis=1)]))
        self.text("fit", points, self.path("spline.relief"), "-q")
        with self.refuses("spline.relief: is a spline on triangles, no raster"):
            gdal.Open(self.path("spline.relief"))

        self.text("sample", "torus", self.path("torus.off"), "--size", 8, "-q")
        self.text("subdivide", self.path("torus.off"), self.path("fine.off"), "--scheme",
                  "catmull-clark", "--levels", 1, "-q")
        self.text("encode", self.path("fine.off"), self.path("mesh.relief"), "-q")
        with self.refuses("mesh.relief: is a mesh, no raster", "relief decode"):
            gdal.Open(self.path("mesh.relief"))

        with open(self.path("quads.off"), "w", encoding="ascii") as file:
            file.write("OFF\n6 2 0\n0 0 1\n1 0 2\n2 0 1\n0 1 3\n1 1 2\n2 1 4\n"
                       "4 0 1 4 3\n4 1 2 5 4\n")
        self.text("encode", self.path("quads.off"), self.path("quads.relief"), "--scheme", "fvs",
                  "-q")
        with self.refuses("quads.relief: is a spline on quads, no raster"):
            gdal.Open(self.path("quads.relief"))

    def test_other_files_are_left_to_others(self):
        driver = gdal.GetDriverByName("RELIEF")
        for content in (b"", b"RELIEF", b"RELIEF\x89\n\x1a plain text", b"II*\0"):
            gdal.FileFromMemBuffer("/vsimem/bad.relief", content)
            self.assertIsNone(gdal.IdentifyDriverEx("/vsimem/bad.relief",
                                                    allowed_drivers=["RELIEF"]))
        self.assertEqual(gdal.IdentifyDriver(self.dem).ShortName, "GTiff")
        self.assertIsNotNone(driver)

    def test_missing_files(self):
        with self.refuses("nowhere.relief", "can not read"):
            gdal.Open('RELIEF:"/vsimem/nowhere.relief":slope')
        for name in ("RELIEF:", "RELIEF::", "RELIEF:x", "RELIEF:\"\":slope"):
            with self.refuses(""):
                gdal.Open(name)


if __name__ == "__main__":
    main()
