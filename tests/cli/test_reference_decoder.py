"""The decoder that was written from docs/format.md gives what the program gives, sample by sample."""

import unittest

import numpy as np

from harness import Case, contents_of, hills, main, read_raster
from reference_decoder import Decoder, library

PROFILES = ("fast", "dense")


def without(values, nodata, holes):
    result = values.copy()
    result[holes] = nodata
    return result


@unittest.skipUnless(library("zstd") and library("xxhash"), "needs libzstd and libxxhash")
class ReferenceDecoder(Case):
    def compare(self, planes, *options, nodata=None):
        """Encodes, decodes both ways and compares; returns the header of the file."""
        dem = self.raster("dem.tif", planes, nodata=nodata)
        for profile in PROFILES:
            with self.subTest(profile=profile, options=options):
                file, report = self.encoded(dem, *options, "--scheme", "fvs", "--profile", profile)
                self.assertTrue(report["closed_loop"])
                decoder = Decoder(contents_of(file))
                self.assertEqual(decoder.lattice["profile"], profile)
                self.json("decode", file, self.path("out.tif"))
                expected = read_raster(self.path("out.tif"))
                for plane, want in zip(decoder.decode(), expected.planes, strict=True):
                    valid = np.array([[value is not None for value in row] for row in plane])
                    self.assertTrue(np.array_equal(valid, expected.mask))
                    have = np.array([[value or 0 for value in row] for row in plane])
                    self.assertTrue(np.array_equal(have.astype(want.dtype)[valid], want[valid]))
        return decoder.header

    def test_integers_with_holes(self):
        values = np.rint(hills(40, 50)).astype("int16")
        i, j = np.mgrid[0:40, 0:50]
        values = without(values, -1, ((i - 20)**2 + (j - 9)**2 < 60) | (i * 7 + j * 13) % 101 == 0)
        self.compare(values, "--max-error", 2, nodata=-1)
        self.compare(values, "--max-error", 40, nodata=-1)
        self.compare(values, "--lossless", nodata=-1)

    def test_floats_without_a_lattice(self):
        values = hills(37, 41).astype("float32")
        header = self.compare(values, "--max-error", 0.3)
        self.assertEqual(header["lattice"]["domains"][0]["step"], 63)
        self.compare(without(values, values[3, 3], values > 300), "--max-error", 0.3,
                     nodata=float(values[3, 3]))
        self.compare(values.astype("float64"), "--max-error", 0.001)

    def test_lossless_floats_and_raw_bits(self):
        header = self.compare((1000 + hills(40, 50)).astype("float32"), "--lossless")
        self.assertTrue(header["lattice"]["domains"][0]["floats"])
        self.assertGreater(header["lattice"]["domains"][0]["raw_bits"], 3)
        steep = np.rint(1e5 * hills(40, 50, rough=30)).astype("int32")
        header = self.compare(steep, "--max-error", 4)
        self.assertGreater(header["lattice"]["domains"][0]["raw_bits"], 3)

    def test_repairs_of_samples_off_the_lattice(self):
        values = np.rint(hills(40, 50)).astype("float32")
        values[[0, 7, 16], [0, 33, 32]] += np.float32(0.37)
        header = self.compare(values, "--lossless")
        self.assertTrue(header["lattice"]["domains"][0]["lattice"])

    def test_interpolated_grids(self):
        coarse = np.rint(hills(21, 25, rough=30)).astype("int64")
        fine = np.zeros((41, 49), "int64")
        fine[::2, ::2] = coarse
        fine[1::2, ::2] = (coarse[:-1] + coarse[1:]) // 2
        fine[:, 1::2] = (fine[:, :-2:2] + fine[:, 2::2]) // 2
        self.compare(fine.astype("int16"), "--lossless")

    def test_interpolated_grids_that_begin_between_coarser_samples(self):
        coarse = np.rint(hills(31, 101, rough=30)).astype("int64")
        fine = np.zeros((60, 199), "int64")
        fine[::2, 1::2] = coarse[:30, :99]
        fine[:, 2:-1:2] = (fine[:, 1:-2:2] + fine[:, 3::2]) // 2
        fine[:, 0] = fine[:, 1]
        fine[:, -1] = fine[:, -2]
        fine[1:-1:2] = (fine[:-2:2] + fine[2::2]) // 2
        fine[-1] = fine[-2]
        header = self.compare(fine.astype("int16"), "--lossless")
        self.assertEqual(header["lattice"]["margin"], [0, 1])

    def test_components_and_small_rasters(self):
        self.compare([hills(30, 20).astype("uint8"), hills(30, 20, seed=2).astype("uint8")],
                     "--max-error", 3)
        for rows, cols in ((1, 1), (1, 7), (5, 1), (2, 3)):
            self.compare(np.rint(hills(rows, cols)).astype("uint16"), "--max-error", 1)
        self.compare(np.full((9, 9), 7, "int32"), "--lossless")

    def test_tiers(self):
        values = np.rint(hills(9, 900)).astype("int16")
        self.compare(values, "--max-error", 3)
        self.compare(without(values, 0, np.s_[:, 500:]), "--max-error", 3, nodata=0)

    def test_tiles_without_samples(self):
        """Three tiers; the second one's eastern tile has no valid samples, but tiles below have."""
        values = np.rint(hills(3, 6200)).astype("int16")
        values[:, 4096::8] = 0
        values[:, 5000:5600] = 0
        header = self.compare(values, "--max-error", 4, nodata=0)
        self.assertEqual((header["rows"], header["cols"]), (3, 6200))


if __name__ == "__main__":
    main()
