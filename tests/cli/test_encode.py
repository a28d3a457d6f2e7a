"""encode: every goal holds for every sample type, and what is reported is what the file does."""

import os

import numpy as np

from harness import NORTH_UP, Case, energy, finite, hills, main, read_raster, samples

ENCODE_KEYS = ("scheme order levels samples coefficients kept bytes bits_per_sample max_error "
               "rms_error energy_percent bound corrected closed_loop profile lattice "
               "seconds").split()


def stored(dtype, rows=45, cols=60, seed=3):
    """Hills over most of the range of the type; floats with all their digits."""
    unit = hills(rows, cols, seed) / 420
    ranges = {"uint8": (3, 240), "uint16": (9, 60000), "int16": (-30000, 30000),
              "uint32": (5, 4e9), "int32": (-2e9, 2e9), "float32": (-80, 700),
              "float64": (-80, 700)}
    low, high = ranges[dtype]
    values = low + (high - low) * np.clip(unit, 0, 1)
    return values.astype(dtype) if dtype.startswith("float") else np.rint(values).astype(dtype)


def holes(values, nodata):
    """The same with a diagonal bay and a few single holes."""
    rows, cols = values.shape
    i, j = np.mgrid[0:rows, 0:cols]
    result = values.copy()
    result[(i + j < rows // 2) | (i * 31 + j * 17 == 400) | ((i * 7 + j * 13) % 101 == 0)] = nodata
    return result


class Report(Case):
    def test_json_keys_and_their_agreement_with_the_file(self):
        dem = self.raster("dem.tif", holes(stored("int16"), -32768), nodata=-32768,
                          transform=NORTH_UP, unit="m")
        for goal in (("--max-error", 40), ("--rms-error", 30), ("--keep", 10), ("--bytes", 2500),
                     ("--lossless",)):
            with self.subTest(goal=goal):
                file, report = self.encoded(dem, *goal)
                self.assertEqual(list(report), ENCODE_KEYS)
                for key in ENCODE_KEYS[1:]:
                    if key not in ("profile", "lattice", "closed_loop"):
                        self.assertTrue(finite(report[key]), key)
                closed = goal[0] in ("--max-error", "--lossless")
                self.assertEqual((report["scheme"], report["closed_loop"]),
                                 ("fvs", True) if closed else ("cubic", False))
                self.assertEqual(report["profile"], "dense" if closed else None)
                self.assertEqual(report["samples"], 45 * 60)
                self.assertEqual(report["bytes"], os.path.getsize(file))
                self.assertEqual(report["bits_per_sample"], 8 * report["bytes"] / (45 * 60))
                self.assertLessEqual(report["kept"], report["coefficients"])

                info = self.json("info", file)
                self.assertEqual(info["levels"], report["levels"])
                self.assertEqual(info["bound"], report["bound"])
                self.assertEqual(sum(band["rows"] * band["cols"] for band in info["bands"]),
                                 report["coefficients"])

                self.json("decode", file, self.path("out.tif"))
                for other in (file, self.path("out.tif")):
                    compared = self.json("compare", dem, other)
                    self.assertEqual(compared["max_error"], report["max_error"])
                    # Squares are summed in another order there.
                    self.assertAlmostEqual(compared["rms_error"], report["rms_error"],
                                           delta=1e-12 * (1 + report["rms_error"]))
                    self.assertAlmostEqual(compared["energy_percent"], report["energy_percent"],
                                           delta=1e-9 * (1 + report["energy_percent"]))

    def test_energy_percent_is_relative_to_the_coarsest_level(self):
        dem = self.raster("dem.tif", hills(50, 70))
        file, report = self.encoded(dem, "--keep", 8, "--levels", 3)
        nothing, _ = self.encoded(dem, "--keep", 0, "--levels", 3, "--effort", 0,
                                  name="coarse.relief")
        full = samples(dem)
        surface, _ = self.decoded(file)
        # Nothing but the scaling band, as analysis gives it: quantised to 2^-25 of its largest.
        coarse, _ = self.decoded(nothing)
        percent = 100 * energy(surface - full) / energy(coarse - full)
        self.assertAlmostEqual(report["energy_percent"], percent, delta=1e-5 * percent)

    def test_text_says_the_same(self):
        dem = self.raster("dem.tif", stored("int16"), unit="m")
        text = self.text("encode", dem, self.path("a.relief"), "--max-error", 25)
        self.assertIn("60 x 45 samples", text)
        self.assertIn("bound 25 m verified at every valid sample", text)
        self.assertEqual(self.text("encode", dem, self.path("a.relief"), "-q"), "")


class MaxError(Case):
    def test_every_type_and_bound(self):
        for dtype in ("uint8", "uint16", "int16", "uint32", "int32", "float32", "float64"):
            values = stored(dtype)
            spread = float(values.max()) - float(values.min())
            dem = self.raster("dem.tif", values)
            for bound in (1e-30, spread * 0.003, spread * 1e6):
                with self.subTest(dtype=dtype, bound=bound):
                    file, report = self.encoded(dem, "--max-error", bound)
                    surface, _ = self.decoded(file)
                    error = np.max(np.abs(surface - values.astype("float64")))
                    self.assertLessEqual(error, bound)
                    self.assertEqual(error, report["max_error"])
                    self.assertEqual(report["bound"], bound)

    def test_coarser_bounds_make_smaller_files(self):
        for dtype in ("int16", "float32"):
            dem = self.raster("dem.tif", stored(dtype, 150, 200))
            sizes = [self.encoded(dem, "--max-error", bound)[1]["bytes"]
                     for bound in (0, 1e-30, 1e-5, 1e-3, 0.5, 32)]
            for finer, coarser in zip(sizes, sizes[1:]):
                # The header names the bound.
                self.assertLessEqual(coarser, finer + 16, (dtype, sizes))

    def test_three_bands_with_holes(self):
        planes = [holes(stored("float32", seed=k), np.nan) for k in (1, 2, 3)]
        planes[1] *= 0.01
        dem = self.raster("dem.tif", planes)
        file, _ = self.encoded(dem, "--max-error", 0.25)
        self.json("decode", file, self.path("out.tif"))
        decoded = read_raster(self.path("out.tif"))
        for before, after in zip(planes, decoded.planes):
            self.assertTrue(np.array_equal(np.isnan(before), np.isnan(after)))
            self.assertLessEqual(np.nanmax(np.abs(before.astype("float64") - after)), 0.25)

    def test_decoded_values_never_read_as_nodata(self):
        # The nodata value lies amid the data: rounding must not hit it.
        values = np.rint(hills(60, 60) / 8).astype("int16")
        values[values == 25] = 26
        values[10:20, 10:20] = 25
        dem = self.raster("dem.tif", values, nodata=25)
        file, _ = self.encoded(dem, "--max-error", 3)
        self.json("decode", file, self.path("out.tif"))
        decoded = read_raster(self.path("out.tif"))
        self.assertTrue(np.array_equal(decoded.mask, values != 25))
        difference = np.abs(decoded.planes[0].astype(int) - values)[values != 25]
        self.assertLessEqual(difference.max(), 3)


class RmsError(Case):
    def test_met_and_used(self):
        for dtype, goal in (("int16", 60), ("float32", 1.5), ("float64", 0.4)):
            for scheme in (("box", 2), ("barycentric", 1), ("cubic", 2)):
                with self.subTest(dtype=dtype, scheme=scheme):
                    dem = self.raster("dem.tif", holes(stored(dtype, 90, 110), 9), nodata=9)
                    file, report = self.encoded(dem, "--rms-error", goal, "--scheme", scheme[0],
                                                "--order", scheme[1])
                    surface, _ = self.decoded(file)
                    difference = surface - samples(dem)
                    rms = np.sqrt(np.nanmean(np.square(difference)))
                    self.assertLessEqual(rms, goal)
                    self.assertGreaterEqual(rms, 0.9 * goal)
                    self.assertAlmostEqual(rms, report["rms_error"], delta=1e-12 * goal)

    def test_extremes(self):
        values = stored("float64")
        dem = self.raster("dem.tif", values)
        for goal in (0, 1e-300, 1e-12, 1e6, 1e300):
            _, report = self.encoded(dem, "--rms-error", goal)
            self.assertLessEqual(report["rms_error"], goal)


class Bytes(Case):
    def test_kept_and_used(self):
        for dtype in ("int16", "float32"):
            dem = self.raster("dem.tif", stored(dtype, 100, 120))
            for scheme in ("box", "barycentric"):
                for size in (2500, 9000):
                    with self.subTest(dtype=dtype, scheme=scheme, size=size):
                        file, report = self.encoded(dem, "--bytes", size, "--scheme", scheme)
                        self.assertLessEqual(os.path.getsize(file), size)
                        self.assertGreaterEqual(os.path.getsize(file), 0.95 * size)
                        self.assertEqual(report["bytes"], os.path.getsize(file))

    def test_more_than_needed(self):
        dem = self.raster("dem.tif", stored("int16"))
        _, report = self.encoded(dem, "--bytes", 10**9)
        self.assertEqual(report["max_error"], 0)

    def test_more_bytes_less_error(self):
        dem = self.raster("dem.tif", hills(150, 200, rough=0.1).astype("float32"))
        errors = [self.encoded(dem, "--bytes", size)[1]["rms_error"]
                  for size in (1500, 3000, 6000, 12000, 24000)]
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertGreater(errors[0], 4 * errors[-1])


class Lossless(Case):
    def exact(self, values, *options, **about):
        dem = self.raster("dem.tif", values, **about)
        file, report = self.encoded(dem, *options)
        self.assertEqual((report["max_error"], report["rms_error"], report["bound"]), (0, 0, 0))
        self.json("decode", file, self.path("out.tif"))
        after = read_raster(self.path("out.tif"))
        before = read_raster(dem)
        self.assertEqual(after.type, before.type)
        self.assertTrue(np.array_equal(after.mask, before.mask))
        for old, new in zip(before.planes, after.planes):
            # Bits, so that -0 is not 0.
            self.assertEqual(old[before.mask].tobytes(), new[after.mask].tobytes())
        return report

    def test_every_type(self):
        for dtype in ("uint8", "uint16", "int16", "uint32", "int32", "float32", "float64"):
            values = stored(dtype)
            nodata = values[0, 0].item()
            for scheme in (("box", 2), ("barycentric", 1)):
                with self.subTest(dtype=dtype, scheme=scheme):
                    self.exact(holes(values, nodata), "--scheme", scheme[0], "--order", scheme[1],
                               nodata=nodata)

    def test_random_bits(self):
        rng = np.random.default_rng(5)
        for dtype in ("uint8", "uint16", "int16", "uint32", "int32"):
            info = np.iinfo(dtype)
            self.exact(rng.integers(info.min, info.max, (20, 30), dtype, endpoint=True))
        for dtype, bits in (("float32", "uint32"), ("float64", "uint64")):
            info = np.iinfo(bits)
            noise = rng.integers(info.min, info.max, (20, 30), bits, endpoint=True).view(dtype)
            # Samples beyond 1e45 are refused.
            noise = np.where(np.abs(noise) < 1e45, noise, -0.0).astype(dtype)
            with self.subTest(dtype=dtype):
                self.exact(noise)

    def test_negative_zero_and_the_smallest_numbers(self):
        for dtype in ("float32", "float64"):
            values = np.zeros((45, 60), dtype)
            tiny = np.finfo(dtype).smallest_subnormal
            values[::3, ::2] = -0.0
            values[1::3, ::5] = tiny
            values[2::3, ::7] = -tiny
            values[5, 5] = np.finfo(dtype).max if dtype == "float32" else 1e45
            self.exact(values)

    def test_lossless_is_the_default_and_max_error_zero(self):
        values = stored("int16")
        sizes = {self.exact(values, *goal)["bytes"]
                 for goal in ((), ("--lossless",), ("--max-error", 0), ("--rms-error", 0))}
        # The header names the goal, the rest is the same.
        self.assertLessEqual(max(sizes) - min(sizes), 8)

    def test_constant_rasters(self):
        for value in (0, 77):
            report = self.exact(np.full((200, 100), value, "int16"))
            self.assertLess(report["bytes"], 1500)
            self.assertEqual(report["energy_percent"], 0)


class Keep(Case):
    def test_counts_and_errors(self):
        dem = self.raster("dem.tif", hills(61, 83))
        for scheme in ("box", "barycentric"):
            for order in (1, 2):
                last = np.inf
                for percent in (6.2, 13, 36, 90):
                    _, report = self.encoded(dem, "--keep", percent, "--levels", 3, "--scheme",
                                             scheme, "--order", order)
                    with self.subTest(scheme=scheme, order=order, percent=percent):
                        self.assertEqual(report["kept"], round(percent / 100 * 61 * 83))
                        self.assertLess(report["rms_error"], last)
                    last = report["rms_error"]

    def test_scaling_band_always_stays(self):
        dem = self.raster("dem.tif", hills(61, 83))
        file, report = self.encoded(dem, "--keep", 0, "--levels", 3)
        scaling = self.json("info", file)["bands"][0]
        self.assertEqual(report["kept"], scaling["rows"] * scaling["cols"])

    def test_all_coefficients_reconstruct_to_float_precision(self):
        dem = self.raster("dem.tif", hills(61, 83))
        for scheme in ("box", "barycentric"):
            for order in (1, 2):
                _, report = self.encoded(dem, "--keep", 300, "--scheme", scheme, "--order", order)
                self.assertEqual(report["kept"], report["coefficients"])
                # Every coefficient is off by up to 2^-25 of its band's largest, about 400.
                self.assertLess(report["max_error"], 400 * 2.0**-24 * 10)

    def test_quartic_wavelets_keep_less_error_than_linear_ones(self):
        # Heights with slopes that are continuous, as those of the source paper.
        i, j = np.mgrid[0:97, 0:97]
        dem = self.raster("dem.tif", 100 * np.sin(i / 9) * np.cos(j / 7) + hills(97, 97, rough=0))
        for percent in (36, 24.5, 13, 6.2):
            linear, quartic = (
                self.encoded(dem, "--keep", percent, "--levels", 3, "--scheme", "barycentric",
                             "--order", order)[1]["energy_percent"] for order in (1, 2))
            self.assertLess(quartic, linear, percent)

    def test_effort_pays(self):
        dem = self.raster("dem.tif", hills(61, 83))
        for scheme in ("box", "barycentric"):
            plain, refitted, reselected = (
                self.encoded(dem, "--keep", 10, "--scheme", scheme, "--effort",
                             effort)[1]["rms_error"] for effort in (0, 1, 2))
            self.assertLess(refitted, 0.99 * plain)
            # Reselection is no descent; it may end slightly beside what it began with.
            self.assertLess(reselected, 1.01 * refitted)


if __name__ == "__main__":
    main()
