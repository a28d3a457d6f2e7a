"""What the tests of the Python package share. The environment names the program (RELIEF)."""

import json
import os
import pathlib
import subprocess

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RELIEF = os.environ.get("RELIEF", str(ROOT / "build/release/relief"))


def hills(rows, cols, seed=1, rough=4.0):
    """A smooth landscape with noise: heights around 0 .. 400."""
    rng = np.random.default_rng(seed)
    i, j = np.mgrid[0:rows, 0:cols]
    z = 200 + 90 * np.sin(i / 17 + 1) * np.cos(j / 23) + 60 * np.sin((i + 2 * j) / 41)
    return z + rng.normal(0, rough, z.shape)


@pytest.fixture
def program():
    """Runs the command line program and returns its JSON."""
    def run(*arguments):
        done = subprocess.run([RELIEF, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    if not os.access(RELIEF, os.X_OK):
        pytest.skip("the command line program is not built")
    return run
