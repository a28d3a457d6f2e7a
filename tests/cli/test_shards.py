"""Rasters encoded in shards: merged, they are the file of one process."""

import numpy as np
from harness import Case, contents_of, hills, main


class Shards(Case):
    def setUp(self):
        super().setUp()
        self.dem = self.raster("dem.tif", hills(900, 1400).astype(np.float32), unit="m", nodata=-9999,
                               transform=(0.0, 30.0, 0.0, 0.0, 0.0, -30.0), epsg=32611)

    def sharded(self, *goal):
        plan, north, south = (self.path(name) for name in ("plan.shard", "north.shard", "south.shard"))
        planned = self.json("shard", self.dem, plan, *goal)
        self.assertEqual((planned["tile_rows"], planned["tile_cols"]), (2, 3))
        self.assertEqual(sorted(planned["tiles"] + planned["missing"]), list(range(6)))
        first, rest = planned["missing"][:1], planned["missing"][1:]
        self.json("shard", self.dem, north, "--plan", plan, "--tiles", first[0])
        made = self.json("shard", self.dem, south, "--plan", plan, "--tiles", ",".join(map(str, rest)))
        self.assertEqual(made["tiles"], rest)
        return plan, north, south

    def test_merged_shards_are_the_file_of_encode(self):
        for goal in (("--max-error", 1), ()):
            whole, report = self.encoded(self.dem, *goal, "--scheme", "fvs")
            plan, north, south = self.sharded(*goal)
            joined = self.path("joined.relief")
            merged = self.json("merge", south, plan, north, joined)
            self.assertEqual(contents_of(joined), contents_of(whole))
            for key in ("bytes", "max_error", "rms_error"):
                self.assertEqual(merged[key], report[key], key)

    def test_one_shard_takes_all_that_is_left(self):
        plan, rest, joined = self.path("p"), self.path("r"), self.path("j")
        self.json("shard", self.dem, plan, "--max-error", 2, "--profile", "fast")
        self.json("shard", self.dem, rest, "--plan", plan)
        self.json("merge", plan, rest, joined)
        whole, _ = self.encoded(self.dem, "--max-error", 2, "--profile", "fast", "--scheme", "fvs")
        self.assertEqual(contents_of(joined), contents_of(whole))

    def test_what_is_wrong_is_said(self):
        plan, north, south = self.sharded()
        out = self.path("out.relief")
        self.refuse(1, "merge", plan, north, out, says="no shard has tile")
        self.refuse(1, "merge", north, south, out, says="no shard is the plan")
        self.refuse(1, "merge", plan, north, north, out, says=(north, "has tile"))
        self.refuse(1, "merge", plan, self.dem, out, says=(self.dem, "not a .relief file"))
        self.refuse(1, "merge", self.path("none"), out, says="none")
        self.refuse(2, "merge", plan)
        self.refuse(1, "shard", self.dem, out, "--plan", north, says="not the plan")
        other = self.raster("other.tif", hills(900, 1401).astype(np.float32))
        self.refuse(1, "shard", other, out, "--plan", plan, says="another size")
        for tiles in ("6", "x", "3-1", "1,,2", "-1"):
            self.refuse(2, "shard", self.dem, out, "--plan", plan, f"--tiles={tiles}", says="--tiles")
        self.refuse(2, "shard", self.dem, out, "--tiles", 1, says="--plan")
        self.refuse(2, "shard", self.dem, out, "--plan", plan, "--max-error", 1, says="goal")
        self.refuse(1, "info", plan, says="raster-shard")
        self.refuse(1, "decode", plan, self.path("out.tif"), says="raster-shard")


if __name__ == "__main__":
    main()
