"""Runs benchmarks of the editor's server, and says in a table how long a move of a drag and a first picture take."""
import pathlib

import bench_counters
from bench_peers import markdown, met, number

PROGRAM = bench_counters.PROGRAM
SURFACES = [("raster 2049 x 2049, box", "box"), ("raster 2049 x 2049, cubic", "cubic"),
            ("raster 2049 x 2049, C1 cubic", "fvs"), ("mesh of 984 064 vertices, Loop", "loop"),
            ("mesh of 984 064 vertices, Catmull-Clark", "catmull-clark")]
FILES = [(title.replace("2049", "4096"), name) for title, name in SURFACES]
DRAG_TARGET = 8  # ms
OPEN_TARGETS = {"box": 1000, "cubic": 1000, "fvs": 1000, "loop": 1500, "catmull-clark": 1500}  # ms


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> dict[str, dict]:
    """The counters of all stages; quick: of rasters of one scheme."""
    return bench_counters.run(build, "^editor/.*/box(/|$)" if quick else "^editor/", output / "raw.json")


def value(results: dict[str, dict], name: str, counter: str) -> float | None:
    return results.get(f"editor/{name}", {}).get(counter)


def drags(results: dict[str, dict]) -> str:
    rows = []
    for title, name in SURFACES:
        for stage, note in (("drag", ""), ("drag_with_falloff", ", falloff")):
            time = value(results, f"{stage}/{name}", "median_ms")
            if time is None:
                continue
            rows.append((title + note, number(time, "%.1f"), f"<= {DRAG_TARGET}", met(time, DRAG_TARGET),
                         *(number(value(results, f"{stage}/{name}", counter), "%.0f") for counter in ("touched", "bytes")),
                         number(value(results, f"{stage}/{name}", "bytes_per_touched"), "%.1f")))
    return markdown(("one point of level 3", "ms", "target", "met", "touched", "bytes", "bytes a touched"), rows)


def opening(results: dict[str, dict]) -> str:
    rows = []
    for title, name in FILES:
        wall, all_threads, of_file, of_message = (value(results, f"open/{name}", counter) for counter in
                                                  ("median_ms", "all_threads_ms", "file_bytes", "bytes"))
        if wall is None:
            continue
        rows.append((title, number(wall, "%.0f"), number(all_threads, "%.0f"), f"<= {OPEN_TARGETS[name]}",
                     met(wall, OPEN_TARGETS[name]), number(of_file, "%.0f"), number(of_message, "%.0f")))
    return markdown(("file", "ms", "ms of all threads", "target", "met", "bytes of the file", "bytes sent"), rows)


def report(results: dict[str, dict]) -> str:
    return f"### Editor: a move of a drag\n\n{drags(results)}\n\n### Editor: from a file to the first picture\n\n{opening(results)}"
