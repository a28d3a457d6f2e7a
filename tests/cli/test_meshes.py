"""Subdivision meshes: subdivide, encode, decode at any level, info, compare, edit and render, end to end."""

import math
import os
import struct

import numpy as np
from osgeo import gdal

from harness import DATA, Case, contents_of, main

ENCODE_KEYS = ("scheme order levels samples coefficients kept bytes bits_per_sample max_error rms_error "
               "energy_percent bound faces base_vertices base_faces lost_creases distance seconds").split()

CUBE = ([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)],
        [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])
GRID = ([(x, y, 0) for y in range(3) for x in range(3)],
        [(v, v + 1, v + 4, v + 3) for v in (0, 1, 3, 4)])
OCTAHEDRON = ([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
              [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])


def read_obj(path):
    vertices, faces = [], []
    with open(path, encoding="ascii") as file:
        for words in map(str.split, file):
            if words[:1] == ["v"]:
                vertices.append(tuple(map(float, words[1:4])))
            elif words[:1] == ["f"]:
                faces.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:]))
    return np.array(vertices), faces


class Meshes(Case):
    def mesh(self, mesh, name="mesh.obj", tail=""):
        path = self.path(name)
        with open(path, "w", encoding="ascii") as file:
            file.writelines("v {!r} {!r} {!r}\n".format(*map(float, v)) for v in mesh[0])
            file.writelines("f " + " ".join(str(v + 1) for v in face) + "\n" for face in mesh[1])
            file.write(tail)
        return path

    def subdivided(self, mesh, scheme, levels, *options, noise=0.0, tail="", name="fine.obj"):
        path = self.path(name)
        self.json("subdivide", self.mesh(mesh, tail=tail), path, "--scheme", scheme, "--levels",
                  levels, *options)
        if noise:
            vertices, faces = read_obj(path)
            vertices += np.random.default_rng(1).normal(0, noise, vertices.shape)
            self.mesh((vertices.tolist(), faces), name)
        return path


class Subdivide(Meshes):
    def test_hand_values(self):
        vertices, faces = read_obj(self.subdivided(CUBE, "catmull-clark", 1))
        self.assertEqual((len(vertices), len(faces)), (26, 24))
        np.testing.assert_allclose(np.abs(vertices[:8]), 5 / 9, atol=1e-15)
        vertices, faces = read_obj(self.subdivided(OCTAHEDRON, "loop", 1))
        self.assertEqual((len(vertices), len(faces)), (18, 32))
        self.assertAlmostEqual(vertices[0][0], 0.515625, delta=1e-15)
        vertices, faces = read_obj(self.subdivided(OCTAHEDRON, "sqrt3", 1))
        self.assertEqual((len(vertices), len(faces)), (14, 24))
        self.assertAlmostEqual(vertices[0][0], 5 / 9, delta=1e-15)

    def test_limits_are_where_subdivision_goes(self):
        limit, _ = read_obj(self.subdivided(OCTAHEDRON, "loop", 1, "--limit"))
        deep, _ = read_obj(self.subdivided(OCTAHEDRON, "loop", 7, name="deep.obj"))
        np.testing.assert_allclose(deep[:18], limit, atol=2e-4)

    def test_creases_of_the_file_count(self):
        tail = "".join(f"t crease 2/1/0 {a} {b} 10\n" for a, b in ((0, 1), (1, 3), (3, 2), (2, 0)))
        vertices, _ = read_obj(self.subdivided(CUBE, "catmull-clark", 3, tail=tail))
        ring = vertices[np.isclose(vertices[:, 2], -1)]
        self.assertGreater(len(ring), 30)  # the crease and what is between stay in the plane

    def test_texture_places_keep_their_seams(self):
        path = self.path("uv.obj")
        with open(path, "w", encoding="ascii") as file:  # a square for each face: seams everywhere
            file.writelines("v {} {} {}\n".format(*v) for v in CUBE[0])
            file.writelines(f"vt {k + u} {v}\n" for k in range(6) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)))
            for k, face in enumerate(CUBE[1]):
                file.write(f"usemtl m{k}\nf " + " ".join(f"{v + 1}/{4 * k + c + 1}" for c, v in enumerate(face)) + "\n")
        fine = self.path("fine_uv.obj")
        report = self.json("subdivide", path, fine, "--scheme", "catmull-clark", "--levels", 2)
        self.assertEqual(report["left_out"], [])
        lines = contents_of(fine).decode().splitlines()
        places = np.array([list(map(float, l.split()[1:3])) for l in lines if l.startswith("vt ")])
        self.assertEqual(len(places), 6 * 25)  # none is shared by two faces of the cube
        self.assertEqual(sorted({*(places % 0.25).ravel()}), [0])
        material, faces = None, 0
        for words in map(str.split, lines):
            if words[:1] == ["usemtl"]:
                material = int(words[1][1:])
            elif words[:1] == ["f"]:
                u = [places[int(w.split("/")[1]) - 1][0] for w in words[1:]]
                self.assertTrue(material <= min(u) and max(u) <= material + 1)
                faces += 1
        self.assertEqual(faces, 96)
        source = self.path("coarse.relief")  # and back to a coarser level
        self.json("encode", fine, source, "--max-error", 0.001)
        self.json("decode", source, path, "--level", 1)
        places = {tuple(map(float, l.split()[1:3])) for l in contents_of(path).decode().splitlines() if l.startswith("vt ")}
        self.assertEqual(places, {(k + u / 2, v / 2) for k in range(6) for u in range(3) for v in range(3)})

    def test_bad_requests(self):
        self.refuse(1, "subdivide", self.mesh(CUBE), self.path("x.obj"), "--scheme", "loop",
                    says="not_triangles")
        self.refuse(2, "subdivide", self.mesh(CUBE), self.path("x.obj"), says="--scheme")
        self.refuse(1, "subdivide", self.mesh(CUBE), self.path("x.obj"), "--scheme",
                    "catmull-clark", "--levels", 30, says="too_many_elements")


class RoundTrips(Meshes):
    def test_goals(self):
        for scheme, base, levels in (("loop", OCTAHEDRON, 4), ("sqrt3", OCTAHEDRON, 5),
                                     ("catmull-clark", CUBE, 4)):
            with self.subTest(scheme=scheme):
                source = self.subdivided(base, scheme, levels, noise=0.002)
                file, report = self.encoded(source, "--max-error", 0.001, "--scheme", scheme)
                self.assertEqual(list(report), ENCODE_KEYS)
                self.assertEqual((report["scheme"], report["levels"]), (scheme, levels))
                self.assertLessEqual(report["max_error"], 0.001)
                back = self.path("back.obj")
                decode = self.json("decode", file, back)
                self.assertEqual(decode["bytes_read"], report["bytes"])
                wanted, faces = read_obj(source)
                found, same_faces = read_obj(back)
                self.assertEqual(faces, same_faces)
                error = np.linalg.norm(wanted - found, axis=1)
                self.assertAlmostEqual(error.max(), report["max_error"], delta=1e-14)
                compared = self.json("compare", source, back)
                self.assertAlmostEqual(compared["rms_error"], report["rms_error"], delta=1e-14)
                self.assertFalse(compared["faces_differ"])
                surface = self.json("compare", source, back, "--surface")
                self.assertLessEqual(surface["max_error"], 0.001)
                _, rms = self.encoded(source, "--rms-error", 0.0005, "--scheme", scheme)
                self.assertLessEqual(rms["rms_error"], 0.0005)
                _, small = self.encoded(source, "--bytes", 700, "--scheme", scheme)
                self.assertLessEqual(small["bytes"], 700)
                exact, _ = self.encoded(source, "--scheme", scheme)
                self.json("decode", exact, back)
                np.testing.assert_array_equal(read_obj(back)[0], wanted)

    def test_levels_prefixes_and_threads(self):
        source = self.subdivided(CUBE, "catmull-clark", 4, noise=0.002)
        file, report = self.encoded(source, "--max-error", 0.002)
        info = self.json("info", file)
        self.assertTrue(info["checksums_ok"])
        self.assertEqual(info["levels"], report["levels"])
        for level in info["level_list"]:
            out = self.path("level.obj")
            self.json("decode", file, out, "--level", level["level"], "--bytes", level["bytes"])
            vertices, faces = read_obj(out)
            self.assertEqual((len(vertices), len(faces)), (level["vertices"], level["faces"]))
        other, _ = self.encoded(source, "--max-error", 0.002, "--threads", 1)
        self.assertEqual(contents_of(file), contents_of(other))

    def test_edits_turn_details(self):
        source = self.subdivided(CUBE, "catmull-clark", 3, noise=0.01)
        file, _ = self.encoded(source, "--max-error", 1e-4)
        base = self.path("base.obj")
        self.json("decode", file, base, "--level", 3)
        corners, _ = read_obj(base)
        moves = []
        for k, (x, y, z) in enumerate(corners):  # a quarter turn and twice the size
            moves += ["--move", f"{k}:{-2 * y - x!r},{2 * x - y!r},{z!r}"]
        edited = self.path("edited.relief")
        report = self.json("edit", file, edited, "--level", 3, *moves)
        self.assertEqual(report["moved"], 8)
        before, _ = read_obj(self.decoded(file))
        after, _ = read_obj(self.decoded(edited))
        turned = np.stack([-2 * before[:, 1], 2 * before[:, 0], 2 * before[:, 2]], axis=1)
        np.testing.assert_allclose(after, turned, atol=1e-10)
        self.refuse(2, "edit", file, edited, "--level", 3, "--move", "8:0,0,0", says="vertex 8")
        self.refuse(2, "edit", file, edited, "--level", 3, "--move", "1:2", says="INDEX:DX,DY,DZ")

    def decoded(self, file):
        out = self.path("decoded.obj")
        self.json("decode", file, out)
        return out

    def test_what_is_no_subdivision(self):
        self.refuse(1, "encode", self.mesh(OCTAHEDRON), self.path("x.relief"),
                    says="no_subdivision_connectivity")
        self.refuse(1, "encode", self.mesh(CUBE), self.path("x.relief"),
                    says="no_subdivision_connectivity")

    def test_repair(self):
        source = self.subdivided(OCTAHEDRON, "loop", 2)
        vertices, faces = read_obj(source)
        faces[5] = faces[5][::-1]
        broken = self.mesh((vertices.tolist() + [(9, 9, 9)], faces + [faces[7]]), "broken.obj")
        info = self.json("info", broken)
        self.assertFalse(info["healthy"])
        self.refuse(1, "encode", broken, self.path("x.relief"), says="--repair")
        _, report = self.encoded(broken, "--repair", "--max-error", 1e-6)
        self.assertEqual((report["samples"], report["levels"]), (len(vertices), 2))

    def test_distances_of_surfaces(self):
        source = self.subdivided(OCTAHEDRON, "loop", 4, noise=0.002)
        _, plain = self.encoded(source, "--rms-error", 0.001)
        for goal, key in (("--max-error", "max_error"), ("--rms-error", "rms_error")):
            file, report = self.encoded(source, goal, 0.001, "--surface")
            self.assertEqual(report["distance"], "surface")
            self.assertLessEqual(report[key], 0.001)
            compared = self.json("compare", source, file, "--surface")
            for number in ("max_error", "rms_error"):  # the same points are measured
                self.assertAlmostEqual(compared[number], report[number], delta=1e-15)
                self.assertAlmostEqual(self.json("info", file)[number] / report[number], 1, delta=1e-3)
            self.assertEqual(self.json("info", file)["distance"], "surface")
        self.assertLess(report["bytes"], 0.9 * plain["bytes"])
        self.refuse(2, "encode", self.mesh(GRID), self.path("x.relief"), "--surface", says="--surface")

    def test_reorder(self):
        vertices, faces = read_obj(self.subdivided(OCTAHEDRON, "loop", 4, noise=0.001))
        number = np.random.default_rng(2).permutation(len(vertices))
        mixed = np.empty_like(vertices)
        mixed[number] = vertices
        source = self.mesh((mixed.tolist(), [[int(number[v]) for v in f] for f in faces[::-1]]), "m.obj")
        _, kept = self.encoded(source, "--max-error", 0.001)
        _, free = self.encoded(source, "--max-error", 0.001, "--reorder")
        self.assertLess(2 * free["bytes"], kept["bytes"])

    def test_orders_by_rule_cost_little(self):
        vertices, faces = read_obj(self.subdivided(OCTAHEDRON, "loop", 4, noise=0.001))
        number = {}  # as faces name them first, and every face begins elsewhere
        for face in faces:
            for v in face[1:] + face[:1]:
                number.setdefault(v, len(number))
        turned = [[number[v] for v in face[1:] + face[:1]] for face in faces]
        source = self.mesh((vertices[sorted(number, key=number.get)].tolist(), turned), "n.obj")
        file, kept = self.encoded(source, "--max-error", 0.001)
        self.assertFalse(self.json("compare", source, file)["faces_differ"])
        _, free = self.encoded(source, "--max-error", 0.001, "--reorder")
        self.assertLess(kept["bytes"] - free["bytes"], 100)


class Files(Meshes):
    def test_lifts_and_alpha(self):
        source = self.subdivided(OCTAHEDRON, "sqrt3", 4, noise=0.01)
        sizes = {}
        for options in ([], ["--lift", "none"], ["--lift", "ring"], ["--lift", "chebyshev"],
                        ["--lift", "least-squares"], ["--scheme", "sqrt3", "--alpha", 0.125]):
            file, report = self.encoded(source, "--max-error", 0.005, *options)
            back = self.path("back.obj")
            self.json("decode", file, back)
            self.assertLessEqual(self.json("compare", source, back)["max_error"], 0.005)
            sizes[" ".join(map(str, options))] = report["bytes"]
        self.assertEqual(sizes[""], sizes["--lift chebyshev"])
        self.assertLess(sizes[""], sizes["--lift none"])
        self.assertLess(sizes[""], 1.05 * sizes["--lift least-squares"])
        out = self.path("x.relief")
        self.refuse(2, "encode", source, out, "--lift", "most", says="--lift")
        self.refuse(2, "encode", source, out, "--alpha", 0.1, says="--scheme sqrt3")
        self.refuse(2, "encode", source, out, "--scheme", "sqrt3", "--alpha", 0.7, says="invalid_parameter")

    def test_glb_of_a_level(self):
        file, _ = self.encoded(self.subdivided(CUBE, "catmull-clark", 3), "--max-error", 0.001)
        out = self.path("cube.glb")
        self.json("decode", file, out, "--level", 1)
        head = contents_of(out)[:12]
        self.assertEqual(struct.unpack("<4sI", head[:8]), (b"glTF", 2))

    def test_pictures(self):
        source = self.subdivided(CUBE, "catmull-clark", 3, noise=0.01)
        file, _ = self.encoded(source, "--max-error", 0.01)
        for options in ((), ("--style", "wire", "--level", 3), ("--level", 2), ("--up", "y"),
                        ("--style", "error", "--reference", source)):
            picture = self.path("picture.png")
            report = self.json("render", file, picture, "--width", 300, *options)
            self.assertEqual(report["width"], 300)
            self.assertEqual(contents_of(picture)[:4], b"\x89PNG")

    def test_error_pictures(self):
        reference = self.mesh(CUBE, "reference.obj")
        larger = self.mesh(([[1.25 * x for x in corner] for corner in CUBE[0]], CUBE[1]), "larger.obj")
        picture = self.path("picture.png")

        def colour(reference, scale):
            """In the middle of the picture, of a cube whose corners are 0.25 sqrt(3) away from the reference."""
            self.json("render", larger, picture, "--width", 200, "--style", "error", "--reference", reference, "--scale", scale)
            return gdal.Open(picture).ReadAsArray()[:3, 80, 100].astype(int)

        # The diagonal of the reference is 2 sqrt(3): they are an eighth of it away.
        np.testing.assert_array_equal(colour(reference, "0.125d"), colour(reference, 0.25 * 3**0.5))
        red, pale = colour(reference, "0.125d"), colour(reference, "10d")
        self.assertGreater(red[0] - red[2], 40)
        self.assertLess(pale[0] - pale[2], 20)
        raster = self.raster("flat.tif", np.zeros((30, 30)))
        self.refuse(2, "render", raster, self.path("no.png"), "--style", "error", "--reference", raster, "--scale", "1d",
                    says="meshes")
        self.refuse(2, "render", reference, self.path("no.png"), "--scale", "1e", says="1e")

    def test_real_meshes(self):
        folder = os.path.join(DATA, "meshes")
        if not os.path.isdir(folder):
            self.skipTest("RELIEF_DATA has no meshes")
        for name, scheme, levels in (("mushroom.off", "loop", 2), ("camel.off", "loop", 1),
                                     ("osd_loop_icosahedron_level4.obj", "loop", 5),
                                     ("osd_catmark_cube_level4.obj", "catmull-clark", 5)):
            source = os.path.join(folder, name)
            diagonal = self.json("compare", source, source)["diagonal"]
            file, report = self.encoded(source, "--max-error", 1e-4 * diagonal)
            self.assertEqual((report["scheme"], report["levels"]), (scheme, levels), name)
            compared = self.json("compare", source, file)
            self.assertLessEqual(compared["max_error"], 1e-4 * diagonal)
            self.assertTrue(math.isfinite(compared["rms_error"]))


if __name__ == "__main__":
    main()
