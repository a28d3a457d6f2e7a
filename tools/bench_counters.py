"""Runs benchmarks of relief_bench and reads their counters."""
import json
import pathlib
import re
import subprocess

PROGRAM = pathlib.Path("bench") / "relief_bench"


def run(build: pathlib.Path, pattern: str, raw: pathlib.Path) -> dict[str, dict]:
    """The counters of every benchmark that matches by its name, without the suffixes that tell how it was run."""
    subprocess.run([build / PROGRAM, f"--benchmark_filter={pattern}", "--benchmark_min_time=0.5", f"--benchmark_out={raw}",
                    "--benchmark_out_format=json"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    report = json.loads(raw.read_text())
    raw.unlink()
    return {re.sub(r"/(real_time|iterations:\d+|min_time:[\d.]+)", "", result["name"]): result for result in report["benchmarks"]}
