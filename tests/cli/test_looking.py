"""info, compare, render and sample."""

import os
import struct

import numpy as np
from osgeo import gdal

from harness import NORTH_UP, ROTATED, Case, contents_of, finite, hills, main, read_raster, samples

COMPARE_KEYS = ("samples max_error rms_error mean_square psnr_db energy_percent diagonal worst "
                "mask_differs").split()


class Info(Case):
    def test_relief_files(self):
        dem = self.raster("dem.tif", hills(60, 70, rough=0.2).astype("float32"), transform=ROTATED,
                          epsg=32633, unit="m", nodata=-9)
        file, report = self.encoded(dem, "--max-error", 0.5, "--scheme", "barycentric",
                                    "--levels", 2)
        info = self.json("info", file)
        for key in ("format version scheme order levels bands bytes bound crs extent "
                    "checksums_ok").split():
            self.assertIn(key, info)
        self.assertEqual((info["format"], info["version"]), ("relief", 1))
        self.assertEqual((info["scheme"], info["order"], info["levels"]), ("barycentric", 2, 2))
        self.assertEqual((info["rows"], info["cols"], info["components"]), (60, 70, 1))
        self.assertEqual((info["type"], info["nodata"], info["unit"]), ("float32", -9, "m"))
        self.assertEqual(info["bytes"], os.path.getsize(file))
        self.assertEqual(info["bound"], 0.5)
        self.assertIs(info["checksums_ok"], True)
        self.assertIn("32633", info["crs"])
        corners = [(ROTATED[0] + ROTATED[1] * c + ROTATED[2] * r,
                    ROTATED[3] + ROTATED[4] * c + ROTATED[5] * r)
                   for r in (0, 60) for c in (0, 70)]
        xs, ys = zip(*corners)
        self.assertEqual(info["extent"], [min(xs), min(ys), max(xs), max(ys)])
        self.assertEqual(len(info["bands"]), 1 + 7 * 2)
        self.assertTrue(all(band["step"] > 0 and band["norm"] > 0 for band in info["bands"]))
        self.assertEqual([level["level"] for level in info["level_list"]], [0, 1, 2])
        bounds = [level["bound"] for level in info["level_list"]]
        self.assertEqual(bounds[0], report["bound"])
        self.assertEqual(bounds, sorted(bounds))
        kinds = [chunk["kind"] for chunk in info["chunks"]]
        self.assertEqual((kinds[0], kinds[-1]), ("scaling", "correction"))
        self.assertIn("within 0.5 of the original", self.text("info", file))

    def test_rasters(self):
        values = hills(20, 30).astype("float32")
        values[0, :5] = -9
        dem = self.raster("dem.tif", [values, values * 2], transform=NORTH_UP, nodata=-9,
                          names=["low", "high"], unit="ft")
        info = self.json("info", dem)
        valid = values[values != -9]
        self.assertEqual((info["format"], info["type"], info["valid"]), ("raster", "float32", 595))
        self.assertEqual(info["bands"][1], {"name": "high", "min": float(2 * valid.min()),
                                            "max": float(2 * valid.max())})
        self.assertEqual(info["extent"], [400000, 5200000 - 600, 400900, 5200000])
        self.assertIsNone(info["checksums_ok"])
        self.assertEqual(info["bytes"], os.path.getsize(dem))
        self.assertIn("595 of 600 samples valid", self.text("info", dem))

    def test_rasters_without_valid_samples(self):
        info = self.json("info", self.raster("nan.tif", np.full((3, 4), np.nan)))
        self.assertEqual((info["valid"], info["bands"][0]["min"]), (0, None))


class Compare(Case):
    def test_numbers(self):
        a = hills(40, 50)
        b = a + np.random.default_rng(1).normal(0, 3, a.shape)
        b[17, 23] = a[17, 23] - 40
        result = self.json("compare", self.raster("a.tif", a, transform=NORTH_UP),
                           self.raster("b.tif", b))
        self.assertEqual(list(result), COMPARE_KEYS)
        difference = b - a
        self.assertEqual(result["samples"], 2000)
        self.assertEqual(result["max_error"], np.abs(difference).max())
        self.assertEqual(result["worst"], {"row": 17, "col": 23})
        square = np.mean(np.square(difference))
        self.assertAlmostEqual(result["mean_square"], square, delta=1e-12 * square)
        self.assertAlmostEqual(result["rms_error"], np.sqrt(square), delta=1e-12)
        spread = a.max() - a.min()
        self.assertAlmostEqual(result["psnr_db"], 20 * np.log10(spread / np.sqrt(square)),
                               delta=1e-9)
        self.assertAlmostEqual(result["diagonal"],
                               np.sqrt((50 * 30)**2 + (40 * 30)**2 + spread**2), delta=1e-9)
        self.assertTrue(finite(result["energy_percent"]))

    def test_identical_rasters(self):
        a = self.raster("a.tif", hills(40, 50))
        result = self.json("compare", a, a)
        self.assertIsNone(result["psnr_db"])
        self.assertEqual([result[key] for key in COMPARE_KEYS[1:4] + ["energy_percent"]], [0] * 4)
        self.assertIn("PSNR infinite", self.text("compare", a, a))

    def test_masks(self):
        a, b = hills(40, 50), hills(40, 50) + 1
        a[:10] = np.nan
        b[:, :10] = np.nan
        result = self.json("compare", self.raster("a.tif", a), self.raster("b.tif", b))
        self.assertEqual(result["samples"], 30 * 40)
        self.assertEqual(result["mask_differs"], 10 * 40 + 30 * 10)
        self.assertAlmostEqual(result["max_error"], 1, delta=1e-12)

    def test_several_bands_count_as_one_distance(self):
        a = [hills(20, 20, seed) for seed in (1, 2)]
        b = [a[0] + 3, a[1] + 4]
        result = self.json("compare", self.raster("a.tif", a), self.raster("b.tif", b))
        self.assertAlmostEqual(result["rms_error"], 5, delta=1e-12)
        self.assertAlmostEqual(result["max_error"], 4, delta=1e-12)

    def test_energy_base(self):
        a = self.raster("a.tif", hills(60, 60))
        file, report = self.encoded(a, "--keep", 5, "--scheme", "barycentric", "--levels", 2)
        percents = {self.json("compare", a, b, *options)["energy_percent"] for b, options in (
            (file, ()), (file, ("--levels", 2)),
            (file, ("--scheme", "barycentric", "--order", 2)))}
        self.assertEqual(len(percents), 1)
        self.assertAlmostEqual(percents.pop(), report["energy_percent"], delta=1e-9)
        other = self.json("compare", a, file, "--levels", 1)["energy_percent"]
        self.assertGreater(other, report["energy_percent"])

    def test_metadata_of_strangers_do_no_harm(self):
        a = self.raster("a.tif", hills(30, 30))
        for scheme, levels in (("sphere order 99", "1000000"), ("box order 77", "-5"),
                               ("box order ", "many"), ("nonsense", "")):
            b = self.raster("b.tif", hills(30, 30) + 1,
                            metadata={"RELIEF_SCHEME": scheme, "RELIEF_LEVELS": levels})
            result = self.json("compare", a, b)
            self.assertEqual(result["energy_percent"],
                             self.json("compare", a, self.raster("c.tif", hills(30, 30) + 1))
                             ["energy_percent"])


class Render(Case):
    def picture(self, path):
        """An RGB(A) PNG as an array; its size stands in its header too."""
        header = contents_of(path)[:26]
        self.assertEqual(header[:8], b"\x89PNG\r\n\x1a\n")
        image = gdal.Open(path).ReadAsArray()
        self.assertEqual(struct.unpack(">II", header[16:24]), (image.shape[2], image.shape[1]))
        return image

    def test_styles(self):
        values = hills(90, 120).astype("float32")
        values[20:30, 30:40] = -1
        dem = self.raster("dem.tif", values, transform=NORTH_UP, nodata=-1)
        file, _ = self.encoded(dem, "--rms-error", 3)
        seen = set()
        for style in ("hillshade", "colour", "wire", "error"):
            for source in (dem, file):
                more = ("--reference", dem) if style == "error" else ()
                report = self.json("render", source, self.path("a.png"), "--style", style,
                                   "--width", 240, *more)
                image = self.picture(self.path("a.png"))
                self.assertEqual(image.shape[1:], (report["height"], report["width"]))
                self.assertEqual(report["width"], 240)
                if style in ("hillshade", "colour"):
                    self.assertEqual(report["height"], 180)
                # A flat error map of a raster with itself is the only plain picture.
                if not (style == "error" and source == dem):
                    self.assertGreater(image[:3].std(), 3, (style, source))
                seen.add(contents_of(self.path("a.png")))
        self.assertEqual(len(seen), 8)

    def test_holes_and_slopes_show(self):
        i, j = np.mgrid[0:100, 0:100]
        values = np.where(j < 50, j, 100 - j).astype("float32") * 30
        values[40:60, 10:30] = -1
        dem = self.raster("ridge.tif", values, transform=NORTH_UP, nodata=-1)
        self.json("render", dem, self.path("a.png"), "--width", 100)
        image = self.picture(self.path("a.png")).astype(float)
        grey = image[:3].mean(axis=0)
        # Lit from the north-west: the western slope is brighter than the eastern one.
        self.assertGreater(grey[10:30, 10:40].mean(), grey[10:30, 60:90].mean() + 20)
        if len(image) == 4:
            self.assertEqual(image[3, 45:55, 15:25].max(), 0)
        else:
            self.assertNotEqual(grey[50, 20], grey[20, 20])

    def test_options(self):
        dem = self.raster("dem.tif", hills(90, 120).astype("float32"), transform=NORTH_UP)
        seen = {None}
        for more in ((), ("--azimuth", 90), ("--altitude", 20), ("--exaggeration", 9),
                     ("--multidirectional",)):
            self.json("render", dem, self.path("a.png"), "--width", 120, *more)
            seen.add(contents_of(self.path("a.png")))
        self.assertEqual(len(seen), 6)

    def test_drape(self):
        dem = self.raster("dem.tif", hills(60, 60).astype("float32"), transform=NORTH_UP)
        red = gdal.GetDriverByName("MEM").Create("", 20, 20, 3)
        red.GetRasterBand(1).Fill(220)
        gdal.GetDriverByName("PNG").CreateCopy(self.path("red.png"), red)
        self.json("render", dem, self.path("a.png"), "--width", 60, "--drape",
                  self.path("red.png"))
        image = self.picture(self.path("a.png")).astype(int)
        self.assertGreater((image[0] - image[1]).mean(), 60)

    def test_levels_and_nets(self):
        dem = self.raster("dem.tif", hills(90, 120).astype("float32"), transform=NORTH_UP)
        for scheme in ("box", "barycentric"):
            file, _ = self.encoded(dem, "--rms-error", 1, "--levels", 3, "--scheme", scheme)
            for level in range(4):
                for style in ("wire", "hillshade"):
                    report = self.json("render", file, self.path("a.png"), "--style", style,
                                       "--level", level, "--width", 200)
                    image = self.picture(self.path("a.png"))
                    self.assertEqual((report["width"], image.shape[2]), (200, 200))
                    self.assertGreater(image[:3].std(), 3)

    def test_parametric_surfaces(self):
        torus = self.path("torus.tif")
        self.json("sample", "torus", torus, "--size", 33)
        file, _ = self.encoded(torus, "--rms-error", 0.001)
        for source in (torus, file):
            self.json("render", source, self.path("a.png"), "--style", "wire", "--width", 150)
            self.assertGreater(self.picture(self.path("a.png"))[:3].std(), 3)

    def test_tiny_and_thin_rasters(self):
        for rows, cols in ((1, 1), (1, 9), (9, 1), (2, 9), (9, 2), (2, 2)):
            dem = self.raster("dem.tif", hills(rows, cols), transform=NORTH_UP)
            file, _ = self.encoded(dem)
            for style in ("hillshade", "colour", "wire", "error"):
                more = ("--reference", dem) if style == "error" else ()
                with self.subTest(size=(rows, cols), style=style):
                    self.json("render", file, self.path("a.png"), "--style", style, "--width", 64,
                              *more)
                    # The scale of the error map needs its room.
                    width = 180 if style == "error" else 64
                    self.assertEqual(self.picture(self.path("a.png")).shape[2], width)

    def test_without_valid_samples(self):
        nan = self.raster("nan.tif", np.full((20, 20), np.nan))
        for style in ("hillshade", "colour", "wire"):
            self.refuse(1, "render", nan, self.path("a.png"), "--style", style,
                        says=("nan.tif", "no sample is valid"))


class Sample(Case):
    def test_names(self):
        for name, shape, bands in (("franke", (21, 21), 1), ("bump", (21, 21), 1),
                                   ("ridged", (21, 21), 1), ("terrain", (21, 21), 1),
                                   ("torus", (21, 42), 3), ("face", (21, 21), 1)):
            report = self.json("sample", name, self.path("a.tif"), "--size", 21)
            raster = read_raster(self.path("a.tif"))
            self.assertEqual(report, {"samples": shape[0] * shape[1], "rows": shape[0],
                                      "cols": shape[1], "components": bands})
            self.assertEqual([plane.shape for plane in raster.planes], [shape] * bands)
            self.assertEqual(raster.mask.all(), name != "face")
            self.assertGreater(raster.planes[0][raster.mask].std(), 0.001)

    def test_franke_is_frankes_function(self):
        self.json("sample", "franke", self.path("a.tif"), "--size", 5)
        y, x = np.mgrid[0:5, 0:5] / 4
        y = 9 * (1 - y)
        x = 9 * x
        expected = (0.75 * np.exp(-((x - 2)**2 + (y - 2)**2) / 4)
                    + 0.75 * np.exp(-(x + 1)**2 / 49 - (y + 1) / 10)
                    + 0.5 * np.exp(-((x - 7)**2 + (y - 3)**2) / 4)
                    - 0.2 * np.exp(-(x - 4)**2 - (y - 7)**2))
        np.testing.assert_allclose(samples(self.path("a.tif")), expected, atol=1e-7)

    def test_seeds(self):
        contents = []
        for seed in (1, 2, 1):
            self.json("sample", "ridged", self.path("a.tif"), "--size", 50, "--seed", seed)
            contents.append(contents_of(self.path("a.tif")))
        self.assertEqual(contents[0], contents[2])
        self.assertNotEqual(contents[0], contents[1])

    def test_default_size(self):
        self.assertEqual(self.json("sample", "bump", self.path("a.tif"))["rows"], 513)


if __name__ == "__main__":
    main()
