"""Runs relief_mesh_peers over base meshes, and says in tables how relief stands at forward subdivision."""
import json
import os
import pathlib
import subprocess

import bench_peers
from bench_peers import markdown, met, number

PROGRAM = pathlib.Path("bench") / "peers" / "relief_mesh_peers"
# Scans and models, where the folder of data is there.
DATA = pathlib.Path(os.environ.get("RELIEF_DATA", bench_peers.ROOT.parent / "shared" / "data")) / "meshes"
FILES = ["elephant.off", "camel.off", "armadillo.off", "three_peaks.off", "fandisk_quads.off", "spot_quadrangulated.obj"]

OURS, DOUBLE = "relief", "relief double"
# What relief is to be faster than, and how many times: faces and points into fresh memory, into kept memory, points.
TARGETS = {
    "loop": ("OpenSubdiv", {"first": 4, "kept": 8, "points": 3}),
    "catmull-clark": ("OpenSubdiv", {"first": 4, "kept": 8, "points": 3}),
    "sqrt3": ("CGAL", {"first": 15, "kept": 15}),
}


class Lines:
    """What relief_mesh_peers printed."""

    def __init__(self, lines: list[dict]):
        self.libraries = lines[0]["libraries"]
        self.all = {(l["scheme"], l["mesh"], l["library"]): l for l in lines[1:]}
        self.cases = list(dict.fromkeys((l["scheme"], l["mesh"], l["faces"]) for l in lines[1:]))

    def speed(self, case: tuple, library: str, what: str) -> float | None:
        """Millions of faces a second, of the best run."""
        scheme, mesh, faces = case
        line = self.all.get((scheme, mesh, library), {})
        return 1e-6 * faces / line[what]["best"] if what in line else None


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> Lines:
    files = [] if quick else [DATA / name for name in FILES if (DATA / name).exists()]
    raw = output / "meshes.jsonl"
    with raw.open("w") as out:
        subprocess.run([build / PROGRAM, *(["--once"] if quick else []), *files], check=True, stdout=out)
    return Lines([json.loads(line) for line in raw.read_text().splitlines()])


def ratio(lines: Lines, case: tuple, what: str) -> float | None:
    """How many times as fast as the library of the target relief is. Kept memory is a feature that peers lack."""
    peer = TARGETS[case[0]][0]
    ours, theirs = lines.speed(case, OURS, what), lines.speed(case, peer, "points" if what == "points" else "first")
    return ours / theirs if ours and theirs else None


def speeds(lines: Lines) -> str:
    rows = []
    for case in lines.cases:
        cells = [lines.speed(case, OURS, what) for what in ("first", "kept", "points")]
        cells += [lines.speed(case, DOUBLE, what) for what in ("first", "kept")]
        cells += [lines.speed(case, peer, "first") for peer in ("OpenSubdiv", "OpenMesh", "CGAL")]
        cells += [lines.speed(case, "OpenSubdiv", "points")]
        rows.append((case[0], case[1], f"{1e-6 * case[2]:.2f}", *(number(cell, "%.1f") for cell in cells)))
    return markdown(("scheme", "base", "10^6 faces", "first call", "kept memory", "points", "double, first", "double, kept",
                     "OpenSubdiv", "OpenMesh", "CGAL", "OpenSubdiv, points"), rows)


def ratios(lines: Lines) -> str:
    rows = []
    for case in lines.cases:
        peer, targets = TARGETS[case[0]]
        values = [ratio(lines, case, what) for what in targets]
        rows.append((case[0], case[1], peer, *(number(value, "%.1f") for value in values), *[""] * (3 - len(values)),
                     " / ".join(map(str, targets.values())),
                     " / ".join(met(value, target, True) for value, target in zip(values, targets.values()))))
    return markdown(("scheme", "base", "times as fast as", "first call", "kept memory", "points", "target", "met"), rows)


SECTIONS = [("Meshes: forward subdivision, 10^6 faces a second", speeds), ("Meshes: forward subdivision against its peers", ratios)]


def report(lines: Lines) -> str:
    return bench_peers.sections(lines, SECTIONS)
