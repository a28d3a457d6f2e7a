"""Remeshing: any mesh of triangles to one with subdivision connectivity, and into a file, end to end."""

import math
import os
import signal
import subprocess
import time

import numpy as np

from harness import DATA, RELIEF, contents_of, main
from test_meshes import Meshes, read_obj

REMESH_KEYS = ("vertices faces base_faces levels rms_error max_error worst flips quality diagonal attempts "
               "left_out seconds").split()


def scan(rings=40, noise=0.0, genus=1):
    """A bumpy torus of irregular triangles, or an open cap of one; about 4 rings^2 triangles."""
    rng = np.random.default_rng(3)
    rows, cols = rings, 2 * rings
    v, u = np.meshgrid(np.arange(rows), np.arange(cols), indexing="ij")
    if genus:
        u = u + rng.uniform(-0.25, 0.25, u.shape)
        v = v + rng.uniform(-0.25, 0.25, v.shape)
    a, b = 2 * np.pi * u / cols, 2 * np.pi * v / rows
    if not genus:
        b = 0.2 + 2.2 * v / (rows - 1)
    radius = 1 + 0.12 * np.sin(3 * a) * np.cos(2 * b) + rng.normal(0, noise, a.shape)
    points = np.stack([(3 + radius * np.cos(b)) * np.cos(a), (3 + radius * np.cos(b)) * np.sin(a),
                       radius * np.sin(b)], -1).reshape(-1, 3)
    faces = []
    for r in range(rows if genus else rows - 1):
        for c in range(cols):
            p, q = r * cols + c, r * cols + (c + 1) % cols
            s, t = (r + 1) % rows * cols + c, (r + 1) % rows * cols + (c + 1) % cols
            faces += [(p, q, t), (p, t, s)] if (r + c) % 3 else [(p, q, s), (q, t, s)]
    return points.tolist(), faces


class Remesh(Meshes):
    def remeshed(self, mesh, *options, name="out.obj"):
        out = self.path(name)
        return out, self.json("remesh", self.mesh(mesh), out, *options)

    def distance(self, a, b):
        return self.json("compare", a, b, "--surface")

    def test_a_scan_becomes_a_subdivision_of_the_same_shape(self):
        for genus in (1, 0):
            original = self.mesh(scan(genus=genus))
            out, report = self.remeshed(scan(genus=genus))
            self.assertEqual(list(report), REMESH_KEYS)
            self.assertEqual(report["flips"], 0)
            self.assertEqual(report["faces"], report["base_faces"] * 4**report["levels"])
            diagonal = report["diagonal"]
            self.assertLess(report["rms_error"], 6e-4 * diagonal)
            self.assertLess(report["max_error"], 2e-3 * diagonal)
            measured = self.distance(original, out)
            self.assertAlmostEqual(measured["rms_error"], report["rms_error"], delta=1e-6 * diagonal)
            self.assertAlmostEqual(measured["max_error"], report["max_error"], delta=1e-6 * diagonal)
            # The file is recognised: as many levels can be taken off again.
            encoded = self.json("encode", out, self.path("out.relief"), "--max-error", 1e-3)
            self.assertEqual(encoded["levels"], report["levels"])
            self.assertEqual(encoded["base_faces"], report["base_faces"])

    def test_base_and_levels(self):
        _, report = self.remeshed(scan(), "--base", 100, "--levels", 3)
        self.assertEqual(report["levels"], 3)
        self.assertGreaterEqual(report["base_faces"], 100)
        self.assertLess(report["base_faces"], 200)

    def test_features_become_creases(self):
        steps = 12
        grid = np.arange(steps + 1) / steps
        points, numbers = [], {}

        def number(p):
            key = tuple(np.round(p, 9))
            if key not in numbers:
                numbers[key] = len(points)
                points.append(key)
            return numbers[key]

        faces = []
        for axis in range(3):
            for side in (0.0, 1.0):
                for i in range(steps):
                    for j in range(steps):
                        quad = []
                        for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                            p = [0.0] * 3
                            p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, grid[i + di], grid[j + dj]
                            quad.append(number(p))
                        quad = quad if side else quad[::-1]
                        faces += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
        out, report = self.remeshed((points, faces), "--features", 40, "--base", 30, "--levels", 2)
        self.assertLess(report["max_error"], 1e-9)
        with open(out, encoding="ascii") as file:
            creases = [line for line in file if line.startswith("t crease")]
        vertices, _ = read_obj(out)
        total = 0
        for line in creases:
            a, b = map(int, line.split()[3:5])
            total += np.linalg.norm(vertices[a] - vertices[b])
        self.assertAlmostEqual(total, 12, delta=1e-9)  # the edges of a cube
        # A file says them once, by the edges of the base, and gives them back.
        packed, back = self.path("cube.relief"), self.path("back.obj")
        self.json("encode", out, packed, "--max-error", 1e-3)
        self.json("decode", packed, back)
        with open(back, encoding="ascii") as file:
            self.assertEqual([line for line in file if line.startswith("t crease")], creases)
        self.assertLess(len(contents_of(packed)), 4 * len(creases))

    def test_files_are_measured_from_the_scan(self):
        original = self.mesh(scan(60))
        diagonal = self.remeshed(scan(60))[1]["diagonal"]
        for goal, share in (("--max-error", 4e-3), ("--rms-error", 6e-4)):
            out = self.path("scan.relief")
            report = self.json("encode", original, out, "--remesh", goal, f"{share}d")
            self.assertEqual(report["distance"], "surface")
            self.assertEqual(report["remesh"]["flips"], 0)
            reached = report["max_error" if goal == "--max-error" else "rms_error"]
            self.assertLessEqual(reached, share * diagonal)
            decoded = self.path("decoded.ply")
            self.json("decode", out, decoded)
            measured = self.distance(original, decoded)
            self.assertAlmostEqual(measured["max_error"], report["max_error"], delta=1e-6 * diagonal)
            self.assertAlmostEqual(measured["rms_error"], report["rms_error"], delta=1e-6 * diagonal)
            # 7200 vertices: less than 4 bits each.
            self.assertLess(len(contents_of(out)), 3600)
            # It is a file like others: every level, edits.
            self.json("decode", out, decoded, "--level", report["levels"])
            self.json("edit", out, self.path("bent.relief"), "--level", 1, "--move", "5:0,0,0.2")

    def test_goals_that_need_a_nearer_remesh(self):
        path = os.path.join(DATA, "meshes", "bull.off")
        if not os.path.exists(path):
            self.skipTest("the scan is not there")
        out = self.path("bull.relief")
        goal = ("encode", path, out, "--remesh", "--rms-error", "3e-4d")
        self.refuse(1, *goal, "--tolerance", "3e-3d", "--effort", 0, says="goal_out_of_reach")
        sizes = []
        for effort in (0, 1):
            report = self.json(*goal, "--effort", effort)
            self.assertLessEqual(report["rms_error"], 3e-4 * report["remesh"]["diagonal"])
            sizes.append(report["bytes"])
        # A finer remesh leaves more of the goal to the file.
        self.assertLess(sizes[1], 0.9 * sizes[0])

    def test_any_number_of_threads_gives_the_same_bytes(self):
        files = []
        for threads in (1, 3):
            out, _ = self.remeshed(scan(30), "--threads", threads, name=f"out{threads}.ply")
            files.append(contents_of(out))
        self.assertEqual(*files)

    def test_colours_follow(self):
        points, faces = scan()
        path = self.path("coloured.obj")
        with open(path, "w", encoding="ascii") as file:
            for p in points:
                file.write("v {} {} {} {} {} {}\n".format(*p, *(0.5 + x / 10 for x in p)))
            file.writelines("f {} {} {}\n".format(*(c + 1 for c in f)) for f in faces)
        out = self.path("out.obj")
        self.json("remesh", path, out)
        with open(out, encoding="ascii") as file:
            rows = np.array([list(map(float, line.split()[1:])) for line in file if line.startswith("v ")])
        # Colours are those of places on the scan, from which vertices are off by the largest distance.
        np.testing.assert_allclose(rows[:, 3:], 0.5 + rows[:, :3] / 10, atol=2e-3)

    def test_what_can_not_be_remeshed_is_named(self):
        out = self.path("out.ply")
        points, faces = scan(10)
        turned = [faces[0][::-1]] + faces[1:]
        self.refuse(1, "remesh", self.mesh((points, turned)), out, says=("non_manifold_edge", "face", "--repair"))
        self.json("remesh", self.mesh((points, turned)), out, "--repair", "--tolerance", "0.02d")
        crowded = faces + [(faces[0][0], faces[0][1], 57)]
        self.refuse(1, "remesh", self.mesh((points, crowded)), out, says=("non_manifold", "face"))
        flat = [(p[0], 0, 0) for p in points]
        self.refuse(1, "remesh", self.mesh((flat, faces)), out, says="no_area")
        self.refuse(1, "remesh", self.mesh(([(0, 0, 0)], [])), out, says="empty_mesh")
        self.refuse(1, "remesh", self.mesh(scan(30)), self.path("no.ply"), "--base", 8, "--levels", 0,
                    "--tolerance", "1e-5d", says=("tolerance_not_met", "of the diagonal"))
        self.assertFalse(os.path.exists(self.path("no.ply")))

    def test_numbers_that_are_none_are_named(self):
        points, faces = scan(10)
        for bad in ("nan", "inf", "1e400"):
            path = self.path("bad.obj")
            with open(path, "w", encoding="ascii") as file:
                file.writelines("v {} {} {}\n".format(*(p if k != 7 else (bad, 0, 0))) for k, p in enumerate(points))
                file.writelines("f {} {} {}\n".format(*(c + 1 for c in f)) for f in faces)
            self.refuse(1, "remesh", path, self.path("no.ply"), says=("bad.obj", "line 8"))
        with open(path, "a", encoding="ascii") as file:
            file.write(f"f 1 2 {2**31}\n")
        self.refuse(1, "remesh", path, self.path("no.ply"), says="bad.obj")

    def test_components_of_all_sizes(self):
        points, faces = scan(24)
        small = [tuple(0.02 * x + 9 for x in p) for p in points]
        speck = [(20, 20, 20), (20.001, 20, 20), (20, 20.001, 20), (20, 20, 20.001)]
        first, last = len(points), 2 * len(points)
        both = faces + [tuple(c + first for c in f) for f in faces]
        both += [(last, last + 2, last + 1), (last, last + 1, last + 3), (last + 1, last + 2, last + 3),
                 (last, last + 3, last + 2)]
        out, report = self.remeshed((points + small + speck, both))
        self.assertEqual(report["flips"], 0)
        self.assertLess(report["max_error"], 2e-3 * report["diagonal"])
        vertices, _ = read_obj(out)
        places = [np.linalg.norm(vertices - where, axis=1) for where in ((0, 0, 0), (9, 9, 9), (20, 20, 20))]
        self.assertEqual(sorted(set(np.argmin(places, axis=0))), [0, 1, 2])

    def test_a_surface_that_meets_itself(self):
        # Two sheets at one place, facing apart: nothing tells them from each other but walking.
        points, faces = scan(24)
        first = len(points)
        sheets = (points + points, faces + [tuple(c + first for c in f[::-1]) for f in faces])
        _, report = self.remeshed(sheets, "--tolerance", "0.01d")
        self.assertEqual(report["flips"], 0)

    def test_few_vertices_are_warned_of(self):
        said = self.text("remesh", self.mesh(scan(20)), self.path("few.ply"), "--tolerance", "0.02d")
        self.assertIn("warning: few_vertices", said)

    def test_degenerate_faces_do_no_harm(self):
        points, faces = scan(20)
        points = [list(p) for p in points]
        for k in range(0, 400, 37):
            points[k] = list(points[k + 1])  # edges without length, faces without area
        _, report = self.remeshed((points, faces), "--tolerance", "0.02d")
        self.assertEqual(report["flips"], 0)

    def test_thousands_of_holes(self):
        points, faces = scan(40)
        holed = [f for k, f in enumerate(faces) if k % 9]
        _, report = self.remeshed((points, holed), "--repair", "--tolerance", "0.03d")
        self.assertEqual(report["flips"], 0)

    def test_wrong_usage(self):
        path, out = self.mesh(scan(10)), self.path("out.relief")
        self.refuse(2, "encode", path, out, "--remesh", says="lossless")
        self.refuse(2, "encode", path, out, "--max-error", 0.1, "--base", 100, says="--remesh")
        self.refuse(2, "encode", path, out, "--remesh", "--rms-error", 0.1, "--scheme", "sqrt3", says="loop")
        self.refuse(2, "encode", path, out, "--remesh", "--rms-error", "1e-4x", says="1e-4x")
        self.refuse(2, "remesh", path, self.path("o.ply"), "--tolerance", 0, says="tolerance")
        self.refuse(2, "remesh", path, self.path("o.ply"), "--tolerance", "1x", says="1x")
        self.refuse(2, "remesh", path, self.path("o.ply"), "--features", 190, says="180")
        self.refuse(1, "encode", self.mesh(scan(40)), out, "--remesh", "--rms-error", "1e-9d",
                    says="goal_out_of_reach")

    def test_stops_when_asked(self):
        out = self.path("out.ply")
        process = subprocess.Popen([RELIEF, "remesh", self.mesh(scan(150)), out], stderr=subprocess.PIPE)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        self.assertIn(process.returncode, (1, -signal.SIGINT), said)  # killed before it could listen
        self.assertFalse(os.path.exists(out))

    def test_a_real_scan(self):
        path = os.path.join(DATA, "meshes", "bear.off")
        if not os.path.exists(path):
            self.skipTest("the scan is not there")
        report = self.json("remesh", path, self.path("bear.ply"))
        self.assertEqual(report["flips"], 0)
        self.assertLess(report["rms_error"], 2e-4 * report["diagonal"])
        self.assertLess(report["max_error"], 2e-3 * report["diagonal"])
        self.assertTrue(math.isfinite(report["quality"]))


if __name__ == "__main__":
    main()
