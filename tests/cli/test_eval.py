"""eval: the surface between the samples, its derivatives in data units, and CSV in and out."""

import csv
import io

import numpy as np

from harness import NORTH_UP, ROTATED, Case, finite, hills, main

MAPS = {"north up": NORTH_UP, "rotated": ROTATED, "none": None,
        "degrees": (10.0, 0.001, 0.0, 50.0, 0.0, -0.002)}


def centre(transform, row, col):
    """The place of a sample; without a transform its column and row."""
    if transform is None:
        return float(col), float(row)
    t = transform
    return (t[0] + t[1] * (col + 0.5) + t[2] * (row + 0.5),
            t[3] + t[4] * (col + 0.5) + t[5] * (row + 0.5))


def rows_of(text):
    return list(csv.reader(io.StringIO(text)))


class Values(Case):
    def evaluate(self, file, points, derivatives=0):
        """Rows of floats, NaN for empty fields."""
        path = self.path("points.csv")
        with open(path, "w", encoding="ascii") as out:
            out.writelines(f"{float(x)!r},{float(y)!r}\n" for x, y in points)
        rows = rows_of(self.text("eval", file, "--points", path, "--derivatives", derivatives))
        self.assertEqual(len(rows), len(points) + 1)
        self.assertEqual(rows[0][:3], ["x", "y", "value"])
        return np.array([[float(field or "nan") for field in row[2:]] for row in rows[1:]])

    def test_sample_centres_give_the_decoded_raster(self):
        values = hills(33, 41)
        for dtype, goal, tolerance in (
                # Lossless: the surface interpolates; solving costs a few roundings of 400.
                ("float64", ("--lossless",), 1e-9), ("float64", ("--max-error", 0.5), 1e-9),
                # Integers are rounded after the surface.
                ("int16", ("--max-error", 3), 0.5), ("int16", ("--rms-error", 3), 0.5),
                ("float64", ("--lossless", "--scheme", "cubic"), 1e-9),
                ("int16", ("--rms-error", 3, "--scheme", "cubic"), 0.5)):
            for name, transform in MAPS.items():
                with self.subTest(dtype=dtype, goal=goal, map=name):
                    dem = self.raster("dem.tif", values.astype(dtype), transform=transform)
                    order = 1 if name == "degrees" and "cubic" not in goal else 2
                    file, _ = self.encoded(dem, *goal, "--order", order)
                    decoded, _ = self.decoded(file)
                    cells = [(r, c) for r in range(0, 33, 4) for c in range(0, 41, 5)]
                    found = self.evaluate(file, [centre(transform, r, c) for r, c in cells])
                    expected = np.array([decoded[r, c] for r, c in cells])
                    self.assertLessEqual(np.max(np.abs(found[:, 0] - expected)), tolerance + 1e-9)

    def test_plane_is_exact_everywhere(self):
        for transform in (NORTH_UP, ROTATED):
            t = transform
            i, j = np.mgrid[0:20, 0:24] + 0.5
            x, y = t[0] + t[1] * j + t[2] * i, t[3] + t[4] * j + t[5] * i
            dem = self.raster("dem.tif", 5 + 0.02 * (x - t[0]) - 0.03 * (y - t[3]),
                              transform=transform)
            rng = np.random.default_rng(2)
            for scheme in (("box", 1), ("box", 2), ("barycentric", 4)):
                file, _ = self.encoded(dem, "--scheme", scheme[0], "--order", scheme[1])
                # High orders extrapolate their border from a few coefficients: stay inside.
                points = [centre(transform, r, c) for r, c in
                          rng.uniform((4, 4), (15, 19), (40, 2))]
                found = self.evaluate(file, points, 2)
                expected = [5 + 0.02 * (px - t[0]) - 0.03 * (py - t[3]) for px, py in points]
                np.testing.assert_allclose(found[:, 0], expected, atol=2e-8)
                np.testing.assert_allclose(found[:, 1], 0.02, atol=1e-8)
                np.testing.assert_allclose(found[:, 2], -0.03, atol=1e-8)
                np.testing.assert_allclose(found[:, 3:], 0, atol=1e-8)

    def test_derivatives_are_those_of_the_values(self):
        for name, transform in MAPS.items():
            dem = self.raster("dem.tif", hills(25, 30), transform=transform)
            file, _ = self.encoded(dem, "--rms-error", 0.5)
            t = transform or (0, 1, 0, 0, 0, 1)
            # A thousandth of a cell: second differences of a quartic are then good to 1e-5 of
            # its curvature, and lose about 1e-16 * 400 / 1e-6 to rounding.
            cell = np.sqrt(abs(t[1] * t[5] - t[2] * t[4]))
            h = 1e-3 * cell
            rng = np.random.default_rng(4)
            points = [centre(transform, r, c) for r, c in rng.uniform(2, 22, (25, 2))]
            around = [(px + u * h, py + v * h) for px, py in points
                      for u in (-1, 0, 1) for v in (-1, 0, 1)]
            z = self.evaluate(file, around)[:, 0].reshape(-1, 3, 3)  # [point, x, y]
            jets = self.evaluate(file, points, 2)
            gradient = self.evaluate(file, points, 1)
            np.testing.assert_array_equal(gradient, jets[:, :3])
            expected = np.array([
                z[:, 1, 1], (z[:, 2, 1] - z[:, 0, 1]) / (2 * h), (z[:, 1, 2] - z[:, 1, 0]) / (2 * h),
                (z[:, 2, 1] - 2 * z[:, 1, 1] + z[:, 0, 1]) / h**2,
                (z[:, 2, 2] - z[:, 2, 0] - z[:, 0, 2] + z[:, 0, 0]) / (4 * h**2),
                (z[:, 1, 2] - 2 * z[:, 1, 1] + z[:, 1, 0]) / h**2]).T
            with self.subTest(map=name):
                np.testing.assert_array_equal(jets[:, 0], expected[:, 0])
                np.testing.assert_allclose(jets[:, 1:3] * cell, expected[:, 1:3] * cell, atol=1e-3)
                np.testing.assert_allclose(jets[:, 3:] * cell**2, expected[:, 3:] * cell**2,
                                           atol=0.1, rtol=0.02)

    def test_three_components(self):
        planes = [hills(20, 22, seed) for seed in (1, 2, 3)]
        dem = self.raster("dem.tif", planes)
        file, _ = self.encoded(dem)
        rows = rows_of(self.text("eval", file, "--at", "7,5", "--derivatives", 1))
        self.assertEqual(rows[0], "x,y,value1,dx1,dy1,value2,dx2,dy2,value3,dx3,dy3".split(","))
        found = [float(rows[1][k]) for k in (2, 5, 8)]
        np.testing.assert_allclose(found, [plane[5, 7] for plane in planes], atol=1e-9)


class Places(Case):
    def setUp(self):
        super().setUp()
        values = hills(20, 30)
        values[8:12, 10:16] = -1
        self.dem = self.raster("dem.tif", values, nodata=-1, transform=NORTH_UP)
        self.file, _ = self.encoded(self.dem)

    def test_outside_and_holes_are_empty(self):
        corner = centre(NORTH_UP, 0, 0)
        last = centre(NORTH_UP, 19, 29)
        inside = [corner, last, (corner[0] + 1e-9, corner[1] - 1e-9)]
        outside = [(corner[0] - 1, corner[1]), (last[0], last[1] - 1), (0, 0), (1e300, -1e300),
                   centre(NORTH_UP, 10, 12), centre(NORTH_UP, 8, 15)]
        arguments = [f"--at={x!r},{y!r}" for x, y in inside + outside]
        rows = rows_of(self.text("eval", self.file, *arguments, "--derivatives", 2))[1:]
        for row in rows[:3]:
            self.assertTrue(all(row), row)
        for row in rows[3:]:
            self.assertEqual(row[2:], [""] * 6)
        report = self.json("eval", self.file, *arguments)
        self.assertEqual((report["points"], report["outside"]), (9, 6))
        self.assertTrue(finite(report["seconds"]))
        self.assertEqual([value[0] is None for value in report["values"]],
                         [False] * 3 + [True] * 6)
        self.assertEqual([row[2] for row in rows[:3]],
                         [repr(value[0]).removesuffix(".0") for value in report["values"][:3]])

    def test_forms_of_csv(self):
        x, y = centre(NORTH_UP, 5, 6)
        plain = self.text("eval", self.file, "--at", f"{x},{y}").splitlines()[1]
        path = self.path("points.csv")
        for text in (f"{x},{y}\n", f"{x},{y}", f"x,y\n{x},{y}\n", f"East;North\r\n{x};{y}\r\n",
                     f"{x} {y} 77 name\n", f"{x}\t{y}\n", f"# survey\n\n{x}, {y}\n\n",
                     f"\ufeffx,y\n{x},{y}\n", f"\ufeff{x},{y}\n", f"+{x},+{y}\n",
                     f"{x:.6e},{y:.6e}\n", f"\"{x}\",\"{y}\"\n"):
            with open(path, "w", encoding="utf-8", newline="") as file:
                file.write(text)
            with self.subTest(text=text):
                lines = self.text("eval", self.file, "--points", path).splitlines()
                self.assertEqual(lines, ["x,y,value", plain])
                self.assertEqual(self.text("eval", self.file, "--points", path,
                                           "-q").splitlines(), lines)

    def test_lines_that_only_look_like_places(self):
        path = self.path("points.csv")
        for text in ("400100,5;5199900,5\n", "1,5;2,5\n", "400100,north\n", "x,y\n1,2\nx,y\n",
                     "x,y\n1 2,3\n", "400100\n", "1e999,2\n", "nan,2\n1,2\nnan,3\n", "1..5,2\n"):
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            with self.subTest(text=text):
                self.refuse(1, "eval", self.file, "--points", path, says="points.csv, line ")

    def test_empty_file_of_points(self):
        path = self.path("points.csv")
        open(path, "wb").close()
        self.assertEqual(self.text("eval", self.file, "--points", path), "x,y,value\n")

    def test_output_file(self):
        target = self.path("out.csv")
        report = self.json("eval", self.file, "--at", "400100,5199900", "--output", target)
        self.assertNotIn("values", report)
        with open(target, encoding="ascii") as file:
            self.assertEqual(file.read(),
                             self.text("eval", self.file, "--at", "400100,5199900"))

    def test_many_points(self):
        rng = np.random.default_rng(1)
        path = self.path("points.csv")
        count = 100000
        x = rng.uniform(400000, 400900, count)
        y = rng.uniform(5199400, 5200000, count)
        np.savetxt(path, np.column_stack((x, y)), delimiter=",")
        report = self.json("eval", self.file, "--points", path, "--derivatives", 2, "--output",
                           self.path("out.csv"))
        self.assertEqual(report["points"], count)
        table = np.genfromtxt(self.path("out.csv"), delimiter=",", skip_header=1)
        np.testing.assert_array_equal(table[:, 0], x)
        self.assertEqual(np.isnan(table[:, 2]).sum(), report["outside"])
        for k in (0, 777, 99999):
            one = rows_of(self.text("eval", self.file, f"--at={x[k]!r},{y[k]!r}",
                                    "--derivatives", 2))[1]
            np.testing.assert_array_equal([float(v or "nan") for v in one[2:]], table[k, 2:])

    def test_singular_transforms(self):
        dem = self.raster("flat.tif", hills(9, 9), transform=(5.0, 1.0, 1.0, 7.0, 2.0, 2.0))
        file, _ = self.encoded(dem, name="flat.relief")
        self.refuse(1, "eval", file, "--at", "6,8", says=("flat.relief", "transform"))


if __name__ == "__main__":
    main()
