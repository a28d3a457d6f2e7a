"""decode: levels, prefixes, windows, scales, and what surrounds the samples."""

import json
import os

import numpy as np
from osgeo import osr

from harness import NORTH_UP, ROTATED, Case, contents_of, hills, main, read_raster, samples

DECODE_KEYS = "samples bytes_read level bound rows cols finest_level damaged seconds".split()


def place(transform, col, row):
    t = transform
    return t[0] + t[1] * col + t[2] * row, t[3] + t[4] * col + t[5] * row


class RoundTrips(Case):
    def test_awkward_sizes_under_every_scheme(self):
        schemes = [("box", order, "interpolate", ()) for order in (1, 2)]
        schemes += [("box", 2, data_map, ()) for data_map in ("quasi-interpolate", "coefficients")]
        schemes += [("barycentric", order, "interpolate", ()) for order in (1, 2, 3, 4)]
        schemes += [("barycentric", 2, data_map, ()) for data_map in
                    ("quasi-interpolate", "coefficients")]
        schemes += [("barycentric", 2, "interpolate", ("--family", family))
                    for family in ("semi-orthogonal", "truncated", "truncated-literal")]
        schemes += [("barycentric", 1, "interpolate", ("--family", "semi-orthogonal")),
                    ("barycentric", 1, "interpolate", ("--dual", 3))]
        schemes += [("cubic", 2, "interpolate", ()), ("cubic", 2, "interpolate", ("--exact",))]
        sizes = ((1, 1), (1, 7), (7, 1), (2, 5), (3, 3), (17, 4))
        # Every scheme meets two of the sizes, every size several schemes.
        for k, (name, order, data_map, more) in enumerate(schemes):
            for rows, cols in (sizes[k % 6], sizes[(k + 2) % 6]):
                with self.subTest(scheme=name, order=order, map=data_map, more=more,
                                  size=(rows, cols)):
                    values = hills(rows, cols, seed=rows + cols)
                    dem = self.raster("dem.tif", values)
                    file, _ = self.encoded(dem, "--scheme", name, "--order", order, "--map",
                                           data_map, *more)
                    surface, report = self.decoded(file)
                    self.assertTrue(np.array_equal(surface, values))
                    self.assertEqual(list(report), DECODE_KEYS)
                    self.assertEqual((report["rows"], report["cols"]), (rows, cols))

    def test_larger_sizes_within_a_bound(self):
        values = hills(301, 200)
        dem = self.raster("dem.tif", values)
        for name, order, more in (("box", 1, ()), ("box", 2, ()), ("barycentric", 3, ()),
                                  ("barycentric", 2, ("--family", "truncated")),
                                  ("box", 2, ("--map", "coefficients")),
                                  ("cubic", 2, ()), ("cubic", 2, ("--exact",))):
            file, _ = self.encoded(dem, "--max-error", 2, "--scheme", name, "--order", order,
                                   *more)
            surface, _ = self.decoded(file)
            self.assertLessEqual(np.max(np.abs(surface - values)), 2, (name, order, more))


class Surroundings(Case):
    def about(self, **about):
        planes = [hills(50, 60, seed).astype("float32") for seed in (1, 2)]
        planes[0][3:9, 40:50] = -9999
        planes[1][3:9, 40:50] = -9999
        dem = self.raster("dem.tif", planes, nodata=-9999, **about)
        file, _ = self.encoded(dem, "--max-error", 1)
        self.json("decode", file, self.path("out.tif"))
        return read_raster(dem), read_raster(self.path("out.tif"))

    def test_all_survive(self):
        for transform, epsg in ((NORTH_UP, 32633), (ROTATED, 32633),
                                ((10.0, 0.25, 0.0, 50.0, 0.0, -0.25), 4326), (None, None)):
            before, after = self.about(transform=transform, epsg=epsg, unit="ft",
                                       names=["ground", "canopy"],
                                       metadata={"SURVEY": "1931 = good", "Ümlaut": "Höhe"})
            self.assertEqual(after.transform, before.transform)
            self.assertEqual((after.unit, after.nodata), ("ft", -9999))
            self.assertEqual(after.names, ["ground", "canopy"])
            self.assertTrue(np.array_equal(after.mask, before.mask))
            self.assertEqual(after.metadata["SURVEY"], "1931 = good")
            self.assertEqual(after.metadata["Ümlaut"], "Höhe")
            self.assertEqual(after.metadata["RELIEF_SCHEME"], "fvs order 2")
            self.assertEqual(after.metadata["RELIEF_MAX_ERROR"], "1")
            self.assertEqual(bool(after.wkt), epsg is not None)
            if epsg:
                old, new = osr.SpatialReference(), osr.SpatialReference()
                old.ImportFromWkt(before.wkt)
                new.ImportFromWkt(after.wkt)
                self.assertTrue(old.IsSame(new))

    def test_what_an_earlier_encoding_said_of_itself_goes(self):
        dem = self.raster("dem.tif", hills(40, 50))
        once, _ = self.encoded(dem, "--max-error", 2)
        self.json("decode", once, self.path("once.tif"))
        twice, _ = self.encoded(self.path("once.tif"), "--scheme", "barycentric", "--levels", 2)
        self.json("decode", twice, self.path("twice.tif"), "--scale", 2)
        metadata = read_raster(self.path("twice.tif")).metadata
        self.assertEqual(metadata["RELIEF_SCHEME"], "barycentric order 2")
        self.assertEqual(metadata["RELIEF_LEVELS"], "2")
        self.assertNotIn("RELIEF_MAX_ERROR", metadata)

    def test_other_formats(self):
        values = np.rint(hills(40, 50)).astype("uint16")
        dem = self.raster("dem.tif", values, transform=NORTH_UP)
        file, _ = self.encoded(dem)
        for name in ("a.png", "a.asc", "a.img", "a.vrt"):
            if name == "a.vrt":
                self.refuse(2, "decode", file, self.path(name))
                continue
            self.json("decode", file, self.path(name))
            self.assertTrue(np.array_equal(samples(self.path(name)), values), name)
        again, _ = self.encoded(self.path("a.img"), name="again.relief")
        self.assertTrue(np.array_equal(self.decoded(again)[0], values))


class Levels(Case):
    def test_sizes_places_and_values(self):
        for transform in (NORTH_UP, ROTATED):
            values = hills(101, 66, rough=0.5)
            dem = self.raster("dem.tif", values, transform=transform, nodata=-1)
            file, _ = self.encoded(dem, "--rms-error", 0.05)
            levels = self.json("info", file)["levels"]
            last_bytes = os.path.getsize(file) + 1
            for level in range(levels + 1):
                surface, report = self.decoded(file, "--level", level)
                step = 2**level
                self.assertEqual(surface.shape, (-(-101 // step), -(-66 // step)))
                self.assertEqual((report["level"], report["finest_level"]), (level, 0))
                self.assertLessEqual(report["bytes_read"], last_bytes)  # coarse ones share
                last_bytes = report["bytes_read"]
                after = read_raster(self.path("out.tif"))
                # Sample (r, c) of the level lies where sample (r, c) * 2^level lay.
                for row, col in ((0, 0), (surface.shape[0] - 1, surface.shape[1] - 1)):
                    np.testing.assert_allclose(
                        place(after.transform, col + 0.5, row + 0.5),
                        place(transform, col * step + 0.5, row * step + 0.5), rtol=1e-14)
                # The verified error of the level holds at its samples too.
                self.assertLessEqual(np.max(np.abs(surface - values[::step, ::step])),
                                     report["bound"] * (1 + 1e-9))

    def test_bound_holds_at_the_finest_level(self):
        values = hills(80, 90)
        dem = self.raster("dem.tif", values)
        for scheme, more in (("box", ()), ("barycentric", ()),
                             ("box", ("--map", "quasi-interpolate"))):
            file, _ = self.encoded(dem, "--rms-error", 1, "--scheme", scheme, "--levels", 3, *more)
            size = os.path.getsize(file)
            for level in range(4):
                # A prefix, at full size; its bound is known where a layer ends.
                surface, report = self.decoded(file, "--bytes", size * (4 - level) // 4)
                if report["bound"] is not None:
                    self.assertLessEqual(np.max(np.abs(surface - values)),
                                         report["bound"] * (1 + 1e-12))
                coarse, report = self.decoded(file, "--level", level)
                self.assertLessEqual(np.max(np.abs(coarse - values[::2**level, ::2**level])),
                                     report["bound"] * (1 + 1e-9))

    def test_holes_of_a_level(self):
        values = hills(41, 30).astype("float32")
        values[10:21, 5:9] = -1
        dem = self.raster("dem.tif", values, nodata=-1)
        file, _ = self.encoded(dem, "--max-error", 0.5)
        for level in (1, 2):
            surface, _ = self.decoded(file, "--level", level)
            self.assertTrue(np.array_equal(np.isnan(surface),
                                           values[::2**level, ::2**level] == -1))


class Prefixes(Case):
    def test_error_falls_with_every_byte(self):
        values = hills(120, 140, rough=1)
        values[30:40, 50:90] = -1
        dem = self.raster("dem.tif", values, nodata=-1)
        file, _ = self.encoded(dem, "--max-error", 0.25)
        size = os.path.getsize(file)
        valid = values != -1
        last = np.inf
        decoded = 0
        for count in np.unique(np.geomspace(200, size + 100, 22).astype(int)):
            done = self.run_raw("decode", file, self.path("out.tif"), "--bytes", count, "--json")
            if done.returncode:
                self.assertEqual(decoded, 0, "more bytes, less surface")
                self.assertIn("bytes", done.stderr)
                continue
            decoded += 1
            surface, report = samples(self.path("out.tif")), json.loads(done.stdout)
            self.assertLessEqual(report["bytes_read"], count)
            self.assertTrue(np.array_equal(np.isnan(surface), ~valid))
            error = np.max(np.abs(surface - values)[valid])
            self.assertLessEqual(error, report["bound"] * (1 + 1e-12))
            rms = np.sqrt(np.mean(np.square(surface - values)[valid]))
            self.assertLessEqual(rms, last * (1 + 1e-12))
            last = rms
        self.assertGreater(decoded, 10)
        self.assertLessEqual(error, 0.25)

    def test_what_is_left_of_a_cut_file(self):
        dem = self.raster("dem.tif", hills(120, 140))
        file, _ = self.encoded(dem, "--rms-error", 0.5)
        count = os.path.getsize(file) * 2 // 3
        with open(file, "rb") as whole:
            head = whole.read()[:count]
        cut = self.path("cut.relief")
        with open(cut, "wb") as part:
            part.write(head)
        self.refuse(1, "decode", cut, self.path("new.tif"), says=("cut.relief", f"--bytes {count}"))
        left, report = self.decoded(cut, "--bytes", count)
        same, _ = self.decoded(file, "--bytes", count, name="same.tif")
        self.assertTrue(np.array_equal(left, same))
        self.assertGreater(report["finest_level"], 0)

    def test_prefixes_of_edited_files_are_edited(self):
        dem = self.raster("dem.tif", hills(120, 140))
        file, _ = self.encoded(dem, "--rms-error", 0.5)
        edited = self.path("edited.relief")
        self.json("edit", file, edited, "--level", 4, "--move", "3:100")
        count = os.path.getsize(file) // 2
        before, report = self.decoded(file, "--bytes", count)
        after, after_report = self.decoded(edited, "--bytes",
                                           count + os.path.getsize(edited)
                                           - os.path.getsize(file))
        self.assertEqual(after_report["finest_level"], report["finest_level"])
        self.assertGreater(np.max(after - before), 50)
        self.assertIsNone(after_report["bound"])


class WindowsAndScales(Case):
    def setUp(self):
        super().setUp()
        self.values = hills(60, 73, rough=0.3)
        self.values[20:30, 40:45] = -1
        self.dem = self.raster("dem.tif", self.values, transform=ROTATED, nodata=-1)
        self.file, _ = self.encoded(self.dem, "--rms-error", 0.02)

    def test_window_is_the_crop(self):
        for more in ((), ("--level", 1), ("--scale", 2)):
            full, _ = self.decoded(self.file, *more)
            whole = read_raster(self.path("out.tif"))
            rows, cols = full.shape
            for col, row, width, height in ((0, 0, cols, rows), (5, 7, 11, 13), (cols - 1, 0, 1, 1),
                                            (0, rows - 1, cols, 1)):
                part, report = self.decoded(self.file, *more, "--window",
                                            f"{col},{row},{width},{height}")
                self.assertTrue(np.array_equal(part, full[row:row + height, col:col + width],
                                               equal_nan=True))
                self.assertEqual(report["samples"], width * height)
                after = read_raster(self.path("out.tif"))
                np.testing.assert_allclose(place(after.transform, 0, 0),
                                           place(whole.transform, col, row), rtol=1e-14)
                self.assertEqual([after.transform[k] for k in (1, 2, 4, 5)],
                                 [whole.transform[k] for k in (1, 2, 4, 5)])

    def test_scales_cover_the_same_ground(self):
        full, _ = self.decoded(self.file)
        for scale in (2, 0.5, 0.37, 4, 1.7):
            surface, report = self.decoded(self.file, "--scale", scale)
            rows, cols = int(np.ceil(60 * scale - 1e-9)), int(np.ceil(73 * scale - 1e-9))
            self.assertEqual(surface.shape, (rows, cols))
            self.assertIsNone(report["bound"])
            after = read_raster(self.path("out.tif"))
            np.testing.assert_allclose(place(after.transform, 0, 0), place(ROTATED, 0, 0))
            np.testing.assert_allclose(place(after.transform, 73 * scale, 60 * scale),
                                       place(ROTATED, 73, 60), rtol=1e-14)
            # Against bilinear interpolation of the samples: less than their roughness apart.
            r, c = np.mgrid[0:rows, 0:cols]
            i = np.clip((r + 0.5) / scale - 0.5, 0, 59 - 1e-9)
            j = np.clip((c + 0.5) / scale - 0.5, 0, 72 - 1e-9)
            i0, j0 = i.astype(int), j.astype(int)
            u, v = i - i0, j - j0
            linear = ((1 - u) * ((1 - v) * full[i0, j0] + v * full[i0, j0 + 1])
                      + u * ((1 - v) * full[i0 + 1, j0] + v * full[i0 + 1, j0 + 1]))
            difference = np.abs(surface - linear)
            self.assertLess(np.nanmax(difference), 6 if scale > 1 else 25)
            self.assertLess(np.sqrt(np.nanmean(np.square(difference))), 1.5)

    def test_integers_become_float_when_rescaled(self):
        dem = self.raster("int.tif", np.rint(hills(30, 30)).astype("int16"))
        file, _ = self.encoded(dem)
        self.json("decode", file, self.path("out.tif"), "--scale", 2)
        self.assertEqual(read_raster(self.path("out.tif")).type, "Float32")

    def test_tiny_rasters(self):
        for rows, cols in ((1, 1), (1, 7), (2, 2)):
            dem = self.raster("tiny.tif", np.full((rows, cols), 7.0))
            file, _ = self.encoded(dem)
            for scale in (0.1, 0.5, 3):
                surface, _ = self.decoded(file, "--scale", scale)
                # Coarser levels have no corrections: the quantiser's step remains.
                np.testing.assert_allclose(surface, 7, rtol=1e-8)


class Determinism(Case):
    def test_same_bytes_for_any_thread_count(self):
        values = hills(300, 280)
        values[50:60] = np.nan
        dem = self.raster("dem.tif", values.astype("float32"), transform=NORTH_UP)
        for goal, scheme, order in ((("--max-error", 0.5), "box", 2),
                                    (("--keep", 5), "barycentric", 1),
                                    (("--rms-error", 2), "cubic", 2)):
            contents = set()
            for threads in (1, 2, 5):
                file, _ = self.encoded(dem, *goal, "--scheme", scheme, "--order", order,
                                       "--threads", threads)
                outputs = [file]
                for number, more in enumerate(((), ("--scale", 1.5))):
                    outputs.append(self.path(f"{number}.tif"))
                    self.json("decode", file, outputs[-1], *more, "--threads", threads)
                contents.add(b"".join(contents_of(path) for path in outputs))
            self.assertEqual(len(contents), 1, (goal, scheme))


if __name__ == "__main__":
    main()
