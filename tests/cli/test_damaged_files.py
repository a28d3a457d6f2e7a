"""Damaged .relief files: always an error, or info saying that checksums fail; never wrong data."""

import random

import numpy as np

from harness import NORTH_UP, Case, contents_of, hills, main, read_raster


class Damaged(Case):
    @classmethod
    def setUpClass(cls):
        cls.values = hills(50, 60).astype("float32")
        cls.values[5:12, 20:31] = -1

    def setUp(self):
        super().setUp()
        dem = self.raster("dem.tif", self.values, nodata=-1, transform=NORTH_UP)
        plain, _ = self.encoded(dem, "--max-error", 0.5, name="plain.relief")
        self.file = self.path("good.relief")
        self.json("edit", plain, self.file, "--level", 2, "--move", "20:5")
        self.bytes = contents_of(self.file)
        self.json("decode", self.file, self.path("good.tif"))
        self.good = read_raster(self.path("good.tif"))
        self.bad = self.path("bad.relief")

    def write_bad(self, content):
        with open(self.bad, "wb") as file:
            file.write(content)

    def refuse_bad(self):
        """Decoding fails; info fails too or says that checksums do not hold."""
        self.refuse(1, "decode", self.bad, self.path("new.tif"), says="bad.relief")
        done = self.run_raw("info", self.bad, "--json")
        self.assertIn(done.returncode, (0, 1))
        if done.returncode == 0:
            self.assertIn('"checksums_ok":false', done.stdout)

    def test_cut_at_many_lengths(self):
        size = len(self.bytes)
        for length in [0, 1, 9, 10, 31, 32, 33, size - 1, *range(40, size, size // 14)]:
            with self.subTest(length=length):
                self.write_bad(self.bytes[:length])
                self.refuse_bad()

    def test_longer_than_it_says(self):
        self.write_bad(self.bytes + b"\0")
        self.refuse_bad()

    def test_flipped_bits(self):
        generator = random.Random(7)
        places = list(range(0, 32, 3)) + [generator.randrange(32, len(self.bytes))
                                          for _ in range(40)]
        for place in places:
            with self.subTest(byte=place):
                broken = bytearray(self.bytes)
                broken[place] ^= 1 << generator.randrange(8)
                self.write_bad(broken)
                self.refuse_bad()

    def test_every_verb_refuses(self):
        broken = bytearray(self.bytes)
        broken[-5] ^= 1
        self.write_bad(broken)
        dem = self.path("dem.tif")
        for arguments in (("encode", self.bad, self.path("n.relief")),
                          ("compare", dem, self.bad), ("compare", self.bad, dem),
                          ("eval", self.bad, "--at", "400100,5199900"),
                          ("edit", self.bad, self.path("n.relief"), "--level", 0, "--move", "0:1"),
                          ("render", self.bad, self.path("n.png")),
                          ("render", dem, self.path("n.png"), "--style", "error",
                           "--reference", self.bad)):
            self.refuse(1, *arguments, says=("bad.relief", "damaged"))
        self.assertFalse(self.json("info", self.bad)["checksums_ok"])
        self.assertIn("DO NOT HOLD", self.text("info", self.bad))
        # What precedes the damage is still good.
        coarse, _ = self.decoded(self.bad, "--level", 2)
        self.assertTrue(np.array_equal(coarse, self.decoded(self.file, "--level", 2)[0],
                                       equal_nan=True))

    def test_later_versions_are_refused_politely(self):
        self.write_bad(self.bytes[:10] + b"\x09\x00" + self.bytes[12:])
        self.refuse(1, "decode", self.bad, self.path("new.tif"), says=("version", "newer"))

    def test_the_undamaged_file_is_good(self):
        difference = np.abs(self.good.planes[0].astype(float) - self.values)[self.good.mask]
        self.assertLess(np.median(difference), 0.5)
        self.assertTrue(np.array_equal(self.good.mask, self.values != -1))


if __name__ == "__main__":
    main()
