"""Texture places and materials of a sqrt(3) mesh through files, at all levels, end to end."""

import numpy as np

from harness import Case, main

OCTAHEDRON = ([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
              [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])


class Obj:
    """Faces as corners (vertex, texture place or None), and the material of each."""

    def __init__(self, path):
        self.vertices, self.places, self.faces, self.materials = [], [], [], []
        material = None
        with open(path, encoding="ascii") as file:
            for words in map(str.split, file):
                if words[:1] == ["v"]:
                    self.vertices.append(tuple(map(float, words[1:4])))
                elif words[:1] == ["vt"]:
                    self.places.append(tuple(map(float, words[1:3])))
                elif words[:1] == ["usemtl"]:
                    material = words[1]
                elif words[:1] == ["f"]:
                    self.faces.append([self.corner(word) for word in words[1:]])
                    self.materials.append(material)

    def corner(self, word):
        numbers = word.split("/")
        return int(numbers[0]) - 1, int(numbers[1]) - 1 if numbers[1:2] and numbers[1] else None

    def heights(self, face):
        return [self.vertices[v][2] for v, _ in face]

    def places_of(self, face):
        return [None if place is None else self.places[place] for _, place in face]


def write(path, mesh, charts):
    """Two charts: (x, y) above the equator, and (x + 10, y) below it; a material for each."""
    number = {}
    lines = ["v {!r} {!r} {!r}\n".format(*v) for v in mesh.vertices]
    for v, (x, y, _) in enumerate(mesh.vertices):
        for chart in range(2):
            number[v, chart] = len(number) + 1
            lines.append(f"vt {x + 10 * chart!r} {y!r}\n")
    for face, chart in zip(mesh.faces, charts):
        lines.append(f"usemtl m{chart}\nf " + " ".join(f"{v + 1}/{number[v, chart]}" for v, _ in face) + "\n")
    with open(path, "w", encoding="ascii") as file:
        file.writelines(lines)


class Seams(Case):
    def octahedron(self, levels):
        base, plain = self.path("base.obj"), self.path("plain.obj")
        with open(base, "w", encoding="ascii") as file:
            file.writelines("v {} {} {}\n".format(*v) for v in OCTAHEDRON[0])
            file.writelines("f {} {} {}\n".format(*(v + 1 for v in face)) for face in OCTAHEDRON[1])
        self.json("subdivide", base, plain, "--scheme", "sqrt3", "--levels", levels)
        return Obj(plain)

    def test_every_level_has_places_in_the_chart_of_its_face(self):
        mesh = self.octahedron(4)
        charts = [int(np.mean(mesh.heights(face)) < 0) for face in mesh.faces]
        source, file, out = self.path("uv.obj"), self.path("uv.relief"), self.path("out.obj")
        write(source, mesh, charts)
        report = self.json("encode", source, file, "--scheme", "sqrt3", "--max-error", 0.0001)
        self.assertEqual(report["levels"], 4)
        for level in range(5):
            self.json("decode", file, out, "--level", level)
            got = Obj(out)
            self.assertEqual(len(got.faces), 8 * 3 ** (4 - level))
            across = 0
            for face, material in zip(got.faces, got.materials):
                heights, places = got.heights(face), got.places_of(face)
                crosses = min(heights) < -0.01 and max(heights) > 0.01
                across += crosses
                self.assertEqual(places.count(None), 3 if crosses else 0)
                if crosses:
                    continue
                chart = int(np.mean(heights) < 0)
                self.assertEqual(material, f"m{chart}")
                self.assertEqual([place[0] > 5 for place in places], [chart == 1] * 3)
            # Every edge of the equator at the level above and below it is flipped between them.
            self.assertEqual(across, 0 if level % 2 == 0 else 2 * 4 * 3 ** ((3 - level) // 2))

    def test_the_finest_level_is_exact(self):
        mesh = self.octahedron(3)
        charts = [k % 2 for k in range(len(mesh.faces))]  # seams everywhere
        source, file, out = self.path("uv.obj"), self.path("uv.relief"), self.path("out.obj")
        write(source, mesh, charts)
        self.json("encode", source, file, "--scheme", "sqrt3", "--max-error", 0.001)
        self.json("decode", file, out)
        before, after = Obj(source), Obj(out)
        self.assertEqual(after.materials, before.materials)
        self.assertEqual([after.places_of(f) for f in after.faces], [before.places_of(f) for f in before.faces])


if __name__ == "__main__":
    main()
