"""Runs relief_point_peers and scipy over scattered points of Franke's function, and says in tables how relief stands."""
import json
import pathlib
import subprocess
import time

import numpy

from bench_peers import markdown, met, number, sections

try:
    import scipy
    from scipy.interpolate import CloughTocher2DInterpolator
except ImportError:
    scipy = None

PROGRAM = pathlib.Path("bench") / "peers" / "relief_point_peers"
SITES, QUERIES, RASTER_SIDE, BORDER = (100_000, 1_000_000), 1_000_000, 1024, 0.05
QUICK_SITES, QUICK_QUERIES = (2_000, 10_000), 20_000
# scipy follows the triangles from the last point to the next: with more sites that takes longer than all the rest.
MOST_RANDOM_SITES = 100_000
OURS, SCIPY = "relief", "scipy, Clough-Tocher"
CGAL = "CGAL, Sibson C1"
# How many times as fast as a peer, by what is done and with how many sites.
SPEED_TARGETS = {(SCIPY, "build", 1_000_000): 6, (SCIPY, "random", 100_000): 50, (CGAL, "random", 100_000): 5,
                 (SCIPY, "raster", 100_000): 5, (SCIPY, "raster", 1_000_000): 5}
# By sites: RMS of the error inside; its maximum at the border over that inside.
RMS_TARGETS, BORDER_TARGET = {100_000: 3e-7, 1_000_000: 1e-8}, 3
MEMORY_TARGET, REFINE_TARGET, SQUARES_TARGET = 600, 3, 10  # bytes a vertex; 10^6 triangles a second; seconds


def franke(x: numpy.ndarray, y: numpy.ndarray) -> numpy.ndarray:
    return (0.75 * numpy.exp(-((9 * x - 2) ** 2 + (9 * y - 2) ** 2) / 4)
            + 0.75 * numpy.exp(-((9 * x + 1) ** 2) / 49 - (9 * y + 1) / 10)
            + 0.5 * numpy.exp(-((9 * x - 7) ** 2 + (9 * y - 3) ** 2) / 4)
            - 0.2 * numpy.exp(-((9 * x - 4) ** 2) - (9 * y - 7) ** 2))


def samples(places: numpy.ndarray) -> numpy.ndarray:
    return numpy.column_stack([places, franke(places[:, 0], places[:, 1])])


def scattered(count: int) -> numpy.ndarray:
    """Random sites of the unit square, with its corners and points along its edges, in random order."""
    random = numpy.random.default_rng(count)
    along = numpy.linspace(0, 1, int(count ** 0.5 / 4) + 2)
    ends, inner = numpy.array([0.0, 1.0]), along[1:-1]
    border = numpy.concatenate([numpy.stack(numpy.meshgrid(along, ends), axis=-1).reshape(-1, 2),
                                numpy.stack(numpy.meshgrid(ends, inner), axis=-1).reshape(-1, 2)])
    places = numpy.concatenate([border, random.uniform(size=(count - len(border), 2))])
    return samples(random.permutation(places))


def errors_of(truth: numpy.ndarray, values: numpy.ndarray) -> dict:
    error = numpy.abs(values - truth[:, 2])
    inside = ((truth[:, :2] >= BORDER) & (truth[:, :2] <= 1 - BORDER)).all(axis=1)
    return {"inner_rms": float(numpy.sqrt(numpy.mean(error[inside] ** 2))), "inner_max": float(error[inside].max()),
            "border_max": float(error[~inside].max())}


def timed(work):
    start = time.thread_time()
    result = work()
    return result, time.thread_time() - start


def summary(seconds: list[float]) -> dict:
    return {"best": min(seconds), "median": sorted(seconds)[len(seconds) // 2]}


def measure_scipy(sites: numpy.ndarray, queries: numpy.ndarray, runs: int) -> dict:
    """The same measures as relief_point_peers takes. What takes a minute runs once."""
    runs = runs if len(sites) <= MOST_RANDOM_SITES else 1
    building, painting = [], []
    middles = (numpy.arange(RASTER_SIDE) + 0.5) / RASTER_SIDE
    cols, rows = numpy.meshgrid(middles, middles)
    for _ in range(runs):
        surface, seconds = timed(lambda: CloughTocher2DInterpolator(sites[:, :2], sites[:, 2]))
        building.append(seconds)
        painting.append(timed(lambda: surface(cols, rows))[1])
    line = {"library": SCIPY, "sites": len(sites), "build": summary(building), "raster": summary(painting)}
    if len(sites) <= MOST_RANDOM_SITES:
        values, seconds = timed(lambda: surface(queries[:, :2]))
        return {**line, "random": summary([seconds]), **errors_of(queries, values)}
    cells = numpy.lexsort((queries[:, 0], (1000 * queries[:, 1]).astype(int)))
    return {**line, **errors_of(queries[cells], surface(queries[cells, :2]))}


class Lines:
    """What relief_point_peers printed, with scipy's lines."""

    def __init__(self, lines: list[dict]):
        self.libraries = {"scipy": scipy and scipy.__version__, **lines[0]["libraries"]}
        self.of = {(line["library"], line["sites"]): line for line in lines if "library" in line}
        self.costs = {line["cost"]: line for line in lines if "cost" in line}

    def best(self, library: str, sites: int, what: str) -> float | None:
        return self.of[library, sites][what]["best"] if what in self.of.get((library, sites), {}) else None

    def ratio(self, library: str, sites: int, what: str) -> float | None:
        """How many times as fast as a peer relief is."""
        ours, theirs = self.best(OURS, sites, what), self.best(library, sites, what)
        return theirs / ours if theirs else None


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> Lines:
    counts, asked = (QUICK_SITES, QUICK_QUERIES) if quick else (SITES, QUERIES)
    queries = samples(numpy.random.default_rng(0).uniform(size=(asked, 2)))
    data = {"queries": queries, **{f"sites-{count}": scattered(count) for count in counts}}
    paths = [output / f"{name}.f64" for name in data]
    for path, array in zip(paths, data.values()):
        array.tofile(path)
    done = subprocess.run([build / PROGRAM, *(["--once"] if quick else []), *paths], check=True, capture_output=True, text=True)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    if scipy:
        lines += [measure_scipy(sites, queries, 1 if quick else 3) for sites in list(data.values())[1:]]
    (output / "points.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    for path in paths:
        path.unlink()
    return Lines(lines)


def speeds(lines: Lines) -> str:
    rows = []
    for (library, sites), line in sorted(lines.of.items(), key=lambda item: item[0][1]):
        points = QUERIES if sites in SITES else QUICK_QUERIES
        seconds = lines.best(library, sites, "random")
        rate = 1e-6 * points / seconds if seconds else None
        rows.append((f"{sites}", library, f"{line['build']['best']:.3g}", number(rate, "%.3g"),
                     f"{1e-6 * RASTER_SIDE ** 2 / line['raster']['best']:.3g}"))
    return markdown(("sites", "library", "build, s", "random order, 10^6/s", f"raster {RASTER_SIDE}^2, 10^6/s"), rows)


def ratios(lines: Lines) -> str:
    rows = []
    for peer, sites in sorted(lines.of, key=lambda key: key[1]):
        if peer.startswith(OURS):
            continue
        cells = [f"{sites}", peer]
        for what in ("build", "random", "raster"):
            ratio, target = lines.ratio(peer, sites, what), SPEED_TARGETS.get((peer, what, sites))
            cells += [number(ratio, "%.3g"), number(target, ">= %g"), met(ratio, target, True)]
        rows.append(tuple(cells))
    return markdown(("sites", "times as fast as", *(name for what in ("build", "random order", "raster")
                                                    for name in (what, "target", "met"))), rows)


def accuracy(lines: Lines) -> str:
    rows = []
    for (library, sites), line in sorted(lines.of.items(), key=lambda item: item[0][1]):
        ours = library == OURS
        rms, border = line["inner_rms"], line["border_max"] / line["inner_max"]
        wanted = RMS_TARGETS.get(sites) if ours else None
        rows.append((f"{sites}", library, f"{rms:.2e}", number(wanted, "<= %.1e"),
                     "" if wanted is None else "yes" if rms <= wanted else "no", f"{line['inner_max']:.2e}", f"{line['border_max']:.2e}",
                     f"{border:.2f}", f"<= {BORDER_TARGET}" if ours else "", met(border, BORDER_TARGET) if ours else ""))
    return markdown(("sites", "library", "inner RMS", "target", "met", "inner maximum", "border maximum", "border / inner", "target",
                     "met"), rows)


def costs(lines: Lines) -> str:
    """What relief takes for the rest, beside what is asked."""
    rows = []

    def add(what: str, value: float, form: str, comparison: str = "", target: float | None = None):
        rows.append((what, form % value, f"{comparison} {target:g}" if target else "", met(value, target, comparison == ">=")))

    few, many = lines.costs["rasters"]["rasters"]
    for raster in (few, many):
        share = raster["side"] ** 2 / (2 * lines.costs["rasters"]["sites"])
        add(f"raster, {share:.0f} samples a triangle", 1e-6 * raster["side"] ** 2 / raster["seconds"]["best"], "%.3g 10^6/s")
    steps = lines.costs["refinement"]
    refining, prolonging = (1e-6 * steps["triangles"] / steps[part]["best"] for part in ("refine", "prolong"))
    add(f"three triadic steps, {steps['base']} triangles to {steps['triangles']}: spaces", refining, "%.3g 10^6 triangles/s", ">=",
        REFINE_TARGET)
    add("their coefficients", prolonging, "%.3g 10^6 triangles/s")
    parts = lines.costs["building"]
    for part, name in (("triangulation", "triangulation"), ("gradients", "gradients"), ("split", "split"),
                       ("surface", "polynomials"), ("locator", "point location")):
        add(f"building through {parts['sites']} sites: {name}", parts[part]["best"], "%.2f s")
    add("split and control triangles, which files need, evaluation not", parts["space"]["best"], "%.2f s")
    squares = lines.costs["least squares"]
    what = f"least squares, {squares['points']} points on {squares['vertices']} vertices, cross validation"
    add(f"{what}: one thread", squares["one_thread"]["best"], "%.2f s")
    add("the same on two threads, wall time", squares["two_threads"]["best"], "%.2f s", "<=", SQUARES_TARGET)
    memory = lines.costs["memory"]
    add("memory while a spline is evaluated, all", memory["all"], "%.0f bytes a vertex", "<=", MEMORY_TARGET)
    for part, name in (("surface", "of it polynomials"), ("locator", "of it point location"),
                       ("triangles", "of it corners of triangles"), ("triangulation", "a triangulation with its edges"),
                       ("split_and_control", "split and control triangles, which files need, evaluation not")):
        add(name, memory[part], "%.0f bytes a vertex")
    return markdown(("relief alone", "measured", "target", "met"), rows)


def losses(lines: Lines) -> str:
    """A list item for every measure in which a peer is ahead."""
    items = []
    for (peer, sites), line in sorted(lines.of.items(), key=lambda item: item[0][1]):
        if peer.startswith(OURS):
            continue
        for what, name in (("build", "building"), ("random", "points in random order"), ("raster", "the raster")):
            ratio = lines.ratio(peer, sites, what)
            if ratio and ratio < 1:
                items.append(f"{sites} sites, {name}: {peer} takes {ratio:.2f} of the time.")
        for what, name in (("inner_rms", "the inner RMS"), ("border_max", "the border maximum")):
            ratio = line[what] / lines.of[OURS, sites][what]
            if ratio < 1:
                items.append(f"{sites} sites: {name} of {peer} is {ratio:.2f} of ours.")
    return "\n".join(f"- {item}" for item in items) or "- Nowhere in this run."


SECTIONS = [("Points: speed", speeds), ("Points: against its peers", ratios), ("Points: accuracy", accuracy),
            ("Points: fitting, refinement, memory", costs), ("Points: where relief loses", losses)]


def report(lines: Lines) -> str:
    return sections(lines, SECTIONS)
