"""Remeshes and encodes scans by the tool, and says in tables how the files stand beside simplification and Draco."""
import json
import pathlib
import statistics
import subprocess
import sys

import bench_peers
from bench_meshes import DATA
from bench_peers import markdown, met, number

PROGRAM = pathlib.Path("bench") / "peers" / "relief_remesh_codecs"
# Scans, and options that they are remeshed with.
SCANS = {"bunny00.off": [], "armadillo.off": [], "man.off": [], "bear.off": [], "camel.off": [], "lion-head.off": [],
         "blade.off": [], "fandisk.off": ["--features", "40"], "bull.off": [], "elephant.off": []}
# RMS distances from the scan, fractions of its diagonal, and those that files have targets at.
GOALS, JUDGED = (1e-3, 4e-4, 3e-4), (4e-4, 3e-4)
# What files are made with: the usual effort for all goals, and the search for the smallest file for one.
FILES = [(goal, 1) for goal in GOALS] + [(3e-4, 2)]
RATIO_TARGET, MEDIAN_TARGET = 0.45, 0.33
# At most, of the mesh itself; seconds for 100 000 triangles; bytes a triangle.
REMESH_TARGETS = {"rms_error": 2e-4, "max_error": 2e-3, "flips": 0, "pace": 10, "memory": 1000}


class Lines:
    """libraries, remeshes: [scan], files: [scan, goal, effort]; a run that was refused has a `reason`."""

    def __init__(self):
        self.libraries: dict[str, str] = {}
        self.remeshes: dict[str, dict] = {}
        self.files: dict[tuple[str, float, int], dict] = {}

    def ratio(self, case: tuple[str, float, int], peer: str) -> float | None:
        line = self.files[case]
        return line["bytes"] / line[peer]["bytes"] if line.get(peer) else None


# A process begins with the peak of the one that it was forked from: so that is a small one, and not this.
RUN = """
import json, resource, subprocess, sys, time
begin = time.monotonic()
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([done.returncode, done.stdout, done.stderr, used.ru_utime + used.ru_stime, time.monotonic() - begin,
                  1024 * used.ru_maxrss]))
"""


def measured(command: list, threads: int = 1) -> dict:
    """What a run of the tool prints, with the time of its threads, the time that passed and the most memory that it had."""
    done = subprocess.run([sys.executable, "-S", "-c", RUN, *map(str, command), "--json", "--threads", str(threads)],
                          check=True, capture_output=True, text=True)
    status, printed, complaint, seconds, passed, peak = json.loads(done.stdout)
    line = {"seconds": seconds, "passed": passed, "peak": peak}
    if status != 0:
        return {**line, "reason": complaint.strip()}
    return {**json.loads(printed or "{}"), **line}


def quick_scan(tool: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """A subdivided octahedron of 2048 triangles."""
    base, scan = folder / "octahedron.obj", folder / "small.ply"
    subprocess.run([tool, "sample", "octahedron", base, "-q"], check=True)
    subprocess.run([tool, "subdivide", base, scan, "--scheme", "loop", "--levels", "4", "-q"], check=True)
    return scan


def run_scan(lines: Lines, build: pathlib.Path, folder: pathlib.Path, scan: pathlib.Path, options: list[str]):
    relief, peers = build / "relief", build / PROGRAM
    name, goals = scan.stem, {}
    idle = measured([relief, "sample", "octahedron", folder / "idle.obj"])["peak"]
    triangles = json.loads(subprocess.run([relief, "info", scan, "--json"], check=True, capture_output=True).stdout)["polygons"]
    remesh = [relief, "remesh", scan, folder / f"{name}.ply", *options]
    lines.remeshes[name] = {"triangles": triangles, "idle": idle, "two": measured(remesh, 2)["passed"], **measured(remesh)}
    for goal, effort in FILES:
        file = folder / f"{name}-{goal:g}-{effort}.relief"
        line = measured([relief, "encode", scan, file, "--remesh", "--rms-error", f"{goal:g}d", "--effort", effort, *options])
        lines.files[name, goal, effort] = line if "reason" in line else {
            "seconds": line["seconds"], "base": line["remesh"]["base_faces"], "levels": line["levels"]}
        if "reason" not in line:
            goals[file.stem] = goal, effort
    done = subprocess.run([peers, scan, *(folder / f"{file}.relief" for file in goals)], check=True, capture_output=True,
                          text=True)
    libraries, *found = map(json.loads, done.stdout.splitlines())
    lines.libraries = libraries["libraries"]
    for line in found:
        lines.files[name, *goals[line["file"]]].update(line)


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> Lines:
    scans = {DATA / name: options for name, options in SCANS.items() if (DATA / name).exists()}
    lines = Lines()
    for scan, options in ({quick_scan(build / "relief", output): []} if quick else scans).items():
        run_scan(lines, build, output, scan, options)
    records = [{"scan": scan, **line} for scan, line in lines.remeshes.items()]
    records += [{"scan": scan, "goal": goal, "effort": effort, **line}
                for (scan, goal, effort), line in lines.files.items()]
    (output / "remesh.jsonl").write_text("".join(json.dumps(record) + "\n" for record in records))
    return lines


def name_of(reason: str) -> str:
    """Of an error: "relief VERB: FILE: NAME: .."."""
    parts = reason.split(": ")
    return parts[2].split(";")[0] if len(parts) > 2 else reason or "killed"


def files(lines: Lines) -> str:
    rows = []
    for case, line in lines.files.items():
        scan, goal, effort = case
        if "reason" in line:
            rows.append((scan, f"{goal:g}", str(effort), name_of(line["reason"]), *[""] * 10))
            continue
        ratio, peer = lines.ratio(case, "peer"), line["peer"]
        way = f"{peer['simplifier']}, {peer['faces']} faces, {peer['bits']} bits" if peer else ""
        rows.append((scan, f"{goal:g}", str(effort), f"{line['base']}, {line['levels']}", f"{line['rms']:.2g}",
                     f"{line['largest']:.2g}", f"{line['seconds']:.1f}", str(line["bytes"]), str(peer["bytes"]) if peer else "", way,
                     number(ratio), *((f"<= {RATIO_TARGET}", met(ratio, RATIO_TARGET)) if goal in JUDGED else ("", "")),
                     number(lines.ratio(case, "draco"))))
    return markdown(("scan", "goal", "effort", "base, levels", "RMS", "largest", "s", "bytes", "simplify + Draco", "its smallest",
                     "ratio", "target", "met", "ratio to Draco alone"), [*rows, *medians(lines)])


def medians(lines: Lines) -> list:
    rows = []
    for effort in sorted({effort for _, effort in FILES}):
        goals = [goal for goal, of in FILES if of == effort and goal in JUDGED]
        ratios = [lines.ratio(case, "peer") for case, line in lines.files.items()
                  if case[1] in goals and case[2] == effort and line.get("peer")]
        if ratios:
            median = statistics.median(ratios)
            rows.append(("median", " and ".join(f"{goal:g}" for goal in goals), str(effort), *[""] * 7, number(median),
                         f"<= {MEDIAN_TARGET}", met(median, MEDIAN_TARGET), ""))
    return rows


def remeshes(lines: Lines) -> str:
    rows = []
    targets = " / ".join(f"{target:g}" for target in REMESH_TARGETS.values())
    for scan, line in lines.remeshes.items():
        pace, memory = 1e5 * line["two"] / line["triangles"], (line["peak"] - line["idle"]) / line["triangles"]
        costs = f"{line['seconds']:.1f}", f"{line['two']:.1f}", f"{pace:.1f}", f"{memory:.0f}"
        if "reason" in line:
            rows.append((scan, str(line["triangles"]), name_of(line["reason"]), *[""] * 5, *costs, targets, "no"))
            continue
        values = {**line, "pace": pace, "memory": memory,
                  **{key: line[key] / line["diagonal"] for key in ("rms_error", "max_error")}}
        rows.append((scan, str(line["triangles"]), f"{line['base_faces']}, {line['levels']}", str(line["vertices"]),
                     f"{values['rms_error']:.2g}", f"{values['max_error']:.2g}", str(line["flips"]), f"{line['quality']:.2f}", *costs, targets,
                     " / ".join("yes" if values[key] <= target else "no" for key, target in REMESH_TARGETS.items())))
    return markdown(("scan", "triangles", "base, levels", "vertices", "RMS", "largest", "flips", "quality", "s", "s on two threads",
                     "s for 100 000 on two", "bytes a triangle", "target", "met"), rows)


SECTIONS = [("Scans: files, from scan to file", files), ("Scans: the remesh itself", remeshes)]


def report(lines: Lines) -> str:
    return bench_peers.sections(lines, SECTIONS)
