"""Runs relief_peers over the demo terrain and a folder of rasters, and says in tables how relief stands."""
import json
import math
import os
import pathlib
import statistics
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = pathlib.Path("bench") / "peers" / "relief_peers"
# The folder of rasters: *.tif in RELIEF_DATA/terrain.
DATA = pathlib.Path(os.environ.get("RELIEF_DATA", ROOT.parent / "shared" / "data")) / "terrain"
# The demo terrain under another name.
SAME_AS_DEMO = "jacksboro_fault"
QUICK_SAMPLES = 300_000
# Smaller rasters say more about headers and starting up than about codecs.
ENOUGH_SAMPLES = 100_000

DENSE, FAST, OPEN = "relief dense", "relief fast", "relief open"
LERC, JXL, JPEG2000 = "LERC+ZSTD", "quantise+JXL", "JPEG 2000"
RATES = (0.25, 0.5, 1, 2)
# Bits a valid sample at most, by raster and bound (0: lossless).
BOUND_TARGETS = {
    "jacksboro": {0: 4.42, 1: 2.89, 5: 1.38, 20: 0.418},
    "rainier_3as": {0: 4.21, 1: 2.72, 5: 1.26, 20: 0.39},
    "fuji_3as": {0: 4.69, 1: 3.21, 5: 1.69, 20: 0.62},
    "missoula_valley_31m": {0.1: 2.72, 1: 1.45, 5: 0.46},
    "monterey_bay_200m": {0.1: 6.03, 1: 3.10, 5: 1.53},
    "palouse_2m": {0.1: 0.130, 1: 0.031},
    "etopo5_east": {0: 4.6, 1: 3.54},
}
LERC_TARGET, LERC_LOSSLESS_TARGET, JPEG2000_TARGET = 0.50, 0.60, 0.94
RATE_TARGETS, RATE_WORST = (0.91, 0.91, 0.88, 0.86), 0.97
SPEED_TARGETS = {DENSE: (30, 30), FAST: (200, 300)}
FAST_SIZE_TARGET, THREADS_TARGET = 1.10, 1.8


class Lines:
    """What relief_peers printed."""

    def __init__(self, lines: list[dict]):
        self.libraries = lines[0]["libraries"]
        self.all = lines[1:]
        self.files = {(l["raster"], bound_of(l), l["codec"]): l for l in self.all
                      if l["goal"] in ("lossless", "max-error") and "bytes" in l}
        self.sized = {(l["raster"], l["bits"], l["codec"]): l for l in self.all if "bits" in l and "bytes" in l}
        self.rasters = list(dict.fromkeys(l["raster"] for l in self.all))
        self.valid = {l["raster"]: l["valid"] for l in self.all}
        self.type = {l["raster"]: l["type"] for l in self.all}
        self.codecs = list(dict.fromkeys(l["codec"] for l in self.all))

    def of(self, goal: str) -> list[dict]:
        return [l for l in self.all if l["goal"] == goal and "error" not in l]

    def cases(self) -> list[tuple[str, float]]:
        """Rasters and bounds that the dense profile was measured at."""
        return [(raster, bound) for raster, bound, codec in self.files if codec == DENSE]

    def bits(self, raster: str, bound: float, codec: str) -> float | None:
        line = self.files.get((raster, bound, codec))
        return 8 * line["bytes"] / line["valid"] if line else None

    def ratio(self, raster: str, bound: float, codec: str) -> float | None:
        """Bytes of the dense profile over those of a peer; without loss of integers only."""
        if bound == 0 and self.type[raster] != "int16":
            return None
        ours, theirs = self.files.get((raster, bound, DENSE)), self.files.get((raster, bound, codec))
        return ours["bytes"] / theirs["bytes"] if ours and theirs else None

    def best_peer(self, raster: str, bound: float) -> tuple[float, str] | None:
        peers = [(self.bits(raster, bound, codec), codec) for codec in self.codecs if not codec.startswith("relief")]
        return min((peer for peer in peers if peer[0] is not None), default=None)

    def rate_ratio(self, raster: str, bits: float) -> float | None:
        ours, theirs = self.sized.get((raster, bits, OPEN)), self.sized.get((raster, bits, JPEG2000))
        return ours["rms_error"] / theirs["rms_error"] if ours and theirs and theirs["rms_error"] > 0 else None

    def large(self) -> list[str]:
        return [raster for raster in self.rasters if self.valid[raster] >= ENOUGH_SAMPLES]


def bound_of(line: dict) -> float:
    return 0 if line["goal"] == "lossless" else line["value"]


def rasters(output: pathlib.Path, quick: bool) -> list[pathlib.Path]:
    demo = output / "jacksboro.tif"
    subprocess.run([ROOT / "tools" / "demo_dem.py", demo], check=True, stdout=subprocess.DEVNULL)
    files = [path for path in sorted(DATA.glob("*.tif")) if path.stem != SAME_AS_DEMO]
    if quick:
        from osgeo import gdal
        gdal.UseExceptions()
        sizes = {path: gdal.Open(str(path)) for path in files}
        files = [path for path, data in sizes.items() if data.RasterXSize * data.RasterYSize <= QUICK_SAMPLES]
    return [demo, *files]


def run(build: pathlib.Path, output: pathlib.Path, quick: bool) -> Lines:
    command = [build / PROGRAM, *(["--once"] if quick else []), *rasters(output, quick)]
    raw = output / "peers.jsonl"
    with raw.open("w") as out:
        subprocess.run(command, check=True, stdout=out)
    return Lines([json.loads(line) for line in raw.read_text().splitlines()])


def number(value: float | None, form: str = "%.3f") -> str:
    return "" if value is None else form % value


def met(value: float | None, target: float | None, at_least: bool = False) -> str:
    """Of the figures as printed."""
    if value is None or target is None:
        return ""
    return "yes" if (value >= target if at_least else round(value, 3) <= target) else "no"


def markdown(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    lines = [head, tuple("-" * width for width in widths), *rows]
    return "\n".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths)) + " |" for line in lines)


def goal_name(bound: float) -> str:
    return "lossless" if bound == 0 else f"{bound:g}"


def at_bounds(lines: Lines) -> str:
    rows, ratios = [], []
    for raster, bound in lines.cases():
        dense, fast, peer = lines.bits(raster, bound, DENSE), lines.bits(raster, bound, FAST), lines.best_peer(raster, bound)
        ratio = dense / peer[0] if peer else None
        if ratio is not None:
            ratios.append(ratio)
        target = BOUND_TARGETS.get(raster, {}).get(bound)
        rows.append((raster, goal_name(bound), number(dense), number(fast), number(peer and peer[0]), peer[1] if peer else "",
                     number(ratio), number(target, "%g"), met(dense, target)))
    if ratios:
        rows.append(("median", "", "", "", "", "", number(statistics.median(ratios)), "", ""))
        rows.append(("worst", "", "", "", "", "", number(max(ratios)), "", ""))
    return markdown(("raster", "bound", "dense", "fast", "peer", "the best peer", "dense / peer", "target", "met"), rows)


def summary(columns: list[list[float | None]], targets: list[float]) -> list[tuple[str, ...]]:
    kept = [[value for value in column if value is not None] for column in columns]
    return [("median", *(number(statistics.median(c) if c else None) for c in kept)),
            ("worst", *(number(max(c, default=None)) for c in kept)),
            ("target", *(number(target, "%.2f") for target in targets)),
            ("met", *(f"{sum(round(v, 3) <= t for v in c)} of {len(c)}" for c, t in zip(kept, targets)))]


def against_lossless(lines: Lines) -> str:
    kinds = [(0, LERC), (1, LERC), (5, LERC), (20, LERC), (0, JPEG2000)]
    columns = [[lines.ratio(raster, bound, codec) for raster in lines.rasters] for bound, codec in kinds]
    rows = [(raster, *(number(column[k]) for column in columns)) for k, raster in enumerate(lines.rasters)]
    rows += summary(columns, [LERC_LOSSLESS_TARGET, LERC_TARGET, LERC_TARGET, LERC_TARGET, JPEG2000_TARGET])
    head = ("dense bytes over", *(f"{codec}, {'int16 lossless' if bound == 0 else bound}" for bound, codec in kinds))
    return markdown(head, rows)


def at_rates(lines: Lines) -> str:
    rows = [(raster, *(number(lines.rate_ratio(raster, bits)) for bits in RATES)) for raster in lines.rasters]
    columns = [[r for raster in lines.large() if (r := lines.rate_ratio(raster, bits))] for bits in RATES]
    means = [math.exp(statistics.fmean(map(math.log, column))) if column else None for column in columns]
    worst = [max(column, default=None) for column in columns]
    rows += [(f"geometric mean, {ENOUGH_SAMPLES} samples and more", *map(number, means)),
             ("target", *(number(target, "%.2f") for target in RATE_TARGETS)),
             ("met", *(met(mean, target) for mean, target in zip(means, RATE_TARGETS))),
             ("worst of them", *map(number, worst)),
             ("target", *(number(RATE_WORST, "%.2f") for _ in RATES)),
             ("met", *(met(value, RATE_WORST) for value in worst))]
    return markdown(("RMSE over that of JPEG 2000", *(f"{bits:g} bit" for bits in RATES)), rows)


def speed(line: dict, what: str) -> float:
    return 4e-6 * line["samples"] / line[f"{what}_seconds"]


def median_speeds(lines: Lines) -> dict[str, dict[str, float]]:
    large = set(lines.large())
    timed = [l for l in [*lines.files.values(), *lines.sized.values()] if l["raster"] in large]
    return {codec: {what: statistics.median(speed(l, what) for l in timed if l["codec"] == codec)
                    for what in ("encode", "decode")}
            for codec in lines.codecs if any(l["codec"] == codec for l in timed)}


def slower(lines: Lines) -> list[str]:
    medians = median_speeds(lines)
    items = []
    for codec in (DENSE, FAST, OPEN):
        for what in ("encode", "decode"):
            ahead = [peer for peer in medians
                     if not peer.startswith("relief") and medians[peer][what] > medians[codec][what]]
            if ahead:
                names = ", ".join(f"{peer} {medians[peer][what]:.0f}" for peer in ahead)
                items.append(f"{codec} {what}s at {medians[codec][what]:.0f} MB/s, slower than {names}.")
    return items


def speeds(lines: Lines) -> str:
    """Medians and ranges over all goals and the larger rasters."""
    medians, large = median_speeds(lines), set(lines.large())
    rows = []
    for codec, own in medians.items():
        timed = [l for l in [*lines.files.values(), *lines.sized.values()] if l["codec"] == codec and l["raster"] in large]
        cells = [codec]
        for what, median in own.items():
            values = [speed(line, what) for line in timed]
            cells.append(f"{median:.0f} ({min(values):.0f}-{max(values):.0f})")
        for other in (medians.get("LERC"), medians.get(JXL)):
            cells.append(" / ".join(f"{own[what] / other[what]:.2f}" for what in own) if other else "")
        targets = SPEED_TARGETS.get(codec)
        cells.append(" / ".join(map(str, targets)) if targets else "")
        cells.append(" / ".join(met(value, target, True) for value, target in zip(own.values(), targets)) if targets else "")
        rows.append(tuple(cells))
    return markdown(("codec", "encode MB/s", "decode MB/s", "over LERC", f"over {JXL}", "target", "met"), rows)


def over_bounds(lines: Lines) -> str:
    rows = []
    for codec in lines.codecs:
        files = [l for l in lines.files.values() if l["codec"] == codec]
        if not files:
            continue
        leaks = [l for l in files if l["over"] > 0]
        beyond = max((l["max_error"] - bound_of(l) for l in leaks), default=None)
        rows.append((codec, str(len(files)), str(len(leaks)), str(sum(l["over"] for l in leaks)), number(beyond, "%.2g")))
    return markdown(("codec", "files", "with samples over", "samples over", "by at most"), rows)


def threads(lines: Lines) -> str:
    rows = []
    for line in lines.of("threads"):
        gains = [one / two for one, two in (line[f"{what}_seconds"] for what in ("encode", "decode"))]
        rows.append((line["raster"], line["codec"], *(number(gain, "%.2f") for gain in gains), f"{THREADS_TARGET}",
                     " / ".join(met(gain, THREADS_TARGET, True) for gain in gains)))
    return markdown(("raster, 1 m", "codec", "encode", "decode", "target", "met"), rows)


def overview_cost(lines: Lines) -> str:
    plain, with_them = (sum(lines.files[raster, 0, codec]["bytes"] for raster in lines.large())
                        for codec in ("ZSTD", "COG ZSTD"))
    return f"{100 * (with_them / plain - 1):+.0f} %"


def parts(lines: Lines) -> str:
    """Windows and overviews."""
    rows = []
    windows = lines.of("window")
    for codec in dict.fromkeys(line["codec"] for line in windows):
        own = [line for line in windows if line["codec"] == codec]
        whole = [lines.files[line["raster"], 0, codec] for line in own]
        milliseconds = statistics.median(1000 * line["decode_seconds"] for line in own)
        share = statistics.median(w["decode_seconds"] / all_["decode_seconds"] for w, all_ in zip(own, whole))
        overviews = {"COG ZSTD": overview_cost(lines), "DEFLATE": "", "ZSTD": ""}.get(codec, "0")
        rows.append((codec, number(milliseconds, "%.1f"), number(100 * share, "%.0f %%"), overviews))
    return markdown(("codec", "256 x 256 window, ms", "of decoding all", "overviews, bytes"), rows)


def losses(lines: Lines) -> str:
    """A list item for every measure in which a peer is ahead."""
    items = []
    for raster, bound in lines.cases():
        peer = lines.best_peer(raster, bound)
        ours = lines.files[raster, bound, DENSE]["bytes"]
        theirs = lines.files[raster, bound, peer[1]]["bytes"] if peer else ours
        if ours > theirs:
            items.append(f"{raster}, {goal_name(bound)}: dense is {100 * (ours / theirs - 1):.1f} % larger than {peer[1]} "
                         f"({ours} bytes, {theirs}).")
    for raster in lines.rasters:
        for bits in RATES:
            ratio = lines.rate_ratio(raster, bits)
            if ratio and ratio > 1:
                items.append(f"{raster}, {bits:g} bit: the RMSE of JPEG 2000 is lower (ours {ratio:.3f} times as large).")
    for raster, bound in lines.cases():
        dense, fast = lines.bits(raster, bound, DENSE), lines.bits(raster, bound, FAST)
        if fast and raster in lines.large() and fast > FAST_SIZE_TARGET * dense:
            items.append(f"{raster}, {goal_name(bound)}: fast is {100 * (fast / dense - 1):.0f} % larger than dense (target 10 %).")
    return "\n".join(f"- {item}" for item in [*items, *slower(lines)]) or "- Nowhere in this run."


SECTIONS = [
    ("Bits a sample at a bound", at_bounds),
    ("Bytes against LERC and JPEG 2000", against_lossless),
    ("RMSE at the same bytes", at_rates),
    ("Speed", speeds),
    ("Samples over the bound", over_bounds),
    ("Two threads", threads),
    ("Windows and overviews", parts),
    ("Where relief loses", losses),
]


def sections(lines, tables) -> str:
    """The libraries of a comparison and its tables."""
    libraries = ", ".join(f"{name} {version or 'not installed'}" for name, version in lines.libraries.items())
    return "\n\n".join([libraries, *(f"### {title}\n\n{table(lines)}" for title, table in tables)])


def report(lines: Lines) -> str:
    return sections(lines, SECTIONS)
