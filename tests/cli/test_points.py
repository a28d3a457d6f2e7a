"""Scattered points as surfaces: fit, encode, decode, eval, info, compare, edit and render, end to end."""

import csv
import io
import json
import os
import struct
import xml.etree.ElementTree as ElementTree

import numpy as np

from harness import DATA, Case, contents_of, main, read_raster, samples

FIT_KEYS = ("points scheme order levels samples coefficients kept bytes bits_per_sample max_error rms_error "
            "energy_percent bound vertices triangles delaunay base_bytes surface_bound smoothing energy merged outside "
            "beyond reason seconds").split()


def quadratic(x, y):
    """Splines reproduce it, and its gradients are estimated exactly."""
    return 3 + 0.5 * x - 2 * y + 0.25 * x * x + 0.75 * x * y - 0.5 * y * y


def quadratic_jet(x, y):
    return [quadratic(x, y), 0.5 + 0.5 * x + 0.75 * y, -2 + 0.75 * x - y, 0.5, 0.75, -1]


def wavy(x, y):
    return 10 * np.sin(0.7 * x) * np.cos(0.5 * y) + 0.3 * x


def scattered(count, height, size=(6.0, 5.0), seed=1, noise=0.0):
    """Points in a rectangle, its corners among them."""
    rng = np.random.default_rng(seed)
    places = rng.uniform((0, 0), size, (count, 2))
    places[:4] = [(0, 0), (size[0], 0), size, (0, size[1])]
    values = np.array([height(x, y) for x, y in places])
    return np.column_stack([places, values + rng.normal(0, noise, count)])


def rows_of(path):
    with open(path, encoding="ascii", newline="") as file:
        return list(csv.reader(file))


class Points(Case):
    def points(self, rows, name="points.xyz", heading="", separator=" "):
        path = self.path(name)
        with open(path, "w", encoding="ascii") as file:
            file.write(heading)
            file.writelines(separator.join(repr(float(n)) for n in row) + "\n" for row in rows)
        return path

    def fitted(self, source, *options, name="fit.relief"):
        return self.path(name), self.json("fit", source, self.path(name), *options)

    def evaluated(self, file, places, derivatives=0):
        """Rows of floats, NaN for empty fields."""
        target = self.path("places.csv")
        with open(target, "w", encoding="ascii") as out:
            out.writelines(f"{float(x)!r},{float(y)!r}\n" for x, y in places)
        rows = list(csv.reader(io.StringIO(
            self.text("eval", file, "--points", target, "--derivatives", derivatives))))
        return np.array([[float(field or "nan") for field in row[2:]] for row in rows[1:]])

    def errors(self, file, rows):
        return np.abs(self.evaluated(file, rows[:, :2])[:, 0] - rows[:, 2])


class Interpolation(Points):
    def test_the_surface_passes_through_all_points(self):
        rows = scattered(500, wavy)
        file, report = self.fitted(self.points(rows))
        self.assertEqual(list(report), FIT_KEYS)
        self.assertEqual((report["points"], report["vertices"], report["levels"]), (500, 500, 0))
        self.assertEqual((report["scheme"], report["delaunay"]), ("powell-sabin", True))
        self.assertEqual((report["merged"], report["outside"], report["beyond"], report["reason"]), (0, 0, 0, ""))
        self.assertIsNone(report["smoothing"])
        self.assertIsNone(report["energy"])
        # Vertices lie on a lattice with 2^-50 of the extent; slopes are at most 10.
        self.assertLess(np.max(self.errors(file, rows)), 1e-12)
        self.assertLess(report["max_error"], 1e-12)
        self.assertEqual(report["bytes"], os.path.getsize(file))

    def test_quadratics_are_exact_between_points_too(self):
        file, _ = self.fitted(self.points(scattered(200, quadratic)))
        places = [(0.3, 0.4), (2.71, 3.14), (5.9, 4.2), (3, 2)]
        found = self.evaluated(file, places, 2)
        expected = [quadratic_jet(x, y) for x, y in places]
        # Values up to 20 on triangles of size 0.4; second derivatives lose two digits and more.
        np.testing.assert_allclose(found[:, :3], np.array(expected)[:, :3], atol=1e-10)
        np.testing.assert_allclose(found[:, 3:], np.array(expected)[:, 3:], atol=1e-8)

    def test_order_of_points_does_not_matter(self):
        rows = scattered(300, wavy)
        files = [contents_of(self.fitted(self.points(order), name=f"{k}.relief")[0])
                 for k, order in enumerate((rows, rows[::-1]))]
        self.assertEqual(files[0], files[1])

    def test_points_at_one_place_give_their_mean(self):
        rows = scattered(100, quadratic)
        twice = rows[[10, 20]] + [0, 0, 4]
        file, report = self.fitted(self.points(np.vstack([rows, twice])))
        self.assertEqual((report["points"], report["vertices"], report["merged"]), (102, 100, 2))
        self.assertAlmostEqual(report["max_error"], 2, delta=1e-12)
        found = self.evaluated(file, rows[[10, 20, 30], :2])[:, 0]
        np.testing.assert_allclose(found, rows[[10, 20, 30], 2] + [2, 2, 0], atol=1e-12)
        self.assertIn("2 points lie where others do", self.text("fit", self.path("points.xyz"), file))
        weights = np.ones((102, 1))
        weights[10] = 3
        weighted = self.points(np.hstack([np.vstack([rows, twice]), weights]), "weighted.csv", "x,y,z,weight\n", ",")
        found = self.evaluated(self.fitted(weighted)[0], rows[[10, 20], :2])[:, 0]
        np.testing.assert_allclose(found, rows[[10, 20], 2] + [1, 2], atol=1e-12)

    def test_gradient_rules(self):
        rows = scattered(400, wavy)
        source = self.points(rows)
        places = np.random.default_rng(3).uniform((0.5, 0.5), (5.5, 4.5), (500, 2))
        truth = wavy(places[:, 0], places[:, 1])
        rms = {}
        for rule in ("adaptive", "quadratic", "plane", "zero"):
            file, _ = self.fitted(source, "--gradients", rule)
            self.assertLess(np.max(self.errors(file, rows)), 1e-12)
            rms[rule] = np.sqrt(np.mean(np.square(self.evaluated(file, places)[:, 0] - truth)))
        # Orders of magnitude as in section 12 (b) of the specification.
        self.assertLess(rms["adaptive"], 0.05)
        self.assertLess(rms["adaptive"], rms["quadratic"])
        self.assertLess(rms["quadratic"], rms["plane"])
        self.assertLess(rms["plane"], rms["zero"])

    def test_values_within_a_bound(self):
        rows = scattered(400, wavy)
        source = self.points(rows)
        _, exact = self.fitted(source)
        file, report = self.fitted(source, "--gradients", "adaptive", "--max-error", 0.05)
        self.assertEqual(report["vertices"], 400)
        self.assertLess(report["bytes"], exact["bytes"])
        worst = np.max(self.errors(file, rows))
        self.assertLessEqual(worst, 0.05)
        self.assertAlmostEqual(worst, report["max_error"], delta=1e-12)
        _, rms = self.fitted(source, "--rms-error", 0.05)
        self.assertLessEqual(rms["rms_error"], 0.05)
        self.assertGreater(rms["rms_error"], 0.02)

    def test_encode_takes_points(self):
        rows = scattered(150, wavy)
        source = self.points(rows)
        file, report = self.encoded(source)
        self.assertEqual(list(report), FIT_KEYS)
        self.assertEqual(contents_of(file), contents_of(self.fitted(source, "--lossless")[0]))
        file, _ = self.encoded(source, "--scheme", "powell-sabin", "--max-error", 0.1)
        self.assertLessEqual(np.max(self.errors(file, rows)), 0.1)
        self.refuse(2, "encode", source, self.path("no.relief"), "--scheme", "cubic", says="powell-sabin")

    def test_columns(self):
        rows = scattered(60, quadratic)
        named = self.points(rows[:, [2, 1, 0]], "named.csv", "depth;Lat;LON\n", ";")
        expected = contents_of(self.fitted(self.points(rows))[0])
        self.assertEqual(contents_of(self.fitted(named)[0]), expected)
        self.assertEqual(contents_of(self.fitted(named, "--columns", "lon,lat,depth")[0]), expected)
        self.assertEqual(contents_of(self.fitted(named, "--columns", "3,2,1")[0]), expected)
        out = self.path("no.relief")
        self.refuse(2, "fit", named, out, "--columns", "lon,lat", says="X,Y,VALUE[,WEIGHT]")
        self.refuse(1, "fit", named, out, "--columns", "lon,lat,height", says="height")


class WithinABound(Points):
    def test_every_point_is_within_the_bound(self):
        rows = scattered(3000, wavy)
        source = self.points(rows)
        vertices = []
        for bound in (1, 0.1, 0.01):
            file, report = self.fitted(source, "--max-error", bound)
            worst = np.max(self.errors(file, rows))
            self.assertLessEqual(worst, bound)
            self.assertAlmostEqual(worst, report["max_error"], delta=1e-12)
            self.assertEqual((report["bound"], report["beyond"], report["outside"]), (bound, 0, 0))
            vertices.append(report["vertices"])
        self.assertEqual(vertices, sorted(vertices))
        self.assertLess(vertices[-1], 1500)
        self.assertEqual(report["bytes"], os.path.getsize(file))

    def test_at_most_so_many_vertices_is_told(self):
        rows = scattered(2000, wavy, noise=1)
        source = self.points(rows)
        file, report = self.fitted(source, "--max-error", 0.5, "--vertices", 100)
        self.assertLessEqual(report["vertices"], 100)
        # Points in slivers at the hull may lie outside, where vertices are too few to include them.
        errors = self.errors(file, rows)
        beyond = np.count_nonzero(errors > 0.5)
        self.assertGreaterEqual(report["beyond"], beyond)
        self.assertLessEqual(report["beyond"], beyond + np.count_nonzero(np.isnan(errors)))
        self.assertGreater(report["beyond"], 100)
        self.assertIn("more vertices", report["reason"])
        self.assertIn("not within 0.5", self.text("fit", source, file, "--max-error", 0.5, "--vertices", 100))

    def test_bounds_out_of_reach(self):
        rows = scattered(100, quadratic)
        source = self.points(np.vstack([rows, rows[7] + [0, 0, 4]]))
        out = self.path("no.relief")
        self.refuse(1, "fit", source, out, "--max-error", 1.5,
                    says=(source, "bound_not_reached", "points 7 and 100 lie at the same place"))
        self.assertLessEqual(self.fitted(source, "--max-error", 3)[1]["max_error"], 3)
        noisy = self.points(scattered(500, wavy, noise=1), "noisy.xyz")
        self.refuse(1, "fit", noisy, out, "--vertices", 30, "--rms-error", 0.01, says="bound_not_reached")
        self.refuse(2, "fit", noisy, out, "--max-error", -1)


class LeastSquares(Points):
    def test_noise_is_smoothed(self):
        rows = scattered(4000, wavy, noise=0.5)
        file, report = self.fitted(self.points(rows), "--vertices", 150)
        self.assertLessEqual(report["vertices"], 165)
        self.assertGreaterEqual(report["vertices"], 130)
        self.assertGreater(report["smoothing"], 0)
        # What is left is the noise.
        self.assertAlmostEqual(report["rms_error"], 0.5, delta=0.03)
        truth = wavy(rows[:, 0], rows[:, 1])
        off = self.evaluated(file, rows[:, :2])[:, 0] - truth
        # 450 coefficients take sqrt(450/4000) = 0.34 of the noise; triangles along the sides are large.
        self.assertLess(np.sqrt(np.mean(np.square(off))), 0.5 * 0.5)
        errors = self.errors(file, rows)
        self.assertAlmostEqual(np.sqrt(np.mean(np.square(errors))), report["rms_error"], delta=1e-12)
        self.assertAlmostEqual(np.max(errors), report["max_error"], delta=1e-12)

    def test_what_code_adds_is_little(self):
        source = self.points(scattered(2000, wavy, noise=0.5))
        _, exact = self.fitted(source, "--vertices", 80, "--lossless")
        _, close = self.fitted(source, "--vertices", 80)
        self.assertLessEqual(close["rms_error"], 1.001 * exact["rms_error"])
        self.assertLess(close["bytes"], exact["bytes"] / 2)

    def test_smoothing_given(self):
        source = self.points(scattered(1000, wavy, noise=0.5))
        rms = []
        for smoothing in (1e-9, 1e-5, 1e4):
            _, report = self.fitted(source, "--vertices", 60, "--smoothing", smoothing)
            self.assertEqual(report["smoothing"], smoothing)
            rms.append(report["rms_error"])
        self.assertEqual(rms, sorted(rms))
        # The stiffest surface is nearly the plane through the points.
        rows = scattered(1000, wavy, noise=0.5)
        matrix = np.column_stack([np.ones(1000), rows[:, :2]])
        off = rows[:, 2] - matrix @ np.linalg.lstsq(matrix, rows[:, 2], rcond=None)[0]
        self.assertAlmostEqual(rms[-1], np.sqrt(np.mean(np.square(off))), delta=0.01)

    def test_jumps_leave_quadratics(self):
        source = self.points(scattered(1000, quadratic))
        _, plate = self.fitted(source, "--vertices", 60, "--smoothing", 1)
        file, jumps = self.fitted(source, "--vertices", 60, "--smoothing", 1, "--energy", "jumps")
        self.assertEqual((plate["energy"], jumps["energy"]), ("plate", "jumps"))
        self.assertGreater(plate["max_error"], 1)
        # The condition is about 1e9.
        self.assertLess(jumps["max_error"], 1e-6)
        # Noise of 0.5 around a quadratic: the rest of six numbers of 1000.
        noisy = scattered(1000, quadratic, noise=0.5)
        self.fitted(self.points(noisy, "noisy.xyz"), "--vertices", 60, "--energy", "jumps")
        off = self.evaluated(file, noisy[:, :2])[:, 0] - quadratic(*noisy[:, :2].T)
        self.assertLess(np.sqrt(np.mean(np.square(off))), 0.15)
        _, bounded = self.fitted(source, "--max-error", 0.01, "--energy", "jumps")
        self.assertLessEqual(bounded["max_error"], 0.01)
        self.assertLess(bounded["vertices"], 60)

    def test_on_a_mesh_with_levels(self):
        mesh = self.path("base.off")
        with open(mesh, "w", encoding="ascii") as file:
            file.write("OFF\n5 4 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n2 2 0\n"
                       "3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n")
        rows = scattered(2000, quadratic)
        file, report = self.fitted(self.points(rows), "--mesh", mesh, "--levels", 1, "--smoothing", 0)
        inside = np.count_nonzero((rows[:, 0] <= 4) & (rows[:, 1] <= 4))
        self.assertEqual((report["points"], report["outside"]), (2000, 2000 - inside))
        self.assertEqual((report["vertices"], report["triangles"], report["levels"]), (5, 4, 1))
        # Quadratics are in every such space.
        self.assertLess(report["max_error"], 1e-9)
        info = self.json("info", file)
        # 5 vertices, 4 in the triangles, 2 on each of 8 edges.
        self.assertEqual([level["vertices"] for level in info["level_list"]], [25, 5])
        self.assertEqual([level["triangles"] for level in info["level_list"]], [36, 4])
        coarse = self.path("coarse.csv")
        self.json("decode", file, coarse, "--level", 1)
        found = np.array(rows_of(coarse)[1:], float)
        np.testing.assert_allclose(found[:, :2], [(0, 0), (4, 0), (4, 4), (0, 4), (2, 2)], atol=1e-14)
        np.testing.assert_allclose(found[:, 2:], [quadratic_jet(x, y)[:3] for x, y in found[:, :2]], atol=1e-7)

    def test_options_that_do_not_go_together(self):
        source = self.points(scattered(50, wavy))
        out = self.path("no.relief")
        for options, says in (((("--vertices", 20, "--mesh", "m.obj")), "exclude"),
                              (("--vertices", 2), "at least 3"),
                              (("--levels", 1), "levels need a number of vertices or a mesh"),
                              (("--smoothing", 1), "smoothing and energy need"),
                              (("--energy", "jumps"), "smoothing and energy need"),
                              (("--vertices", 20, "--energy", "none"), "--energy"),
                              (("--vertices", 20, "--smoothing", -1), "from 0 on"),
                              (("--vertices", 20, "--gradients", "zero"), "interpolation"),
                              (("--gradients", "cubic"), "adaptive, quadratic"),
                              (("--vertices", 20, "--levels", 12), "too_many_elements"),
                              (("--max-error", 1, "--rms-error", 1), "--")):
            with self.subTest(options=options):
                self.refuse(2, "fit", source, out, *options, says=says)


class Triangles(Points):
    def mesh(self, rows, triangles, name="mesh.obj"):
        path = self.path(name)
        with open(path, "w", encoding="ascii") as file:
            file.writelines("v {!r} {!r} {!r}\n".format(*map(float, row)) for row in rows)
            file.writelines("f {} {} {}\n".format(*(v + 1 for v in t)) for t in triangles)
        return path

    def test_meshes_over_the_plane(self):
        rows = [(x, y, quadratic(x, y)) for y in range(5) for x in range(6)]
        triangles = [t for r in range(4) for c in range(5) for v in (6 * r + c,)
                     for t in ((v, v + 1, v + 7), (v, v + 7, v + 6)) if (r, c) != (2, 2)]
        source = self.mesh(rows, triangles)
        file, report = self.encoded(source, "--scheme", "powell-sabin")
        self.assertEqual((report["vertices"], report["triangles"], report["max_error"]), (30, 38, 0))
        for name in ("out.obj", "out.off", "out.ply"):
            decoded = self.json("decode", file, self.path(name))
            self.assertEqual((decoded["samples"], decoded["triangles"]), (30, 38))
            same = self.json("compare", source, self.path(name))
            self.assertEqual((same["max_error"], same["faces_differ"]), (0, False))
        found = self.evaluated(file, [(0.5, 0.25), (2.5, 2.5), (3.7, 1.2), (-1, 0)], 1)
        np.testing.assert_allclose(found[[0, 2]], [quadratic_jet(0.5, 0.25)[:3], quadratic_jet(3.7, 1.2)[:3]],
                                   atol=1e-12)
        self.assertTrue(np.isnan(found[[1, 3]]).all())  # in the hole, and outside
        bounded, report = self.encoded(source, "--scheme", "powell-sabin", "--max-error", 0.1)
        self.json("decode", bounded, self.path("bounded.obj"))
        self.assertLessEqual(self.json("compare", source, self.path("bounded.obj"))["max_error"], 0.1)

    def test_bad_meshes(self):
        out = self.path("no.relief")
        folded = self.mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 2), (0, 1, 3)])
        self.refuse(1, "encode", folded, out, "--scheme", "powell-sabin", says=(folded, "inconsistent_orientation"))
        quads = self.path("quads.off")
        with open(quads, "w", encoding="ascii") as file:
            file.write("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
        self.refuse(1, "encode", quads, out, "--scheme", "powell-sabin",
                    says=("not_a_triangle", f"{quads}, polygon 0"))
        self.refuse(2, "encode", folded, out, "--scheme", "powell-sabin", "--levels", 2, says="--levels")


class Parametric(Points):
    """Surfaces in space over the plane of their parameters u and v."""

    @staticmethod
    def ring(u, v):
        """Part of a torus of radii 3 and 1: it stands upright, which no function over x and y does."""
        return np.column_stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)])

    def rows(self, count, noise=0.0):
        places = scattered(count, wavy)[:, :2]
        return np.hstack([places, self.ring(*places.T) + np.random.default_rng(2).normal(0, noise, (count, 3))])

    def setUp(self):
        super().setUp()
        self.data = self.rows(800)
        self.source = self.points(self.data, "ring.csv", "u,v,x,y,z\n", ",")
        self.columns = ("--columns", "u,v,x,y,z")

    def off(self, file, rows):
        return np.linalg.norm(self.evaluated(file, rows[:, :2]) - rows[:, 2:], axis=1)

    def test_through_all_points(self):
        file, report = self.fitted(self.source, *self.columns)
        self.assertEqual((report["points"], report["vertices"], report["samples"]), (800, 800, 2400))
        self.assertLess(np.max(self.off(file, self.data)), 1e-12)
        self.assertEqual(self.json("info", file)["components"], 3)
        # Parameters u, v and the ring between the points; the mesh is 0.2 wide.
        inside = np.random.default_rng(4).uniform((0.3, 0.3), (5.7, 4.7), (500, 2))
        self.assertLess(np.max(self.off(file, np.hstack([inside, self.ring(*inside.T)]))), 0.05)
        same = self.json("compare", self.source, file, *self.columns)
        self.assertLess(same["max_error"], 1e-12)
        self.assertEqual(same["samples"], 2400)
        self.refuse(1, "compare", self.source, file, "--columns", "u,v,x", says=(file, "--columns"))

    def test_columns_by_number_and_weights(self):
        weighted = np.hstack([self.data, np.ones((800, 1))])
        file, _ = self.fitted(self.points(weighted), "--columns", "1,2,3,4,5,6")
        self.assertEqual(contents_of(file), contents_of(self.fitted(self.source, *self.columns)[0]))
        self.refuse(2, "fit", self.source, file, "--columns", "u,v,x,y,z,w,q", says="U,V,X,Y,Z")
        self.refuse(1, "fit", self.source, file, "--columns", "u,v,x,y,q", says="no column is called 'q'")

    def test_bounds(self):
        file, report = self.fitted(self.source, *self.columns, "--max-error", 0.01, "--gradients", "adaptive")
        worst = np.max(np.abs(self.evaluated(file, self.data[:, :2]) - self.data[:, 2:]))
        self.assertLessEqual(worst, 0.01)
        self.assertAlmostEqual(worst, report["max_error"], delta=1e-12)

    def test_vertices_inserted_for_a_bound(self):
        rows = self.rows(2000)
        source = self.points(rows, "many.csv", "u,v,x,y,z\n", ",")
        file, report = self.fitted(source, *self.columns, "--max-error", 0.05)
        worst = np.max(np.abs(self.evaluated(file, rows[:, :2]) - rows[:, 2:]))
        self.assertLessEqual(worst, 0.05)
        self.assertAlmostEqual(worst, report["max_error"], delta=1e-12)
        self.assertLess(report["vertices"], 1000)
        some, fewer = self.fitted(source, *self.columns, "--max-error", 0.05, "--vertices", 150)
        self.assertLessEqual(fewer["vertices"], 150)
        off = np.abs(self.evaluated(some, rows[:, :2]) - rows[:, 2:]).max(axis=1)
        self.assertEqual(fewer["beyond"], np.count_nonzero(off > 0.05))

    def test_least_squares_do_not_depend_on_axes(self):
        rows = self.rows(3000, noise=0.1)
        turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
        turned = np.hstack([rows[:, :2], rows[:, 2:] @ turn])
        inside = np.random.default_rng(4).uniform((0.3, 0.3), (5.7, 4.7), (500, 2))
        found = []
        for name, data in (("a.csv", rows), ("b.csv", turned)):
            file, report = self.fitted(self.points(data, name, "u,v,x,y,z\n", ","), *self.columns,
                                       "--vertices", 300, "--lossless")
            found.append((report["smoothing"], self.evaluated(file, inside)))
        self.assertEqual(found[0][0], found[1][0])
        # Less than the noise, of which 3000 points leave a part.
        self.assertLess(np.sqrt(np.mean(np.square(found[0][1] - self.ring(*inside.T)))), 0.07)
        # The condition of the normal equations times rounding.
        np.testing.assert_allclose(found[0][1] @ turn, found[1][1], atol=1e-9)

    def test_decoded_and_drawn(self):
        file, _ = self.fitted(self.source, *self.columns, "--lossless")
        mesh = self.path("ring.obj")
        self.json("decode", file, mesh)
        with open(mesh, encoding="ascii") as lines:
            words = [line.split() for line in lines]
        vertices = np.array([w[1:] for w in words if w[0] == "v"], float)
        uv = np.array([w[1:] for w in words if w[0] == "vt"], float)
        np.testing.assert_allclose(vertices, self.ring(*uv.T), atol=1e-12)
        self.json("decode", file, self.path("ring.csv2.csv"))
        self.assertEqual(rows_of(self.path("ring.csv2.csv"))[0],
                         "x y value1 dx1 dy1 value2 dx2 dy2 value3 dx3 dy3".split())
        self.json("decode", file, self.path("ring.vtu"))
        points = read_vtu(self.path("ring.vtu"))[1]["points"].reshape(-1, 3)
        # Control points are as near to the ring as triangles are small.
        around = np.hypot(points[:, 0], points[:, 1])
        self.assertLess(np.median(np.abs(np.hypot(around - 3, points[:, 2]) - 1)), 0.02)
        for options in (("--style", "wire"), ("--style", "wire", "--level", 0), ("--style", "surface"), ()):
            picture = self.path("ring.png")
            self.assertEqual(self.json("render", file, picture, "--width", 200, *options)["width"], 200)
        # The same surface of the mesh with its texture coordinates.
        again, report = self.encoded(mesh, "--scheme", "powell-sabin", "--uv")
        self.assertEqual(report["vertices"], 800)
        self.assertLess(np.max(self.off(again, self.data)), 1e-12)

    def test_seams_of_texture_coordinates(self):
        mesh = self.path("seam.obj")
        with open(mesh, "w", encoding="ascii") as file:
            file.write("v 0 0 0\nv 1 0 1\nv 0 1 2\nv 1 1 4\n"
                       "vt 0 0\nvt 1 0\nvt 0 1\nvt 5 0\nvt 5 1\nvt 4 1\n"
                       "f 1/1 2/2 3/3\nf 2/4 4/5 3/6\n")
        file, report = self.encoded(mesh, "--scheme", "powell-sabin", "--uv")
        self.assertEqual((report["vertices"], report["triangles"]), (6, 2))
        found = self.evaluated(file, [(1, 0), (5, 0), (4, 1), (0, 1), (5, 1), (3, 0)])
        np.testing.assert_allclose(found[:5], [(1, 0, 1), (1, 0, 1), (0, 1, 2), (0, 1, 2), (1, 1, 4)], atol=1e-12)
        self.assertTrue(np.isnan(found[5]).all())
        self.refuse(2, "encode", mesh, file, "--uv", says="--uv is for meshes")
        bare = self.path("bare.obj")
        with open(bare, "w", encoding="ascii") as out:
            out.write("v 0 0 0\nv 1 0 1\nv 0 1 2\nf 1 2 3\n")
        self.refuse(1, "encode", bare, file, "--scheme", "powell-sabin", "--uv", says="no texture coordinates")


class Decoding(Points):
    def setUp(self):
        super().setUp()
        self.rows = scattered(300, quadratic)
        self.file, _ = self.fitted(self.points(self.rows))

    def test_rasters(self):
        report = self.json("decode", self.file, self.path("out.tif"), "--cell", 0.1)
        self.assertEqual((report["cols"], report["rows"], report["cell"], report["samples"]), (60, 50, 0.1, 3000))
        raster = read_raster(self.path("out.tif"))
        np.testing.assert_allclose(raster.transform, (0, 0.1, 0, 5, 0, -0.1), atol=1e-12)
        self.assertEqual(raster.type, "Float64")
        values = samples(self.path("out.tif"))
        x, y = np.meshgrid(0.1 * (np.arange(60) + 0.5), 5 - 0.1 * (np.arange(50) + 0.5))
        np.testing.assert_allclose(values, quadratic(x, y), atol=1e-10)

    def test_about_one_cell_a_vertex(self):
        report = self.json("decode", self.file, self.path("out.tif"))
        # sqrt(30 / 300) = 0.316 is rounded down to 0.2.
        self.assertEqual((report["cell"], report["cols"], report["rows"]), (0.2, 30, 25))
        finer = self.json("decode", self.file, self.path("finer.tif"), "--scale", 2)
        self.assertEqual((finer["cell"], finer["cols"], finer["rows"]), (0.1, 60, 50))
        self.json("decode", self.file, self.path("part.tif"), "--scale", 2, "--window", "10,20,7,5")
        part = read_raster(self.path("part.tif"))
        np.testing.assert_allclose(part.transform, (1, 0.1, 0, 3, 0, -0.1), atol=1e-12)
        # Places of samples are counted from the corner: another rounding of coordinates up to 6.
        np.testing.assert_allclose(part.planes[0], read_raster(self.path("finer.tif")).planes[0][20:25, 10:17],
                                   rtol=0, atol=1e-13)

    def test_outside_is_no_data(self):
        rows = np.array([(0, 0, 1), (10, 0, 2), (0, 10, 3)])
        file, _ = self.fitted(self.points(rows))
        self.json("decode", file, self.path("out.tif"), "--cell", 1)
        values = samples(self.path("out.tif"))
        x, y = np.meshgrid(np.arange(10) + 0.5, 10 - (np.arange(10) + 0.5))
        inside = x + y <= 10
        np.testing.assert_array_equal(np.isnan(values), ~inside)
        np.testing.assert_allclose(values[inside], (1 + 0.1 * x + 0.2 * y)[inside], atol=1e-12)
        found = self.evaluated(file, [(1, 1), (6, 6), (-1, 2)], 1)
        np.testing.assert_allclose(found[0], [1.3, 0.1, 0.2], atol=1e-12)
        self.assertTrue(np.isnan(found[1:]).all())
        self.assertEqual(self.json("eval", file, "--at", "6,6", "--at", "1,1")["outside"], 1)

    def test_tables_and_meshes(self):
        self.json("decode", self.file, self.path("out.csv"))
        table = rows_of(self.path("out.csv"))
        self.assertEqual(table[0], ["x", "y", "value", "dx", "dy"])
        found = np.array(table[1:], float)
        order = np.lexsort(found[:, :2].T)
        expected = self.rows[np.lexsort(self.rows[:, :2].T)]
        np.testing.assert_allclose(found[order][:, :3], expected, atol=1e-13)
        np.testing.assert_allclose(found[:, 3:], [quadratic_jet(x, y)[1:3] for x, y in found[:, :2]], atol=1e-9)
        report = self.json("decode", self.file, self.path("out.obj"))
        with open(self.path("out.obj"), encoding="ascii") as file:
            vertices = np.array([line.split()[1:] for line in file if line.startswith("v ")], float)
        np.testing.assert_array_equal(vertices, found[:, :3])
        self.assertEqual((report["vertices"], len(vertices)), (300, 300))

    def test_bezier_triangles(self):
        report = self.json("decode", self.file, self.path("out.vtu"))
        root, arrays = read_vtu(self.path("out.vtu"))
        cells = arrays["connectivity"].reshape(-1, 6)
        self.assertEqual(len(cells), 6 * report["triangles"])
        self.assertEqual(set(arrays["types"]), {76})
        points = arrays["points"].reshape(-1, 3)
        net = points[cells]
        # The value of each net in the middle and on a side is that of the quadratic there.
        for weights in ((1 / 9, 1 / 9, 1 / 9, 2 / 9, 2 / 9, 2 / 9), (1 / 4, 1 / 4, 0, 1 / 2, 0, 0)):
            x, y, z = np.tensordot(weights, net, (0, 1)).T
            np.testing.assert_allclose(z, quadratic(x, y), atol=1e-10)
        np.testing.assert_allclose(arrays["value"], points[:, 2])
        gradients = arrays["gradient"].reshape(-1, 2)
        np.testing.assert_allclose(gradients, [quadratic_jet(x, y)[1:3] for x, y, _ in points], atol=1e-8)
        # Six pieces together are one triangle.
        self.json("decode", self.file, self.path("out.obj"))
        with open(self.path("out.obj"), encoding="ascii") as file:
            lines = [line.split() for line in file]
        vertices = np.array([line[1:3] for line in lines if line[0] == "v"], float)
        corners = vertices[np.array([line[1:] for line in lines if line[0] == "f"], int) - 1]
        np.testing.assert_allclose(areas(net[:, :3, :2]).reshape(-1, 6).sum(axis=1), areas(corners), atol=1e-13)
        self.assertGreater(np.min(areas(net[:, :3, :2])), 0)
        self.assertEqual(root.get("type"), "UnstructuredGrid")

    def test_options(self):
        self.refuse(2, "decode", self.file, self.path("no.csv"), "--cell", 1, says="--cell")
        self.refuse(2, "decode", self.file, self.path("no.tif"), "--cell", 0, says="positive")
        self.refuse(2, "decode", self.file, self.path("no.tif"), "--cell", 1e-12, says="--cell")
        self.refuse(2, "decode", self.file, self.path("no.tif"), "--window", "0,0,99,1", says="30 x 25")
        self.refuse(2, "decode", self.file, self.path("no.tif"), "--level", 1, says="level")


def areas(triangles):
    a, b, c = (triangles[:, k] for k in range(3))
    return np.cross(b - a, c - a) / 2


def read_vtu(path):
    """The root of the file and its arrays by name; that of the places is "points"."""
    whole = contents_of(path)
    start = whole.index(b"_", whole.index(b"<AppendedData")) + 1
    head = whole[:whole.index(b"<AppendedData")] + b"</VTKFile>"
    root = ElementTree.fromstring(head)
    header = {"UInt64": "<Q", "UInt32": "<I"}[root.get("header_type", "UInt32")]
    types = {"Float64": "<f8", "Int64": "<i8", "UInt8": "<u1", "Float32": "<f4", "Int32": "<i4"}
    arrays = {}
    for item in root.iter("DataArray"):
        at = start + int(item.get("offset"))
        (size,) = struct.unpack_from(header, whole, at)
        at += struct.calcsize(header)
        dtype = np.dtype(types[item.get("type")])
        name = item.get("Name") or "points"
        arrays[name.lower()] = np.frombuffer(whole[at:at + size], dtype)
    return root, arrays


class Looking(Points):
    def setUp(self):
        super().setUp()
        self.rows = scattered(400, wavy)
        self.source = self.points(self.rows)
        self.file, self.report = self.fitted(self.source, "--vertices", 12, "--levels", 1)

    def test_info(self):
        info = self.json("info", self.file)
        self.assertEqual((info["format"], info["content"], info["scheme"], info["order"], info["levels"]),
                         ("relief", "powell-sabin", "powell-sabin", 2, 1))
        self.assertEqual((info["kind"], info["delaunay"], info["components"]), ("coefficients", True, 1))
        np.testing.assert_allclose(info["extent"], [0, 0, 6, 5], atol=1e-14)
        self.assertEqual([level["vertices"] for level in info["level_list"]][1], self.report["vertices"])
        self.assertEqual(info["triangles"], 9 * self.report["triangles"])
        self.assertTrue(info["checksums_ok"])
        self.assertIn("checksums hold", self.text("info", self.file))
        points = self.json("info", self.source)
        self.assertEqual((points["format"], points["points"], points["weights"]), ("points", 400, False))
        self.assertEqual(points["extent"], [0, 0, 6, 5])
        self.assertEqual((points["min"], points["max"]), (min(self.rows[:, 2]), max(self.rows[:, 2])))

    def test_points_and_their_surface(self):
        compared = self.json("compare", self.source, self.file)
        errors = self.errors(self.file, self.rows)
        self.assertEqual((compared["samples"], compared["outside"]), (400, 0))
        self.assertAlmostEqual(compared["max_error"], np.max(errors), delta=1e-14)
        self.assertAlmostEqual(compared["rms_error"], np.sqrt(np.mean(errors ** 2)), delta=1e-14)
        worst = self.rows[np.argmax(errors)]
        self.assertEqual(compared["worst"], {"x": worst[0], "y": worst[1]})
        values = self.rows[:, 2]
        energy = 100 * np.sum(errors ** 2) / np.sum((values - np.mean(values)) ** 2)
        self.assertAlmostEqual(compared["energy_percent"], energy, delta=1e-9 * energy)
        away = self.points(np.vstack([self.rows, (9, 9, 0)]), "away.xyz")
        self.assertEqual(self.json("compare", away, self.file)["outside"], 1)

    def test_two_surfaces(self):
        same = self.json("compare", self.file, self.file)
        self.assertEqual((same["max_error"], same["outside"], same["psnr_db"]), (0, 0, None))
        self.assertGreater(same["samples"], 200000)
        raised = self.path("raised.relief")
        count = self.report["vertices"]
        moves = [word for v in range(count) for word in ("--move", f"{v}:2.5")]
        self.json("edit", self.file, raised, "--level", 1, *moves)
        up = self.json("compare", self.file, raised)
        # All control triangles rise by 2.5, and so does the surface: B-splines have the sum 1.
        self.assertAlmostEqual(up["max_error"], 2.5, delta=1e-12)
        self.assertAlmostEqual(up["rms_error"], 2.5, delta=1e-12)
        self.refuse(1, "compare", self.source, self.source, says="Powell-Sabin")

    def test_edit_moves_control_triangles(self):
        before = np.array(self.table(self.file, 1), float)
        target = self.path("edited.relief")
        report = self.json("edit", self.file, target, "--level", 1, "--move", "3:1.5,0.25,-0.5")
        self.assertEqual((report["moved"], report["edits"]), (1, 1))
        after = np.array(self.table(target, 1), float)
        expected = before.copy()
        expected[3, 2:] += [1.5, 0.25, -0.5]
        np.testing.assert_allclose(after, expected, atol=1e-13)
        fine = [np.array(self.table(f, 0), float) for f in (self.file, target)]
        moved = np.any(fine[0] != fine[1], axis=1)
        self.assertEqual(report["touched"], np.count_nonzero(moved))
        low, high = fine[0][moved, :2].min(axis=0), fine[0][moved, :2].max(axis=0)
        np.testing.assert_allclose(report["bounds"], [*low, *high], atol=1e-14)
        self.assertIsNone(self.json("info", target)["bound"])
        for move in ("3:1,2", "3", "3:1,2,3,4", ":1", "3:x"):
            self.refuse(2, "edit", self.file, self.path("no.relief"), "--level", 1, "--move", move,
                        says="INDEX:DZ[,DX,DY]")
        self.refuse(2, "edit", self.file, self.path("no.relief"), "--level", 1, "--move", "999:1", says="vert")

    def test_scripts_are_lists_of_moves(self):
        by_options, by_script = self.path("options.relief"), self.path("script.relief")
        self.json("edit", self.file, by_options, "--level", 1, "--move", "3:1.5,0.25,-0.5", "--move", "0:2")
        script = self.script([{"level": 1, "index": 3, "delta": [1.5, 0.25, -0.5]},
                              {"level": 1, "index": 0, "delta": 2}])
        report = self.json("edit", self.file, by_script, "--script", script)
        self.assertEqual((report["moved"], report["edits"]), (2, 2))
        self.assertEqual(contents_of(by_options), contents_of(by_script))
        good = {"level": 1, "index": 3, "delta": 1}
        for change in ({"delta": [1, 2]}, {"delta": []}, {"delta": "1"}, {"index": "3"}, {"level": 1.5},
                       {"component": "x"}):
            with self.subTest(change=change):
                bad = self.script([good, {**good, **change}])
                self.refuse(1, "edit", self.file, by_script, "--script", bad, says=f"{bad}, move 2")
        for change in ({"index": 999}, {"index": -1}, {"level": 5}, {"level": -1}, {"component": 1}):
            with self.subTest(change=change):
                bad = self.script([good, {**good, **change}])
                self.refuse(2, "edit", self.file, by_script, "--script", bad, says=f"{bad}, move 2")
        self.refuse(1, "edit", self.file, by_script, "--script", self.script([7]), says="move 1")
        self.refuse(1, "edit", self.file, by_script, "--script", self.script({"no": []}), says="list of moves")

    def test_scripts_move_surfaces_in_space(self):
        rows = scattered(50, quadratic)
        space = self.points(np.hstack([rows, rows[:, :2]]), "space.xyz")
        file, _ = self.fitted(space, "--columns", "1,2,3,4,5")
        places = rows[:, :2]
        script = self.script({"moves": [{"level": 0, "index": 7, "component": 1, "delta": [1, 0.5, 0]}]})
        moved = self.path("moved.relief")
        self.json("edit", file, moved, "--script", script)
        change = self.evaluated(moved, places) - self.evaluated(file, places)
        # Vertex 7 is one of the points, and only y changes there.
        np.testing.assert_allclose(np.sort(change[:, 1])[-2:], [0, 1], atol=1e-12)
        np.testing.assert_array_equal(change[:, [0, 2]], 0)
        self.refuse(2, "edit", file, moved, "--level", 0, "--move", "7:1", says="--script")

    def script(self, moves):
        path = self.path("moves.json")
        with open(path, "w", encoding="ascii") as file:
            json.dump(moves, file)
        return path

    def table(self, file, level):
        self.json("decode", file, self.path("table.csv"), "--level", level)
        return rows_of(self.path("table.csv"))[1:]

    def test_pictures(self):
        for options in ((), ("--style", "colour"), ("--style", "surface"), ("--style", "wire"),
                        ("--style", "wire", "--level", 1), ("--level", 1)):
            with self.subTest(options=options):
                size = self.json("render", self.file, self.path("out.png"), "--width", 320, *options)
                self.assertEqual(size["width"], 320)
                picture = read_raster(self.path("out.png"))
                self.assertEqual(picture.planes[0].shape, (size["height"], 320))
                self.assertGreater(np.std(picture.planes[0].astype(float)), 5)
        plain = self.json("render", self.file, self.path("plan.png"), "--width", 300)
        self.assertEqual(plain["height"], 250)  # 6 to 5

    def test_levels_and_prefixes(self):
        levels = self.json("info", self.file)["level_list"]
        self.assertLess(levels[1]["bytes"], levels[0]["bytes"])
        part = self.json("decode", self.file, self.path("part.csv"), "--level", 1, "--bytes", levels[1]["bytes"])
        self.assertEqual(part["finest_level"], 1)
        self.assertEqual(rows_of(self.path("part.csv"))[1:], self.table(self.file, 1))
        self.refuse(1, "decode", self.file, self.path("no.csv"), "--bytes", levels[1]["bytes"])


class BadPoints(Points):
    def test_named_errors(self):
        out = self.path("no.relief")
        bad = self.points(scattered(10, wavy))
        with open(bad, "a", encoding="ascii") as file:
            file.write("1 2 north\n")
        self.refuse(1, "fit", bad, out, says=f"{bad}, line 11")
        line = self.points([(k, 2 * k, 1) for k in range(9)], "line.xyz")
        self.refuse(1, "fit", line, out, says=(line, "collinear_points"))
        few = self.points([(0, 0, 1), (1, 0, 2)], "few.xyz")
        self.refuse(1, "fit", few, out, says=(few, "too_few_points"))
        self.refuse(1, "fit", few, out, "--max-error", 1, says=(few, "too_few_points"))
        self.refuse(1, "fit", self.path("absent.xyz"), out, says="absent.xyz")

    def test_damaged_files(self):
        file, _ = self.fitted(self.points(scattered(60, wavy)), "--max-error", 0.1)
        whole = contents_of(file)
        for at in range(0, len(whole), max(1, len(whole) // 60)):
            with open(self.path("bad.relief"), "wb") as bad:
                bad.write(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1:])
            self.refuse(1, "decode", self.path("bad.relief"), self.path("no.csv"))

    def test_threads_do_not_matter(self):
        source = self.points(scattered(2000, wavy, noise=0.2))
        for options in ((), ("--max-error", 0.5), ("--vertices", 50)):
            files = [contents_of(self.fitted(source, *options, "--threads", n)[0]) for n in (1, 2, 3)]
            self.assertEqual(files[0], files[1])
            self.assertEqual(files[0], files[2])


class RealData(Points):
    def data(self, name):
        path = os.path.join(DATA, "points", name)
        if not os.path.exists(path):
            self.skipTest(f"{path} is not there")
        return path

    def test_lidar(self):
        source = self.data("mvk_thin.xyz")
        file, report = self.fitted(source)
        compared = self.json("compare", source, file)
        self.assertEqual(compared["samples"] + compared["outside"], report["points"])
        # Returns above each other differ; the surface passes through their means.
        self.assertAlmostEqual(compared["max_error"], report["max_error"], delta=1e-6)
        bounded, smaller = self.fitted(source, "--max-error", 20, name="bounded.relief")
        compared = self.json("compare", source, bounded)
        self.assertLessEqual(compared["max_error"], 20)
        self.assertEqual(compared["outside"], 0)
        self.assertLess(2 * smaller["bytes"], report["bytes"])

    def test_soundings(self):
        source = self.data("baja_bathymetry.csv")
        info = self.json("info", source)
        self.assertEqual(info["points"], 82970)
        _, report = self.fitted(source, "--vertices", 400)
        self.assertGreater(report["smoothing"], 0)
        self.assertLess(report["energy_percent"], 10)


if __name__ == "__main__":
    main()
