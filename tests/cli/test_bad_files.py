"""Bad inputs and outputs that can not be written: one line that says what, where and what to do,
and nothing left behind."""

import os
import subprocess

import numpy as np

from harness import NORTH_UP, RELIEF, Case, hills, main


class BadInput(Case):
    def test_missing_files(self):
        none = self.path("none.tif")
        dem = self.raster("dem.tif", hills(9, 8))
        for arguments in (("encode", none, self.path("a.relief")),
                          ("decode", none, self.path("a.tif")), ("info", none),
                          ("compare", none, dem), ("compare", dem, none),
                          ("eval", none, "--at", "1,1"),
                          ("edit", none, self.path("b.relief"), "--level", 0, "--move", "0:1"),
                          ("render", none, self.path("a.png"))):
            self.refuse(1, *arguments, says="none.tif: ")

    def test_files_of_other_kinds(self):
        text = self.path("text.tif")
        with open(text, "w", encoding="ascii") as file:
            file.write("this is not a raster\n" * 20)
        self.refuse(1, "encode", text, self.path("a.relief"), says=("text.tif", "not a raster"))
        self.refuse(1, "encode", self.directory, self.path("a.relief"), says="is a directory")
        self.refuse(1, "decode", text, self.path("a.tif"), says=("text.tif", "not a .relief"))
        dem = self.raster("dem.tif", hills(9, 8))
        self.refuse(1, "eval", dem, "--at", "1,1", says="not a .relief")
        empty = self.path("empty.relief")
        open(empty, "wb").close()
        for arguments in (("info", empty), ("decode", empty, self.path("a.tif"))):
            self.refuse(1, *arguments, says="empty.relief")
        with open(self.path("mesh.obj"), "w", encoding="ascii") as file:
            file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.refuse(1, "encode", self.path("mesh.obj"), self.path("a.relief"), says="mesh")
        with open(self.path("p.csv"), "w", encoding="ascii") as file:
            file.write("1,2,3\n")
        self.refuse(1, "encode", self.path("p.csv"), self.path("a.relief"), says="points")

    def test_rasters_without_a_valid_sample(self):
        out = self.path("a.relief")
        nan = self.raster("nan.tif", np.full((9, 8), np.nan, "float32"))
        hole = self.raster("hole.tif", np.full((9, 8), -9, "int16"), nodata=-9)
        for source in (nan, hole):
            self.refuse(1, "encode", source, out, says=(source, "no sample is valid"))

    def test_samples_and_bands_beyond_the_limits(self):
        out = self.path("a.relief")
        five = self.raster("five.tif", [hills(9, 8)] * 5)
        self.refuse(1, "encode", five, out, says=("5 bands", "at most 4"))
        huge = self.raster("huge.tif", np.full((9, 8), 1e46))
        self.refuse(1, "encode", huge, out, says=("huge.tif, row 0, column 0", "NODATA"))

    def test_damaged_geotiff(self):
        dem = self.raster("dem.tif", hills(300, 300))
        with open(dem, "rb") as file:
            bytes_ = file.read()
        with open(dem, "wb") as file:
            file.write(bytes_[:len(bytes_) // 2])
        self.refuse(1, "encode", dem, self.path("a.relief"), says="dem.tif")

    def test_rasters_that_can_not_be_compared(self):
        a = self.raster("a.tif", hills(9, 8))
        b = self.raster("b.tif", hills(8, 9))
        self.refuse(1, "compare", a, b, says=("8 x 9", "9 x 8"))
        c = self.raster("c.tif", [hills(9, 8)] * 2)
        self.refuse(1, "compare", a, c, says="2 bands")
        hole = self.raster("hole.tif", np.full((9, 8), np.nan))
        self.refuse(1, "compare", a, hole, says="no sample is valid in both")


class BadOutput(Case):
    def setUp(self):
        super().setUp()
        self.dem = self.raster("dem.tif", hills(120, 130).astype("int16"), transform=NORTH_UP)
        self.relief, _ = self.encoded(self.dem, "--max-error", 1, name="dem.relief")

    def runs(self, relief, tif, png, csv):
        """One run of each verb that writes a file, with the output it would write."""
        return (("encode", self.dem, relief), ("decode", self.relief, tif),
                ("decode", self.relief, tif, "--scale", 2),
                ("edit", self.relief, relief, "--level", 1, "--move", "5:1"),
                ("render", self.dem, png), ("sample", "franke", tif),
                ("eval", self.relief, "--at", "400100,5199900", "--output", csv))

    def in_place(self, folder):
        return self.runs(f"{folder}/a.relief", f"{folder}/a.tif", f"{folder}/a.png",
                         f"{folder}/a.csv")

    def test_output_below_a_file_or_a_missing_folder(self):
        for folder in (self.dem, self.path("none")):
            for arguments in self.in_place(folder):
                with self.subTest(arguments=arguments):
                    self.refuse(1, *arguments, says=("no directory", "create it first"))

    def test_output_where_nobody_may_write(self):
        for arguments in self.in_place("/proc"):
            with self.subTest(arguments=arguments):
                self.refuse(1, *arguments, says=("/proc/a.", "can not write"))

    def test_output_is_a_directory(self):
        for name in ("a.relief", "a.tif", "a.png", "a.csv"):
            os.mkdir(self.path(name))
        for arguments in self.in_place(self.directory):
            with self.subTest(arguments=arguments):
                self.refuse(1, *arguments, says="is a directory; give a file name")

    def test_full_disk_keeps_what_was_there(self):
        for name in ("a.relief", "a.tif", "a.png", "a.csv"):
            with open(self.path(name), "w", encoding="ascii") as file:
                file.write("precious")
        for arguments in self.in_place(self.directory):
            limit = 20 if arguments[0] == "eval" else 256
            with self.subTest(arguments=arguments):
                self.refuse(1, *arguments, says=("a.", "can not write"), file_limit=limit)
        for name in ("a.relief", "a.tif", "a.png", "a.csv"):
            with open(self.path(name), encoding="ascii") as file:
                self.assertEqual(file.read(), "precious")

    def test_devices(self):
        self.refuse(1, "encode", self.dem, "/dev/full", says="/dev/full")
        self.refuse(1, "edit", self.relief, "/dev/full", "--level", 1, "--move", "5:1",
                    says="/dev/full")

    def test_standard_output_is_full(self):
        points = self.path("p.csv")
        with open(points, "w", encoding="ascii") as file:
            file.writelines(f"{400000 + k},{5199000 + k}\n" for k in range(3000))
        for arguments in (("info", self.relief), ("info", self.relief, "--json"),
                          ("eval", self.relief, "--points", points)):
            with open("/dev/full", "w", encoding="ascii") as full:
                done = self.run_raw(*arguments, stdout=full)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r"\Arelief \w+: standard output: [^\n]+\n\Z")

    def test_interruption_leaves_nothing(self):
        big = self.raster("big.tif", hills(600, 600).astype("float32"))
        before = self.listing()
        with subprocess.Popen([RELIEF, "encode", big, self.path("a.relief"), "--rms-error", "0.5",
                               "--scheme", "barycentric"],
                              stderr=subprocess.PIPE, text=True) as process:
            try:
                process.wait(0.5)
            except subprocess.TimeoutExpired:
                process.terminate()
            stderr = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 1)
        self.assertIn("cancelled", stderr)
        self.assertEqual(self.listing(), before)


if __name__ == "__main__":
    main()
