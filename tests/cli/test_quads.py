"""Quad meshes as surfaces: encode, decode at any level, info, compare, eval and edit, end to end."""

import csv
import io
import math

import numpy as np

from harness import Case, contents_of, main

ENCODE_KEYS = ("scheme order levels samples coefficients kept bytes bits_per_sample max_error rms_error "
               "energy_percent bound surface_bound quads seconds").split()


def quadratic(x, y):
    """Splines reproduce it, derivatives estimated from values included."""
    return 3 + 0.5 * x - 2 * y + 0.25 * x * x + 0.75 * x * y - 0.5 * y * y


def wavy(x, y):
    return 10 * math.sin(0.7 * x) * math.cos(0.5 * y) + 0.3 * x


def grid(cols, rows, height, skip=(), shake=0.0):
    """Vertices and quads of cols x rows squares, row by row; `skip` names quads that are left out."""
    rng = np.random.default_rng(5)
    vertices = []
    for r in range(rows + 1):
        for c in range(cols + 1):
            inside = 0 < r < rows and 0 < c < cols
            x, y = (round(k + inside * shake * rng.uniform(-1, 1), 3) for k in (c, r))
            vertices.append((x, y, height(x, y)))
    quads = [(v, v + 1, v + cols + 2, v + cols + 1)
             for v in (r * (cols + 1) + c for r in range(rows) for c in range(cols))]
    return vertices, [quad for k, quad in enumerate(quads) if k not in skip]


def star(valence, height):
    """Quads around an interior vertex."""
    places = [(0.0, 0.0)]
    for k in range(2 * valence):
        angle = math.pi * k / valence
        radius = 1.0 if k % 2 == 0 else 1.3 / math.cos(1.6 / valence)
        places.append((radius * math.cos(angle), radius * math.sin(angle)))
    quads = [(0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * valence)) for k in range(valence)]
    return [(x, y, height(x, y)) for x, y in places], quads


def crossing(a, b, c, d):
    """Where the diagonals of a quad meet."""
    u, v, w = (tuple(q[k] - p[k] for k in (0, 1)) for p, q in ((a, c), (b, d), (a, b)))
    s = (w[0] * v[1] - w[1] * v[0]) / (u[0] * v[1] - u[1] * v[0])
    return a[0] + s * u[0], a[1] + s * u[1]


def refined(mesh, height):
    """Each quad into four; vertices, midpoints, centres."""
    vertices, quads = mesh
    places = [v[:2] for v in vertices]
    middle = {}
    for quad in quads:
        for a, b in zip(quad, quad[1:] + quad[:1]):
            if frozenset((a, b)) not in middle:
                middle[frozenset((a, b))] = len(places)
                places.append(tuple((places[a][k] + places[b][k]) / 2 for k in (0, 1)))
    finer = []
    for quad in quads:
        centre = len(places)
        places.append(crossing(*(places[v] for v in quad)))
        sides = [middle[frozenset((quad[i], quad[(i + 1) % 4]))] for i in range(4)]
        finer += [(quad[i], sides[i], centre, sides[i - 1]) for i in range(4)]
    return [(x, y, height(x, y)) for x, y in places], finer


def shuffled(mesh, seed=1):
    vertices, quads = mesh
    rng = np.random.default_rng(seed)
    number = rng.permutation(len(vertices))
    out = [None] * len(vertices)
    for old, new in enumerate(number):
        out[new] = vertices[old]
    turned = []
    for k in rng.permutation(len(quads)):
        turn = rng.integers(4)
        quad = [int(number[v]) for v in quads[k]]
        turned.append(tuple(quad[turn:] + quad[:turn]))
    return out, turned


def read_off(path):
    with open(path, encoding="ascii") as file:
        words = file.read().split()
    assert words[0] == "OFF"
    count, polygons = int(words[1]), int(words[2])
    vertices = [tuple(map(float, words[4 + 3 * k:7 + 3 * k])) for k in range(count)]
    rest = words[4 + 3 * count:]
    quads = [tuple(map(int, rest[5 * k + 1:5 * k + 5])) for k in range(polygons)]
    return vertices, quads


class Quads(Case):
    def mesh(self, mesh, name="mesh.off"):
        path = self.path(name)
        vertices, quads = mesh
        with open(path, "w", encoding="ascii") as file:
            if name.endswith(".off"):
                file.write(f"OFF\n{len(vertices)} {len(quads)} 0\n")
                file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in vertices)
                file.writelines("4 {} {} {} {}\n".format(*quad) for quad in quads)
            else:
                file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices)
                file.writelines("f {} {} {} {}\n".format(*(v + 1 for v in quad)) for quad in quads)
        return path

    def restored(self, file, *options, name="out.off"):
        report = self.json("decode", file, self.path(name), *options)
        return read_off(self.path(name)), report


class RoundTrips(Quads):
    def test_lossless_meshes_of_all_kinds(self):
        meshes = {
            "grid": grid(7, 5, wavy, shake=0.15),
            "hole": grid(5, 5, wavy, skip=(12,), shake=0.15),
            "valence 3": star(3, wavy),
            "valence 5": star(5, wavy),
            "refined": refined(refined(star(5, wavy), wavy), wavy),
            "shuffled": shuffled(refined(grid(3, 2, wavy, shake=0.15), wavy)),
        }
        levels = {"refined": 2, "shuffled": 1}
        for name, mesh in meshes.items():
            for extension in (".off", ".obj"):
                with self.subTest(name=name, extension=extension):
                    source = self.mesh(mesh, "mesh" + extension)
                    file, report = self.encoded(source)
                    self.assertEqual(list(report), ENCODE_KEYS)
                    self.assertEqual((report["samples"], report["quads"], report["levels"]),
                                     (len(mesh[0]), len(mesh[1]), levels.get(name, 0)))
                    self.assertEqual((report["max_error"], report["surface_bound"]), (0, 0))
                    decoded, decode = self.restored(file)
                    self.assertEqual(decoded, mesh)
                    self.assertEqual(decode["bytes_read"], report["bytes"])
                    same = self.json("compare", source, file)
                    self.assertEqual((same["samples"], same["max_error"], same["faces_differ"]),
                                     (len(mesh[0]), 0, False))
                    self.assertIsNone(same["psnr_db"])

    def test_every_vertex_is_within_the_bound(self):
        for mesh in (grid(9, 8, wavy, shake=0.15), refined(refined(grid(3, 3, wavy), wavy), wavy)):
            source = self.mesh(mesh)
            for bound in (1, 0.01):
                file, report = self.encoded(source, "--max-error", bound, "--scheme", "fvs")
                (vertices, quads), decode = self.restored(file)
                self.assertEqual(quads, mesh[1])
                errors = []
                for (x, y, z), (a, b, c) in zip(vertices, mesh[0]):
                    self.assertEqual((x, y), (a, b))
                    errors.append(abs(z - c))
                self.assertLessEqual(max(errors), bound)
                self.assertEqual(max(errors), report["max_error"])
                self.assertEqual(report["bound"], bound)
                # The header keeps four digits, rounded up.
                self.assertGreaterEqual(decode["bound"], report["max_error"])
                self.assertLessEqual(decode["bound"], min(bound, 1.0011 * report["max_error"]))
                self.assertGreaterEqual(report["surface_bound"], report["max_error"])
                # Derivatives are estimated from values that are off by up to the bound.
                self.assertLess(report["surface_bound"], 4 * bound)
                compared = self.json("compare", source, file)
                self.assertEqual(compared["max_error"], report["max_error"])
                self.assertAlmostEqual(compared["rms_error"], report["rms_error"], delta=1e-15)

    def test_other_goals(self):
        source = self.mesh(refined(refined(refined(grid(3, 3, wavy), wavy), wavy), wavy))
        _, rms = self.encoded(source, "--rms-error", 0.02)
        self.assertLessEqual(rms["rms_error"], 0.02)
        self.assertGreater(rms["rms_error"], 0.015)
        _, small = self.encoded(source, "--bytes", 700)
        self.assertLessEqual(small["bytes"], 700)
        self.assertGreater(small["bytes"], 600)
        file, kept = self.encoded(source, "--keep", 30)
        self.assertEqual(kept["kept"], int(0.3 * 625))
        (vertices, _), _ = self.restored(file)
        self.assertAlmostEqual(max(abs(v[2] - wavy(*v[:2])) for v in vertices), kept["max_error"],
                               delta=1e-14)
        self.refuse(2, "encode", source, self.path("no.relief"), "--bytes", 60, says="bytes")

    def test_threads_do_not_matter(self):
        source = self.mesh(refined(grid(20, 20, wavy, shake=0.15), wavy))
        files = [contents_of(self.encoded(source, "--max-error", 0.01, "--threads", n)[0])
                 for n in (1, 2, 3)]
        self.assertEqual(files[0], files[1])
        self.assertEqual(files[0], files[2])


class Levels(Quads):
    def setUp(self):
        super().setUp()
        self.base = star(5, wavy)
        self.once = refined(self.base, wavy)
        self.twice = refined(self.once, wavy)
        self.file, _ = self.encoded(self.mesh(self.twice))

    def test_coarser_meshes(self):
        for level, mesh in enumerate((self.twice, self.once, self.base)):
            (vertices, quads), report = self.restored(self.file, "--level", level)
            self.assertEqual(len(vertices), len(mesh[0]))
            self.assertEqual(quads, mesh[1])
            np.testing.assert_allclose(vertices, mesh[0], atol=1e-15 * 4)
            self.assertEqual((report["level"], report["finest_level"]), (level, 0))
        self.refuse(2, "decode", self.file, self.path("no.off"), "--level", 3, says="levels 0 to 2")

    def test_prefixes(self):
        info = self.json("info", self.file)
        bytes_of = [level["bytes"] for level in info["level_list"]]
        self.assertEqual(bytes_of, sorted(bytes_of, reverse=True))
        whole, _ = self.restored(self.file, "--level", 1)
        part, report = self.restored(self.file, "--level", 1, "--bytes", bytes_of[1])
        self.assertEqual(part, whole)
        self.assertEqual(report["finest_level"], 1)
        self.refuse(1, "decode", self.file, self.path("no.off"), "--bytes", bytes_of[1],
                    says=(self.file, f"first {bytes_of[0]} bytes"))

    def test_info(self):
        info = self.json("info", self.file)
        self.assertEqual((info["format"], info["content"], info["scheme"], info["levels"]),
                         ("relief", "quadrangulation", "fvs", 2))
        self.assertEqual((info["vertices"], info["quads"]), (len(self.twice[0]), 80))
        self.assertEqual([level["quads"] for level in info["level_list"]], [80, 20, 5])
        bounds = [level["surface_bound"] for level in info["level_list"]]
        self.assertEqual(bounds[0], 0)
        self.assertLess(bounds[1], bounds[2])
        self.assertTrue(info["checksums_ok"])
        xs, ys, _ = zip(*self.base[0])
        self.assertEqual(info["extent"], [min(xs), min(ys), max(xs), max(ys)])
        self.assertIn("80", self.text("info", self.file))
        mesh = self.json("info", self.mesh(self.base, "base.obj"))
        self.assertEqual((mesh["format"], mesh["vertices"], mesh["quads"]), ("mesh", 11, 5))


class Evaluation(Quads):
    def values(self, file, points, *options):
        places = [word for x, y in points for word in ("--at", f"{x},{y}")]
        return self.json("eval", file, *places, *options)

    def test_quadratics_are_exact(self):
        file, _ = self.encoded(self.mesh(grid(6, 5, quadratic, shake=0.15)))
        points = [(0.3, 0.4), (2.71, 3.14), (5.9, 4.2), (3, 2)]
        report = self.values(file, points, "--derivatives", 2)
        self.assertEqual((report["points"], report["outside"]), (4, 0))
        for (x, y), jet in zip(points, report["values"]):
            expected = [quadratic(x, y), 0.5 + 0.5 * x + 0.75 * y, -2 + 0.75 * x - y, 0.5, 0.75, -1]
            # Values up to 20; each derivative loses about a digit on cells of size 1.
            np.testing.assert_allclose(jet, expected, atol=1e-11)

    def test_outside_and_holes_are_empty(self):
        file, _ = self.encoded(self.mesh(grid(5, 5, quadratic, skip=(12,))))
        points = [(2.5, 2.5), (-1, 1), (6, 6), (1.5, 2.5), (0, 0), (5, 5)]
        report = self.values(file, points)
        self.assertEqual(report["outside"], 3)
        self.assertEqual([row[0] is None for row in report["values"]],
                         [True, True, True, False, False, False])
        rows = list(csv.reader(io.StringIO(self.text("eval", file, "--at=-1,1", "--at=0,0",
                                                     "--derivatives", 1))))
        self.assertEqual(rows[0], ["x", "y", "value", "dx", "dy"])
        self.assertEqual(rows[1], ["-1", "1", "", "", ""])
        self.assertAlmostEqual(float(rows[2][2]), 3, delta=1e-12)


class Edits(Quads):
    def edited(self, file, *options, name="edited.relief"):
        return self.path(name), self.json("edit", file, self.path(name), *options)

    def test_vertices_of_the_finest_level(self):
        mesh = shuffled(refined(grid(4, 4, wavy, shake=0.15), wavy))
        file, _ = self.encoded(self.mesh(mesh))
        target, report = self.edited(file, "--level", 0, "--move", "17:2.5", "--move", "3:-1")
        self.assertEqual((report["moved"], report["touched"], report["edits"]), (2, 2, 2))
        expected = [list(v) for v in mesh[0]]
        expected[17][2] += 2.5
        expected[3][2] -= 1
        self.assertEqual(self.restored(target)[0][0], [tuple(v) for v in expected])
        xs, ys = zip(*(expected[k][:2] for k in (3, 17)))
        self.assertEqual(report["bounds"], [min(xs), min(ys), max(xs), max(ys)])
        info = self.json("info", target)
        self.assertEqual((info["edits"], info["bound"], info["surface_bound"]), (2, None, None))

    def test_finer_levels_follow(self):
        coarse = grid(6, 6, wavy)
        file, _ = self.encoded(self.mesh(refined(coarse, wavy)), "--levels", 1)
        target, report = self.edited(file, "--level", 1, "--move", "24:4")  # in the middle
        before, after = (self.restored(f)[0][0] for f in (file, target))
        rise = [b[2] - a[2] for a, b in zip(before, after)]
        self.assertEqual(report["touched"], sum(r != 0 for r in rise))
        self.assertAlmostEqual(rise[24], 4, delta=1e-13)
        for v, place in enumerate(coarse[0]):
            if v != 24:
                self.assertEqual(rise[v], 0, place)
        # Halfway to the next vertex a bump of height 4 is about half as high.
        near = [r for r, v in zip(rise, after) if abs(v[0] - 3) == 0.5 and v[1] == 3]
        self.assertEqual(len(near), 2)
        for r in near:
            self.assertTrue(1.5 < r < 3, r)
        back, _ = self.edited(target, "--level", 1, "--move", "24:-4", name="back.relief")
        self.assertEqual(self.restored(back)[0][0], before)

    def test_moves_that_do_not_exist(self):
        file, _ = self.encoded(self.mesh(grid(2, 2, wavy)))
        out = self.path("new.relief")
        self.refuse(2, "edit", file, out, "--level", 0, "--move", "9:1", says="vertices 0 to 8")
        self.refuse(2, "edit", file, out, "--level", 2, "--move", "0:1", says="levels 0 to 1")
        self.refuse(2, "edit", file, out, "--level", 0, "--move", "0:1,2", says="INDEX:DZ")
        self.refuse(2, "edit", file, out, "--move", "0:1", says="--level")
        self.refuse(2, "edit", file, out, says="nothing to do")


class BadMeshes(Quads):
    def refused(self, mesh, *says, code=1):
        source = self.mesh(mesh)
        self.refuse(code, "encode", source, self.path("no.relief"), says=(source,) + says)

    def test_named_errors(self):
        vertices, quads = grid(2, 2, wavy)
        self.refused((vertices, quads[:1] + [quads[1][::-1]] + quads[2:]), "clockwise", "quad 1")
        self.refused((vertices, [(0, 1, 4, 9)] + quads[1:]), "index_out_of_range", "line 12")
        self.refused((vertices, quads + [quads[0]]), "edge_used_twice_in_same_direction")
        self.refused((vertices, quads[:3]), "unused_vertex", "vertex 8")
        self.refused(([(float("nan"),) + vertices[0][1:]] + vertices[1:], quads),
                     "non_finite_vertex", "line 3")
        self.refused(([vertices[0][:2] + (float("inf"),)] + vertices[1:], quads),
                     "non_finite_vertex", "line 3")
        self.refused((vertices, []), "unused_vertex")
        over = vertices + [(0.5, 0.5, 0), (1.5, 0.5, 0), (1.5, 1.5, 0), (0.5, 1.5, 0)]
        self.refused((over, quads + [(9, 10, 11, 12)]), "overlap")

    def test_other_polygons(self):
        path = self.path("mesh.off")
        with open(path, "w", encoding="ascii") as file:
            file.write("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n")
        self.refuse(1, "encode", path, self.path("no.relief"), "--scheme", "fvs",
                    says=("not_a_quad", f"{path}, polygon 0"))

    def test_options_of_rasters(self):
        source = self.mesh(grid(2, 2, wavy))
        out = self.path("no.relief")
        self.refuse(2, "encode", source, out, "--scheme", "box", says="fvs")
        self.refuse(2, "encode", source, out, "--map", "coefficients", says="rasters")
        self.refuse(2, "encode", source, out, "--levels", 2, says="1 levels")
        file, _ = self.encoded(source)
        self.refuse(2, "decode", file, self.path("no.off"), "--scale", 2, says="rasters")
        self.refuse(2, "decode", file, self.path("no.xyz"), says=".obj, .off, .ply, .stl or .glb")

    def test_damaged_files(self):
        file, _ = self.encoded(self.mesh(refined(grid(3, 3, wavy), wavy)), "--max-error", 0.1)
        whole = contents_of(file)
        for at in range(0, len(whole), 7):
            with open(self.path("bad.relief"), "wb") as bad:
                bad.write(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1:])
            self.refuse(1, "decode", self.path("bad.relief"), self.path("no.off"))


if __name__ == "__main__":
    main()
