"""Wrong usage: exit status 2, one line that says what and what to do, and nothing left behind."""

from harness import NORTH_UP, Case, hills, main


class WrongUsage(Case):
    def setUp(self):
        super().setUp()
        self.dem = self.raster("dem.tif", hills(40, 50).astype("int16"), transform=NORTH_UP)
        self.relief, _ = self.encoded(self.dem, "--max-error", 1, name="dem.relief")
        self.out = self.path("new.relief")
        self.tif = self.path("new.tif")

    def test_without_verb_or_with_an_unknown_one(self):
        for arguments, says in (((), "subcommand"), (("frobnicate",), "'frobnicate'"),
                                (("--frob",), "--frob")):
            done = self.run_raw(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, r"\Arelief: [^\n]+'relief --help'\n\Z")
            self.assertIn(says, done.stderr + "--frob")

    def test_help_and_version(self):
        self.assertRegex(self.text("--version"), r"\Arelief \d+\.\d+\.\d+\n\Z")
        self.assertIn("Exit status", self.text("--help"))
        for verb in ("encode", "decode", "info", "compare", "eval", "edit", "render", "sample",
                     "subdivide"):
            text = self.text(verb, "--help")
            self.assertIn(f"relief {verb} ", text.split("Examples:")[1])
            for option in ("--json", "--quiet", "--verbose", "--threads"):
                self.assertIn(option, text)

    def test_missing_arguments(self):
        for arguments in (("encode",), ("encode", self.dem), ("decode", self.relief), ("info",),
                          ("compare", self.dem), ("eval",), ("edit", self.relief), ("render",),
                          ("sample", "franke")):
            self.refuse(2, *arguments, says=("is required", f"'relief {arguments[0]} --help'"))

    def test_unknown_options_and_values(self):
        self.refuse(2, "encode", self.dem, self.out, "--frob", says="--frob")
        self.refuse(2, "encode", self.dem, self.out, "third", says="third")
        self.refuse(2, "encode", self.dem, self.out, "--max-error", "abc", says="abc")
        self.refuse(2, "encode", self.dem, self.out, "--max-error", says="--max-error")
        self.refuse(2, "encode", self.dem, self.out, "--effort", "3", says="effort")
        self.refuse(2, "encode", self.dem, self.out, "--profile", "slow", says="slow")
        self.refuse(2, "info", self.relief, "--threads", "-1", says="threads")
        self.refuse(2, "render", self.dem, self.path("a.png"), "--style", "oil", says="oil")
        self.refuse(2, "render", self.dem, self.path("a.png"), "--width", "3", says="width")

    def test_two_goals(self):
        for second in (("--rms-error", 1), ("--keep", 3), ("--bytes", 999), ("--lossless",)):
            self.refuse(2, "encode", self.dem, self.out, "--max-error", 1, *second,
                        says=("at most 1", "--max-error", second[0]))

    def test_goals_out_of_range(self):
        for goal in ("--max-error", "--rms-error", "--keep", "--bytes"):
            for value in ("-1", "nan", "inf"):
                self.refuse(2, "encode", self.dem, self.out, f"{goal}={value}",
                            says="must be a number that is not negative")
        self.refuse(2, "encode", self.dem, self.out, "--bytes", 0, says="at least one byte")
        self.refuse(2, "encode", self.dem, self.out, "--bytes", 40, says="alone take")

    def test_unknown_names_list_the_known(self):
        self.refuse(2, "encode", self.dem, self.out, "--scheme", "spline",
                    says=("'spline'", "barycentric, box, cubic"))
        self.refuse(2, "encode", self.dem, self.out, "--family", "haar",
                    says=("'haar'", "compact, semi-orthogonal, truncated"))
        self.refuse(2, "encode", self.dem, self.out, "--map", "nearest",
                    says=("'nearest'", "interpolate, quasi-interpolate, coefficients"))
        self.refuse(2, "sample", "moon", self.tif, says=("'moon'", "franke, bump, ridged"))

    def test_scheme_parameters_out_of_range(self):
        self.refuse(2, "encode", self.dem, self.out, "--order", 3, says=("box", "not 3"))
        for order in (0, 5, -1):
            self.refuse(2, "encode", self.dem, self.out, "--scheme", "barycentric",
                        "--order", order, says="order")
        self.refuse(2, "encode", self.dem, self.out, "--scheme", "cubic", "--order", 1,
                    says="order 2")
        self.refuse(2, "encode", self.dem, self.out, "--scheme", "cubic", "--map", "coefficients",
                    says="interpolate")
        self.refuse(2, "encode", self.dem, self.out, "--levels", 77, says=("77", "at most"))
        self.refuse(2, "encode", self.dem, self.out, "--levels", -2, says="negative")
        self.refuse(2, "encode", self.dem, self.out, "--scheme", "barycentric", "--levels", 9999,
                    says="9999")
        self.refuse(2, "encode", self.dem, self.out, "--scheme", "barycentric", "--dual", 77,
                    says="77")
        self.refuse(2, "compare", self.dem, self.relief, "--scheme", "box", "--levels", 99, says="99")

    def test_decode_options(self):
        for window in ("0,0,51,1", "-1,0,2,2", "50,0,1,1", "0,0,0,5", "9223372036854775807,0,2,2"):
            self.refuse(2, "decode", self.relief, self.tif, f"--window={window}",
                        says="50 x 40")
        for window in ("1,2,3", "1,2,3,4,5", "a,b,c,d"):
            self.refuse(2, "decode", self.relief, self.tif, f"--window={window}", says="window")
        for scale in ("0", "-2", "nan"):
            self.refuse(2, "decode", self.relief, self.tif, f"--scale={scale}",
                        says="--scale must be a positive number")
        self.refuse(2, "decode", self.relief, self.tif, "--scale", "1e9", says="--scale")
        self.refuse(2, "decode", self.relief, self.tif, "--scale", 2, "--level", 1,
                    says="exclude each other")
        self.refuse(2, "decode", self.relief, self.tif, "--level", 33, says="no level 33")
        self.refuse(2, "decode", self.relief, self.tif, "--level", -1, says="level")
        self.refuse(2, "decode", self.relief, self.tif, "--bytes", 0, says="at least 1")
        self.refuse(2, "decode", self.relief, self.tif, "--bytes", -5, says="at least 1")
        self.refuse(2, "decode", self.relief, self.path("new.frob"), says=("new.frob", ".tif"))
        self.refuse(1, "decode", self.relief, self.tif, "--bytes", 100, says="bytes")

    def test_eval_options(self):
        self.refuse(2, "eval", self.relief, says="--at")
        for place in ("1", "x,y", "1,", "nan,1", "inf,0"):
            self.refuse(2, "eval", self.relief, "--at", place, says=("X,Y", place))
        self.refuse(2, "eval", self.relief, "--at", "1,2", "--derivatives", 3, says="derivatives")
        with open(self.path("p.csv"), "w", encoding="ascii") as file:
            file.write("x,y\n1,2\n3,north\n")
        self.refuse(1, "eval", self.relief, "--points", self.path("p.csv"),
                    says=("p.csv, line 3", "two numbers"))
        self.refuse(1, "eval", self.relief, "--points", self.path("none.csv"), says="none.csv")

    def test_edit_options(self):
        edit = ("edit", self.relief, self.out)
        self.refuse(2, *edit, says="--move")
        self.refuse(2, *edit, "--move", "3:1", says="--level")
        for move in ("3", "3:", "x:1", "3:1,2", "3:1;2", "3:nan", "3:1e999", "3.5:1"):
            self.refuse(2, *edit, "--level", 1, "--move", move)
        for index in ("-1", "99999999", "99999999999999999999"):
            self.refuse(2, *edit, "--level", 1, f"--move={index}:1", says=index)
        self.refuse(2, *edit, "--level", 60, "--move", "0:1", says="no level 60")
        self.refuse(1, *edit, "--script", self.path("none.json"), says="none.json")

    def test_edit_scripts(self):
        script = self.path("moves.json")
        good = '{"level": 1, "index": 3, "delta": 1}'
        for status, text in (
                (1, "{"), (1, "3"), (1, '{"moves": 3}'), (1, "[3]"), (1, "[{}]"),
                (1, f'[{good}, {{"level": 1, "index": 3}}]'),
                (1, '[{"level": 1, "index": 3, "delta": []}]'),
                (1, '[{"level": 1, "index": 3, "delta": [1, 2]}]'),
                (1, '[{"level": 1, "index": 3, "delta": "1"}]'),
                (1, '[{"level": 1.5, "index": 3, "delta": 1}]'),
                (1, '[{"level": 1, "row": 3, "delta": 1}]'),
                (1, "[" * 200000),
                (1, '[{"level": 1, "index": 3, "delta": ' + "[" * 1000000 + "]" * 1000000 + "}]"),
                (2, '[{"level": 77, "index": 3, "delta": 1}]'),
                (2, '[{"level": 4294967297, "index": 3, "delta": 1}]'),
                (2, '[{"level": 1, "index": -3, "delta": 1}]'),
                (2, '[{"level": 1, "index": 18446744073709551615, "delta": 1}]'),
                (2, '[{"level": 1, "row": 18446744073709551615, "col": 0, "delta": 1}]'),
                (2, '[{"level": 1, "row": 1000, "col": 3, "delta": 1}]'),
                (2, '[{"level": 1, "index": 3, "delta": 1e301}]'),
                (2, "[]")):
            with open(script, "w", encoding="ascii") as file:
                file.write(text)
            with self.subTest(script=text[:60]):
                self.refuse(status, "edit", self.relief, self.out, "--script", script)

    def test_render_options(self):
        png = self.path("a.png")
        self.refuse(2, "render", self.dem, png, "--style", "error", says="--reference")
        self.refuse(2, "render", self.dem, png, "--level", 1, says="--level needs a .relief")
        self.refuse(2, "render", self.relief, png, "--level", 77, says="no level 77")
        self.refuse(2, "render", self.relief, png, "--level", -1, says="level")
        small = self.raster("small.tif", hills(9, 8).astype("int16"))
        self.refuse(1, "render", self.relief, png, "--style", "error", "--reference", small,
                    says=("small.tif", "8 x 9"))
        self.refuse(1, "render", self.relief, png, "--drape", self.dem, says="dem.tif")
        self.refuse(1, "render", self.relief, png, "--drape", self.path("no.png"), says="no.png")

    def test_sample_options(self):
        for size in (0, 1, -5, 99999999):
            self.refuse(2, "sample", "franke", self.tif, f"--size={size}", says=str(size))
        self.refuse(2, "sample", "franke", self.path("a.frob"), says=".tif")

    def test_surface_distance_is_for_meshes(self):
        self.refuse(2, "compare", self.dem, self.dem, "--surface", says="meshes")


if __name__ == "__main__":
    main()
