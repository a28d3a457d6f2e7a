"""edit: a moved coefficient adds its box spline and nothing else; the details stay."""

import json

import numpy as np

from harness import NORTH_UP, Case, hills, main, read_raster, samples

DIRECTIONS = ((1, 0), (0, 1), (-1, -1))
EDIT_KEYS = "moved touched bounds edits bytes".split()


def convolved(values, taps):
    """The convolution of two centred arrays of odd size."""
    rows = [a + b - 1 for a, b in zip(values.shape, taps.shape)]
    result = np.zeros(rows)
    for (i, j), tap in np.ndenumerate(taps):
        result[i:i + values.shape[0], j:j + values.shape[1]] += tap * values
    return result


def box_spline(order, level):
    """M_ddd(2^-level .) at the integers, centred: subdivision of an impulse, then values.

    The refinement mask is 4 (prod (1 + z_k) / 2)^d over the three directions; M_111 is 1 at 0,
    M_222 1/2 at 0 and 1/12 at its six neighbours."""
    taps = np.array([[4.0]])
    for di, dj in DIRECTIONS * order:
        step = np.zeros((3, 3))
        step[1, 1] = 0.5
        step[1 + di, 1 + dj] = 0.5
        taps = convolved(taps, step)  # centred as a whole: the directions sum to 0
    values = np.array([[1.0]])
    for _ in range(level):
        up = np.zeros([2 * n - 1 for n in values.shape])
        up[::2, ::2] = values
        values = convolved(up, taps)
    if order == 2:
        at_integers = np.zeros((3, 3))
        at_integers[1, 1] = 1 / 2
        for di, dj in DIRECTIONS:
            at_integers[1 + di, 1 + dj] = at_integers[1 - di, 1 - dj] = 1 / 12
        values = convolved(values, at_integers)
    return values


def placed(spline, shape, row, col):
    """The spline around (row, col) on zeros."""
    field = np.zeros(shape)
    for (i, j), value in np.ndenumerate(spline):
        r, c = row + i - spline.shape[0] // 2, col + j - spline.shape[1] // 2
        if 0 <= r < shape[0] and 0 <= c < shape[1]:
            field[r, c] = value
    return field


class Edit(Case):
    def control_index(self, file, level, row, col):
        """The index of the control coefficient at lattice point (row, col) of a level."""
        net = self.json("info", file)["level_list"][level]
        row0, col0 = net["control_origin"]
        return (row - row0) * net["control_cols"] + col - col0

    def edited(self, file, *options, name="edited.relief"):
        target = self.path(name)
        report = self.json("edit", file, target, *options)
        self.assertEqual(list(report), EDIT_KEYS)
        return target, report


class Support(Edit):
    def test_one_move_is_one_box_spline(self):
        # Lattice points strictly inside M_ddd scaled by 2^level: 3 n (n - 1) + 1 with n = d 2^level.
        expected = {1: (7, 37, 169), 2: (37, 169, 721)}
        values = hills(90, 100)
        dem = self.raster("dem.tif", values, transform=NORTH_UP)
        for scheme in ("box", "barycentric"):
            for order in (1, 2):
                file, _ = self.encoded(dem, "--scheme", scheme, "--order", order, "--levels", 3)
                before, _ = self.decoded(file)
                for level in (1, 2, 3):
                    row, col = 40 >> level, 56 >> level
                    index = self.control_index(file, level, row, col)
                    target, report = self.edited(file, "--level", level, "--move", f"{index}:-80")
                    after, _ = self.decoded(target)
                    spline = placed(box_spline(order, level), values.shape, row << level,
                                    col << level)
                    with self.subTest(scheme=scheme, order=order, level=level):
                        self.assertEqual(report["touched"], expected[order][level - 1])
                        self.assertTrue(np.array_equal(after != before, spline != 0))
                        # Sums of heights of 400: a few roundings of 2^-44.
                        np.testing.assert_allclose(after - before, -80 * spline, atol=1e-12 * 400)
                        rows, cols = np.nonzero(spline)
                        self.assertEqual(report["bounds"], {
                            "col": cols.min(), "row": rows.min(),
                            "width": cols.max() - cols.min() + 1,
                            "height": rows.max() - rows.min() + 1})
                        self.assertEqual((report["moved"], report["edits"]), (1, 1))

    def test_moves_at_the_border_are_clipped(self):
        dem = self.raster("dem.tif", hills(40, 50))
        file, _ = self.encoded(dem, "--levels", 3)
        before, _ = self.decoded(file)
        for row, col in ((0, 0), (0, 6), (5, 6)):
            index = self.control_index(file, 3, row, col)
            target, report = self.edited(file, "--level", 3, "--move", f"{index}:50")
            after, _ = self.decoded(target)
            changed = np.argwhere(after != before)
            self.assertEqual(report["touched"], len(changed))
            low, high = changed.min(axis=0), changed.max(axis=0)
            box = report["bounds"]
            self.assertLessEqual(box["row"], low[0])
            self.assertLessEqual(box["col"], low[1])
            self.assertGreaterEqual(box["row"] + box["height"] - 1, high[0])
            self.assertGreaterEqual(box["col"] + box["width"] - 1, high[1])
            self.assertLessEqual(box["row"] + box["height"], 40)
            self.assertLessEqual(box["col"] + box["width"], 50)

    def test_level_zero_is_the_finest_net(self):
        values = hills(20, 20)
        file, _ = self.encoded(self.raster("dem.tif", values), "--order", 1)
        target, report = self.edited(file, "--level", 0, "--move", f"{5 * 20 + 7}:3.5")
        expected = values.copy()
        expected[5, 7] += 3.5
        after, _ = self.decoded(target)
        self.assertEqual(report["touched"], 1)
        np.testing.assert_allclose(after, expected, atol=1e-12)


class Layers(Edit):
    def setUp(self):
        super().setUp()
        self.values = np.rint(hills(61, 75)).astype("int16")
        self.dem = self.raster("dem.tif", self.values, transform=NORTH_UP)
        self.file, _ = self.encoded(self.dem, "--max-error", 2)

    def test_edit_and_its_inverse(self):
        once, _ = self.edited(self.file, "--level", 2, "--move", "100:30", "--move", "140:-7.25")
        back, report = self.edited(once, "--level", 2, "--move", "140:7.25", "--move", "100:-30",
                                   name="back.relief")
        self.assertEqual((report["moved"], report["edits"]), (2, 4))
        self.assertTrue(np.array_equal(self.decoded(back)[0], self.decoded(self.file)[0]))
        self.assertGreater(np.max(np.abs(self.decoded(once)[0] - self.values)), 10)

    def test_chains_add_up(self):
        both, _ = self.edited(self.file, "--level", 3, "--move", "20:40", "--move", "21:30",
                              name="both.relief")
        first, _ = self.edited(self.file, "--level", 3, "--move", "20:40", name="first.relief")
        second, _ = self.edited(first, "--level", 3, "--move", "21:30", name="second.relief")
        with open(both, "rb") as a, open(second, "rb") as b:
            self.assertEqual(a.read(), b.read())
        twice, _ = self.edited(self.file, "--level", 3, "--move", "20:20", "--move", "20:20")
        np.testing.assert_array_equal(self.decoded(twice)[0], self.decoded(first)[0])

    def test_over_itself(self):
        expected, _ = self.edited(self.file, "--level", 1, "--move", "20:40")
        self.edited(self.file, "--level", 1, "--move", "20:40", name="out.relief")
        with open(expected, "rb") as a, open(self.file, "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_scripts_by_index_and_by_place(self):
        row, col = 7, 9
        index = self.control_index(self.file, 2, row, col)
        expected, _ = self.edited(self.file, "--level", 2, "--move", f"{index}:12.5")
        script = self.path("moves.json")
        moves = ({"level": 2, "index": index, "delta": 12.5},
                 {"level": 2, "row": row, "col": col, "delta": [12.5]})
        for move in moves:
            for content in ([move], {"moves": [move]}):
                with open(script, "w", encoding="ascii") as file:
                    json.dump(content, file)
                target, _ = self.edited(self.file, "--script", script, name="script.relief")
                with open(expected, "rb") as a, open(target, "rb") as b:
                    self.assertEqual(a.read(), b.read())

    def test_moves_and_script_together(self):
        script = self.path("moves.json")
        with open(script, "w", encoding="ascii") as file:
            json.dump([{"level": 0, "row": 3, "col": 4, "delta": 9}], file)
        _, report = self.edited(self.file, "--level", 1, "--move", "5:1", "--script", script)
        self.assertEqual(report["moved"], 2)

    def test_edited_files_are_whole(self):
        target, report = self.edited(self.file, "--level", 2, "--move", "100:30")
        info = self.json("info", target)
        self.assertTrue(info["checksums_ok"])
        self.assertEqual(info["bytes"], report["bytes"])
        self.assertIsNone(info["bound"])
        self.assertIn("edits", [chunk["kind"] for chunk in info["chunks"]])
        # The coded data is that of before.
        strip = [chunk for chunk in info["chunks"] if chunk["kind"] != "edits"]
        self.assertEqual(strip, self.json("info", self.file)["chunks"])
        self.assertIn("edited by 1 move\n", self.text("info", target))

    def test_details_follow_on_every_level(self):
        target, _ = self.edited(self.file, "--level", 4, "--move", "9:200")
        for level in (0, 1, 2):
            change = (self.decoded(target, "--level", level)[0]
                      - self.decoded(self.file, "--level", level)[0])
            self.assertGreater(np.max(change), 80)
        # A move of details is not seen on coarser levels.
        fine, _ = self.edited(self.file, "--level", 1, "--move", "9:200")
        np.testing.assert_array_equal(self.decoded(fine, "--level", 2)[0],
                                      self.decoded(self.file, "--level", 2)[0])

    def test_evaluation_and_pictures_see_the_edit(self):
        index = self.control_index(self.file, 2, 7, 9)
        target, _ = self.edited(self.file, "--level", 2, "--move", f"{index}:100")
        x, y = 400000 + 30 * 36.5, 5200000 - 30 * 28.5
        before, after = (self.json("eval", file, "--at", f"{x},{y}")["values"][0][0]
                         for file in (self.file, target))
        # The function of a control coefficient is 1 there, and its level's other points do not move.
        self.assertAlmostEqual(after - before, 100, delta=1e-9)
        self.json("render", target, self.path("a.png"))

    def test_holes_stay(self):
        values = self.values.copy()
        values[20:40, 20:40] = -1
        dem = self.raster("hole.tif", values, nodata=-1)
        file, _ = self.encoded(dem, "--max-error", 1)
        target, _ = self.edited(file, "--level", 2, "--move", "100:30")
        self.json("decode", target, self.path("out.tif"))
        self.assertTrue(np.array_equal(read_raster(self.path("out.tif")).mask, values != -1))

    def test_values_stay_in_their_type(self):
        dem = self.raster("byte.tif", np.full((30, 30), 200, "uint8"))
        file, _ = self.encoded(dem)
        up, _ = self.edited(file, "--level", 2, "--move", "20:1e300")
        self.json("decode", up, self.path("out.tif"))
        self.assertEqual(samples(self.path("out.tif")).max(), 255)


class Commands(Edit):
    """Scripts of the editor's commands."""

    def script(self, commands):
        path = self.path("script.json")
        with open(path, "w", encoding="ascii") as file:
            json.dump(commands, file)
        return path

    def assert_same_file(self, one, other):
        with open(one, "rb") as a, open(other, "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_rasters(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(61, 75), transform=NORTH_UP))
        expected, _ = self.edited(file, "--level", 2, "--move", "100:30", "--move", "101:30")
        move = {"do": "move", "level": 2, "points": [100, 101], "delta": 30}
        undone = [move, {"do": "move", "level": 0, "points": [5], "delta": 1},
                  {"do": "drag", "of": "move", "level": 0, "points": [6], "delta": 1},
                  {"do": "undo"}]
        for commands in ([move], {"commands": [move]}, undone):
            target, report = self.edited(file, "--script", self.script(commands),
                                         name="script.relief")
            self.assert_same_file(expected, target)
            self.assertEqual((report["moved"], report["edits"]), (2, 2))
        self.refuse(2, "edit", file, self.path("new.relief"), "--script", self.script([move]),
                    "--level", 1, "--move", "3:1", says="together")
        self.refuse(2, "edit", file, self.path("new.relief"), "--script",
                    self.script([move, {"do": "move", "level": 40, "points": [1], "delta": 1}]),
                    says=("script.json", "command 2", "no level 40"))

    def test_falloff_is_measured_in_the_unit_of_heights(self):
        # Samples of 30 m beside heights in feet: 98.4 ft apart.
        values = hills(33, 33)
        dem = self.raster("dem.tif", values, transform=NORTH_UP, epsg=26911, unit="ft")
        file, _ = self.encoded(dem, "--order", 1)
        move = {"do": "move", "level": 0, "points": [16 * 33 + 16], "delta": 8,
                "falloff": {"radius": 200, "profile": "linear"}}
        target, _ = self.edited(file, "--script", self.script([move]))
        i, j = np.mgrid[0:33, 0:33]
        distance = np.hypot(i - 16, j - 16) * 30 / 0.3048
        rise = self.decoded(target)[0] - self.decoded(file)[0]
        # UTM changes lengths by less than a thousandth of them, which is taken as it is.
        np.testing.assert_allclose(rise, 8 * np.maximum(0, 1 - distance / 200), atol=1e-9)

    def test_quads(self):
        mesh = self.path("mesh.off")
        places = [(c, r, np.sin(c) * np.cos(r)) for r in range(9) for c in range(9)]
        quads = [(v, v + 1, v + 10, v + 9) for v in (9 * r + c for r in range(8) for c in range(8))]
        with open(mesh, "w", encoding="ascii") as out:
            out.write(f"OFF\n{len(places)} {len(quads)} 0\n")
            out.writelines("{!r} {!r} {!r}\n".format(*map(float, place)) for place in places)
            out.writelines("4 {} {} {} {}\n".format(*quad) for quad in quads)
        file = self.path("mesh.relief")
        self.json("encode", mesh, file)
        expected, by_move = self.edited(file, "--level", 1, "--move", "7:2.5")
        commands = [{"do": "move", "level": 1, "points": [7], "delta": [0, 0, 2.5]}]
        target, report = self.edited(file, "--script", self.script(commands), name="script.relief")
        self.assert_same_file(expected, target)
        self.assertEqual(report, by_move)
        self.refuse(2, "edit", file, self.path("new.relief"), "--script",
                    self.script([{"do": "tilt", "level": 1, "points": [7], "slope": [1, 0]}]),
                    says="no slope")
        self.refuse(1, "edit", file, self.path("new.relief"), "--script",
                    self.script([{"level": 1, "index": 3, "delta": 1}]), says="commands")

    def test_triangles(self):
        points = self.path("points.csv")
        rng = np.random.default_rng(3)
        with open(points, "w", encoding="ascii") as out:
            out.writelines("{!r},{!r},{!r}\n".format(*map(float, (x, y, np.sin(x * y))))
                           for x, y in rng.uniform(0, 3, (60, 2)))
        file = self.path("points.relief")
        self.json("fit", points, file)
        expected, by_move = self.edited(file, "--level", 0, "--move", "7:2.5", "--move",
                                        "9:0,1,-0.5")
        commands = [{"do": "move", "level": 0, "points": [7], "delta": 2.5},
                    {"do": "tilt", "level": 0, "points": [9], "slope": [1, -0.5]}]
        target, report = self.edited(file, "--script", self.script({"commands": commands}),
                                     name="script.relief")
        self.assert_same_file(expected, target)
        self.assertEqual(report, by_move)


class Parametric(Edit):
    def test_components_move_apart(self):
        planes = [hills(40, 44, seed) for seed in (1, 2, 3)]
        file, _ = self.encoded(self.raster("s.tif", planes), "--levels", 3)
        index = self.control_index(file, 2, 5, 6)
        target, report = self.edited(file, "--level", 2, "--move", f"{index}:1,0,-4")
        self.json("decode", target, self.path("out.tif"))
        spline = placed(box_spline(2, 2), (40, 44), 20, 24)
        self.assertEqual(report["touched"], 169)
        for delta, before, after in zip((1, 0, -4), planes,
                                        read_raster(self.path("out.tif")).planes):
            np.testing.assert_allclose(after - before, delta * spline, atol=1e-11)
        self.refuse(2, "edit", file, self.path("new.relief"), "--level", 2, "--move",
                    f"{index}:1,0,-4,2", says=("4 components", "has 3"))


if __name__ == "__main__":
    main()
