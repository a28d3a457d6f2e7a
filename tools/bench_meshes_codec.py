"""Runs relief_mesh_codecs over meshes with subdivision connectivity, and says in tables how relief stands beside Draco."""
import json
import math
import pathlib
import subprocess

import bench_peers
from bench_meshes import DATA
from bench_peers import markdown, met, number

PROGRAM = pathlib.Path("bench") / "peers" / "relief_mesh_codecs"
# Those of the folder that are subdivisions of something.
FILES = ("mushroom.off", "camel.off", "hemisphere.off", "osd_loop_saddle_edgecorner_level4.obj",
         "osd_catmark_cube_level4.obj", "osd_catmark_tent_level4.obj")

# Bytes of relief over those of Draco at most, by kind of mesh and goal.
RATIO_TARGETS = {"smooth": {("surface rms", 1e-3): 0.20, ("surface rms", 3e-4): 0.40, ("surface rms", 1e-4): 0.35,
                            ("vertex max", 1e-4): 0.40},
                 "rough": {("surface rms", 1e-3): 0.20, ("surface rms", 3e-4): 0.40, ("surface rms", 1e-4): 0.70,
                           ("vertex max", 1e-4): 0.40}}
EXACT_TARGET = 0.02  # bits a vertex beside the base


class Lines:
    """What relief_mesh_codecs printed."""

    def __init__(self, lines: list[dict]):
        self.libraries = lines[0]["libraries"]
        ours = [line for line in lines[1:] if line["codec"] == "relief"]
        self.of = {(line["mesh"], line["goal"], line["value"]): line for line in ours}
        self.goals = list(dict.fromkeys((line["goal"], line["value"]) for line in ours))
        self.meshes = list({line["mesh"]: line for line in ours}.values())
        self.draco = {mesh["mesh"]: sorted((line["surface rms"], line["vertex max"], line["bytes"]) for line in lines[1:]
                                           if line["codec"] == "Draco" and line["mesh"] == mesh["mesh"]) for mesh in self.meshes}

    def of_draco(self, mesh: str, goal: str, error: float) -> float | None:
        """Bytes of Draco at an error: between two of its files, linear in the logarithm of the error."""
        points = [(rms if goal == "surface rms" else most, size) for rms, most, size in self.draco[mesh]]
        for (low, more), (high, less) in zip(points, points[1:]):
            if low <= error <= high:
                share = math.log(error / low) / math.log(high / low)
                # Where fewer bits give larger files, nobody takes them.
                return min(more, more + share * (less - more))
        return None

    def ratio(self, mesh: str, goal: tuple[str, float]) -> float | None:
        """Bytes of relief over those of Draco at the error that relief has."""
        line = self.of[mesh, *goal]
        theirs = self.of_draco(mesh, goal[0], line["error"])
        return line["bytes"] / theirs if theirs else None


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> Lines:
    files = [] if quick else ["--waves", *(DATA / name for name in FILES if (DATA / name).exists())]
    raw = output / "mesh_codecs.jsonl"
    with raw.open("w") as out:
        subprocess.run([build / PROGRAM, "--exact", *files], check=True, stdout=out)
    return Lines([json.loads(line) for line in raw.read_text().splitlines()])


def kind_of(mesh: str) -> str | None:
    return next((kind for kind in RATIO_TARGETS if mesh.startswith(kind)), None)


def goal_names(lines: Lines) -> list[str]:
    return [f"{goal} {value:g}" for goal, value in lines.goals]


def ratios(lines: Lines) -> str:
    rows = []
    for mesh in lines.meshes:
        name, kind = mesh["mesh"], kind_of(mesh["mesh"])
        values = [lines.ratio(name, goal) for goal in lines.goals]
        targets = [RATIO_TARGETS[kind][goal] for goal in lines.goals] if kind else []
        rows.append((name, f"{mesh['scheme']}, {mesh['levels']} over {mesh['base_vertices']}", str(mesh["vertices"]),
                     *(number(value) for value in values), " / ".join(f"{target:g}" for target in targets),
                     " / ".join(met(value, target) for value, target in zip(values, targets))))
    return markdown(("mesh", "scheme, levels over base vertices", "vertices", *goal_names(lines), "target", "met"), rows)


def sizes(lines: Lines) -> str:
    rows = [(mesh["mesh"], *(str(lines.of[mesh["mesh"], *goal]["bytes"]) for goal in lines.goals), str(mesh["order_bytes"]))
            for mesh in lines.meshes]
    return markdown(("mesh", *goal_names(lines), "to keep numbers"), rows)


def exact(lines: Lines) -> str:
    """Bits beside the base where nothing but the base has anything to say."""
    rows = []
    for mesh in lines.meshes:
        if "surface" not in mesh["mesh"]:
            continue
        files = [lines.of[mesh["mesh"], *goal] for goal in lines.goals if goal[1] == 1e-4]
        bits = [8 * (line["bytes"] - line["base_bytes"]) / line["vertices"] for line in files]
        rows.append((mesh["mesh"], *(f"{line['base_bytes']}" for line in files), *(number(value, "%.4f") for value in bits),
                     f"<= {EXACT_TARGET:g}", " / ".join(met(value, EXACT_TARGET) for value in bits)))
    kinds = [goal for goal, value in lines.goals if value == 1e-4]
    return markdown(("mesh", *(f"base, {kind}" for kind in kinds), *(f"bits beside it, {kind}" for kind in kinds), "target", "met"),
                    rows)


SECTIONS = [("Meshes: bytes over those of Draco at the same error", ratios), ("Meshes: bytes", sizes),
            ("Meshes: subdivision surfaces, errors of 1e-4", exact)]


def report(lines: Lines) -> str:
    return bench_peers.sections(lines, SECTIONS)
