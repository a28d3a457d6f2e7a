"""Scattered points: the files of the command line, quadratics reproduced, surfaces in space, errors."""

import numpy as np
import pytest

import relief


def points(n=400, seed=1):
    x, y = np.random.default_rng(seed).uniform(0, 10, (2, n))
    return x, y, np.sin(x) * np.cos(0.7 * y) + 0.1 * x


@pytest.mark.parametrize("options, flags", [
    ({}, []), ({"max_error": 0.05}, ["--max-error", 0.05]), ({"gradients": "plane"}, ["--gradients", "plane"]),
    ({"vertices": 40, "levels": 1, "smoothing": 1e-6}, ["--vertices", 40, "--levels", 1, "--smoothing", 1e-6])])
def test_files_are_those_of_the_program(options, flags, program, tmp_path):
    x, y, z = points()
    relief.write(tmp_path / "p.csv", {"x": x, "y": y, "z": z})
    program("fit", tmp_path / "p.csv", tmp_path / "p.relief", *flags)
    s = relief.fit(x, y, z, **options)
    assert s.tobytes() == (tmp_path / "p.relief").read_bytes()
    assert np.abs(s(x, y) - z).max() <= s.report["max_error"] * (1 + 1e-12) + 1e-12


def test_points_from_files(tmp_path):
    x, y, z = points(20)
    relief.write(tmp_path / "p.csv", {"lon": x, "lat": y, "depth": z, "weight": np.ones(20)})
    places, values, weights = relief.read(tmp_path / "p.csv")
    assert np.array_equal(places, np.stack([x, y], 1)) and np.array_equal(values, z) and np.all(weights == 1)
    assert np.array_equal(relief.read(tmp_path / "p.csv", columns=["lat", "lon", "weight"])[1], np.ones(20))
    (tmp_path / "bad.csv").write_text("x,y,z\n1,2,3\n1,2,x\n")
    with pytest.raises(relief.Error, match="bad.csv, line 3"):
        relief.read(tmp_path / "bad.csv")


def test_quadratics_are_reproduced_with_their_derivatives():
    x, y, _ = points(300)
    s = relief.fit(x, y, x * x - 2 * x * y + 3 * y + 1, gradients="quadratic")
    at = np.random.default_rng(2).uniform(2, 8, (50, 2))
    values, gradients, hessians = s.evaluate(at, derivatives=2)
    a, b = at.T
    # Values of 150 and triangles with angles down to a degree: 1e-9 leaves four digits for their condition.
    assert np.abs(values - (a * a - 2 * a * b + 3 * b + 1)).max() < 1e-9
    assert np.abs(gradients - np.stack([2 * a - 2 * b, 3 - 2 * a], 1)).max() < 1e-7
    assert np.abs(hessians - [[2, -2], [-2, 0]]).max() < 1e-4
    assert np.array_equal(s(a, b, dx=1), gradients[:, 0]) and np.isnan(s(50, 50))
    grid = s.grid((2, 3), (0.5, -0.25), (4, 5))
    j, i = np.meshgrid(np.arange(5), np.arange(4))
    assert np.abs(grid - s(2 + 0.5 * j, 3 - 0.25 * i)).max() < 1e-12


def test_surfaces_in_space():
    u, v, _ = points(300)
    z = np.stack([np.cos(u), np.sin(u), v])
    s = relief.fit(u, v, z, unit="m", crs="EPSG:32611")
    assert s.components == 3 and s.unit == "m" and s.crs == "EPSG:32611"
    assert np.abs(s(u, v) - z.T).max() < 1e-12
    assert s.evaluate([[5.0, 5.0]], derivatives=2)[2].shape == (1, 3, 2, 2)
    mesh = s.decode()
    assert np.abs(np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]) - 1).max() < 1e-12


@pytest.mark.parametrize("make", [
    lambda x, y, z: relief.fit(x, y[:5], z), lambda x, y, z: relief.fit(x, y, z[:5]),
    lambda x, y, z: relief.fit(x, y, np.where(x > 5, np.nan, z)), lambda x, y, z: relief.fit(x, 0 * x, z),
    lambda x, y, z: relief.fit(x, y, z, vertices=2), lambda x, y, z: relief.fit(x, y, z, smoothing=1e-3),
    lambda x, y, z: relief.fit(x, y, z, vertices=9, gradients="plane"),
    lambda x, y, z: relief.fit(x, y, z, vertices=9, energy="x"), lambda x, y, z: relief.fit(x, y, z, weights=[1]),
    lambda x, y, z: relief.fit(x, y, z, vertices=9, weights=-x), lambda x, y, z: relief.fit(x, y, z, crs="nowhere"),
    lambda x, y, z: relief.fit([], [], []), lambda x, y, z: relief.fit(x, y, z, gradients="steep")])
def test_wrong_calls_are_value_errors(make):
    with pytest.raises(ValueError):
        make(*points(50))
