"""Runs relief_mesh_codecs over meshes with subdivision connectivity, and says in tables how relief stands beside Draco.

tools/bench_meshes_codec.py BUILD_DIR OUTPUT_DIR prints the section "Meshes: compression" by itself.
"""
import json
import math
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = pathlib.Path(os.environ.get("RELIEF_DATA", ROOT.parent / "shared" / "data")) / "meshes"
# Those of the folder that are subdivisions of something.
FILES = ("mushroom.off", "camel.off", "hemisphere.off", "osd_loop_saddle_edgecorner_level4.obj",
         "osd_catmark_cube_level4.obj", "osd_catmark_tent_level4.obj")

# Bytes of relief over those of Draco at most, by measure and error; waves only: smooth, rough.
RATIO_TARGETS = {("surface rms", 1e-3): (0.20, 0.20), ("surface rms", 3e-4): (0.40, 0.40),
                 ("surface rms", 1e-4): (0.35, 0.70), ("vertex max", 1e-4): (0.40, 0.40)}
EXACT_TARGET = 0.02  # bits a vertex beside the base


def run(build: pathlib.Path, output: pathlib.Path) -> list[dict]:
    files = [DATA / name for name in FILES if (DATA / name).exists()]
    done = subprocess.run([build / "bench" / "peers" / "relief_mesh_codecs", "--waves", "--exact", *files],
                          check=True, capture_output=True, text=True)
    (output / "mesh_codecs.jsonl").write_text(done.stdout)
    return [json.loads(line) for line in done.stdout.splitlines()]


def of_draco(lines: list[dict], mesh: str, goal: str, error: float) -> float | None:
    """Bytes of Draco at an error: between two of its files, linear in the logarithm of the error."""
    points = sorted((line[goal], line["bytes"]) for line in lines if line.get("codec") == "Draco" and line["mesh"] == mesh)
    # Where fewer bits give larger files, nobody takes them.
    for (low, more), (high, less) in zip(points, points[1:]):
        if low <= error <= high:
            share = math.log(error / low) / math.log(high / low)
            return min(more, more + share * (less - more))
    return None


def markdown(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    lines = [head, tuple("-" * width for width in widths), *rows]
    return "\n".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths)) + " |" for line in lines)


def target_of(mesh: str, goal: str, error: float) -> float | None:
    smooth = mesh.startswith("smooth")
    if not smooth and not mesh.startswith("rough"):
        return None
    targets = RATIO_TARGETS.get((goal, error))
    return targets[0 if smooth else 1] if targets else None


def at_equal_errors(lines: list[dict]) -> str:
    rows = []
    for line in lines:
        if line.get("codec") != "relief":
            continue
        mesh, goal, error = line["mesh"], line["goal"], line["value"]
        theirs = of_draco(lines, mesh, goal, line["error"])
        ratio = line["bytes"] / theirs if theirs else None
        target = target_of(mesh, goal, error)
        rows.append((mesh, f"{line['scheme']}, {line['levels']} over {line['base_vertices']}", str(line["vertices"]),
                     f"{goal} {error:g}", str(line["bytes"]), f"{8 * line['bytes'] / line['vertices']:.3f}",
                     str(line["bytes"] + line["order_bytes"]), f"{theirs:.0f}" if theirs else "-",
                     f"{ratio:.3f}" if ratio else "-", f"<= {target:g}" if target else "",
                     ("yes" if ratio <= target else "no") if ratio and target else ""))
    return markdown(("mesh", "scheme, levels over base vertices", "vertices", "goal", "bytes", "bits a vertex",
                     "keeping numbers", "Draco", "ours / Draco", "target", "met"), rows)


def of_exact_surfaces(lines: list[dict]) -> str:
    rows = []
    for line in lines:
        if line.get("codec") == "relief" and "surface" in line["mesh"] and line["value"] == 1e-4:
            bits = 8 * (line["bytes"] - line["base_bytes"]) / line["vertices"]
            rows.append((line["mesh"], line["goal"], str(line["base_bytes"]), f"{bits:.4f}", f"<= {EXACT_TARGET:g}",
                         "yes" if bits <= EXACT_TARGET else "no"))
    return markdown(("mesh", "error 1e-4", "bytes of the base", "bits a vertex beside it", "target", "met"), rows)


def report(lines: list[dict]) -> str:
    return "\n\n".join([
        f"Draco {lines[0]['libraries']['Draco']}. Errors are fractions of the diagonal of the bounding box; *surface rms* is the larger root "
        "mean square distance of both ways at 60000 points each, *vertex max* the largest distance of a vertex from where it was. "
        "Draco: the smallest file of speeds 0, 1, 3, 5 and 7 at 5 to 20 bits, interpolated in the logarithm of the error to the error "
        "that relief has. It numbers vertices anew, so `--reorder` stands beside it; *keeping numbers* adds what the order takes. Quads go "
        "to Draco as triangles.",
        at_equal_errors(lines), of_exact_surfaces(lines)])


def main() -> int:
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    build, output = map(pathlib.Path, sys.argv[1:])
    output.mkdir(parents=True, exist_ok=True)
    print(report(run(build, output)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
