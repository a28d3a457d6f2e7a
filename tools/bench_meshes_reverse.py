"""Runs benchmarks of reverse subdivision, and says in a table how fast it is and how much memory it takes."""
import pathlib

import bench_counters
from bench_peers import markdown, met, number

PROGRAM = bench_counters.PROGRAM
# Stages, whether they depend on the order of vertices and faces, and what they count.
STAGES = [("build", True, "faces"), ("recognise", True, "faces"), ("analyse/plain", False, "faces"),
          ("analyse/lifted", False, "faces"), ("synthesise/plain", False, "vertices"),
          ("synthesise/lifted", False, "vertices"), ("decompose", True, "faces")]
SCHEMES = ["sqrt3", "loop", "catmull-clark"]
# 10^6 a second, by scheme, in the order of subdivision: recognition and lifted analysis together, faces; synthesis, vertices.
BACKWARDS_TARGETS, SYNTHESIS_TARGET = {"sqrt3": 8, "loop": 8, "catmull-clark": 4}, 30
MEMORY_TARGET = 60  # bytes a face, beside the mesh


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> dict[str, dict]:
    """The counters of all stages; quick: of those of Loop in the order of subdivision."""
    stages = "|".join(stage for stage, _, _ in STAGES)
    cases = "scheme:1/shuffled:0" if quick else ".*"
    return bench_counters.run(build, f"^mesh/({stages})/{cases}/threads:1(/|$)", output / "raw.json")


def of_stage(results: dict[str, dict], stage: str, scheme: str, shuffled: bool, counter: str) -> float | None:
    name = f"mesh/{stage}/scheme:{SCHEMES.index(scheme)}/shuffled:{int(shuffled)}/threads:1"
    return results.get(name, {}).get(counter)


def backwards(results: dict[str, dict], scheme: str) -> float | None:
    """Recognition and lifted analysis, one after the other, in the order of subdivision."""
    parts = [of_stage(results, stage, scheme, False, "M_per_s") for stage in ("recognise", "analyse/lifted")]
    return 1 / sum(1 / part for part in parts) if all(parts) else None


def table(results: dict[str, dict]) -> str:
    rows = []
    for stage, ordered, what in STAGES:
        target = SYNTHESIS_TARGET if stage.startswith("synthesise") else None
        for shuffled in (False, True)[:1 + ordered]:
            values = [of_stage(results, stage, scheme, shuffled, "M_per_s") for scheme in SCHEMES]
            rows.append((stage.replace("/", ", ") + (", shuffled" if shuffled else ""), "10^6 %s/s" % what,
                         *(number(value, "%.1f") for value in values), f">= {target}" if target else "",
                         " / ".join(met(value, target, True) for value in values) if target else ""))
    values = [backwards(results, scheme) for scheme in SCHEMES]
    rows.append(("recognise and analyse, lifted", "10^6 faces/s", *(number(value, "%.1f") for value in values),
                 ">= " + " / ".join(str(BACKWARDS_TARGETS[scheme]) for scheme in SCHEMES),
                 " / ".join(met(value, BACKWARDS_TARGETS[scheme], True) for value, scheme in zip(values, SCHEMES))))
    values = [of_stage(results, "decompose", scheme, False, "bytes_per_face") for scheme in SCHEMES]
    rows.append(("decompose, peak memory", "bytes/face", *(number(value, "%.0f") for value in values),
                 f"<= {MEMORY_TARGET}", " / ".join(met(value, MEMORY_TARGET) for value in values)))
    return markdown(("stage", "", *SCHEMES, "target", "met"), rows)


def report(results: dict[str, dict]) -> str:
    return "### Meshes: reverse subdivision\n\n" + table(results)
