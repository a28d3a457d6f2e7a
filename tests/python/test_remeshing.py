"""Remeshing: what comes of a mesh without levels, against the command line and distances."""

import numpy as np
import pytest

import relief


def bumpy_ring(rows=30):
    """A ring of triangles whose diagonals go either way."""
    u, v = np.meshgrid(np.arange(2 * rows), np.arange(rows), indexing="ij")
    a, b = np.pi * u / rows, 2 * np.pi * v / rows
    radius = 1 + 0.1 * np.sin(3 * a) * np.cos(2 * b)
    points = np.stack([(3 + radius * np.cos(b)) * np.cos(a), (3 + radius * np.cos(b)) * np.sin(a), radius * np.sin(b)], -1)

    def corner(i, j):
        return (i % (2 * rows) * rows + j % rows).ravel()

    p, q, r, s = corner(u, v), corner(u + 1, v), corner(u + 1, v + 1), corner(u, v + 1)
    turned = ((u + v) % 3 == 0).ravel()[:, None]
    first = np.where(turned, np.stack([p, q, s], -1), np.stack([p, q, r], -1))
    second = np.where(turned, np.stack([q, r, s], -1), np.stack([p, r, s], -1))
    return points.reshape(-1, 3), np.concatenate([first, second])


def test_it_is_that_of_the_program(program, tmp_path):
    scan = bumpy_ring()
    relief.write(tmp_path / "scan.ply", scan)
    told = program("remesh", tmp_path / "scan.ply", tmp_path / "out.ply", "--levels", 2, "--tolerance", "0.005d")
    mesh, report = relief.remesh(*scan, levels=2, tolerance=0.005)
    expected = relief.read(tmp_path / "out.ply")
    assert np.array_equal(mesh.faces, expected.faces)
    assert np.array_equal(mesh.vertices, expected.vertices)
    assert report["levels"] == 2 and report["flips"] == 0
    for key in report:
        assert report[key] == told[key], key


def test_files_are_measured_from_the_scan():
    scan = relief.Mesh(*bumpy_ring())
    mesh, report = relief.remesh(scan)
    goal = 1e-3 * report["diagonal"]
    file = relief.encode(mesh, surface=True, original=scan, keep_order=False, rms_error=goal)
    assert report["rms_error"] * 0.9 < file.report["rms_error"] <= goal
    with pytest.raises(ValueError, match="surface=True"):
        relief.encode(mesh, original=scan, rms_error=goal)
    with pytest.raises(relief.Error, match="goal_out_of_reach"):
        relief.encode(mesh, surface=True, original=scan, rms_error=1e-9)


def test_scans_become_files_in_one_step(program, tmp_path):
    scan = relief.Mesh(*bumpy_ring(16))
    relief.write(tmp_path / "scan.ply", scan)
    sizes = []
    for effort in (0, 1, 2):
        file = relief.encode(scan, remesh=True, rms_error=0.03, tolerance=0.02, effort=effort)
        told = program("encode", tmp_path / "scan.ply", tmp_path / "out.relief", "--remesh", "--rms-error", 0.03,
                       "--tolerance", "0.02d", "--effort", effort)
        assert file.tobytes() == (tmp_path / "out.relief").read_bytes()
        assert file.report["rms_error"] == told["rms_error"] <= 0.03
        assert file.report["remesh"]["base_faces"] == told["remesh"]["base_faces"]
        sizes.append(file.report["bytes"])
    assert sizes[2] < sizes[0]
    file = relief.encode(scan, remesh=True, rms_error=0.1, base_faces=60, levels=2, tolerance=0.1)
    assert file.report["levels"] == 2 and file.report["base_faces"] <= 64
    for options, reason in (({"scheme": "sqrt3"}, "loop"), ({"effort": 3}, "effort"), ({"remesh": False}, "remesh=True")):
        with pytest.raises(ValueError, match=reason):
            relief.encode(scan, **{"remesh": True, "rms_error": 0.03, "tolerance": 0.02, **options})
    with pytest.raises(relief.Error, match="another mesh of the same shape"):
        relief.encode(scan, remesh=True)


def test_what_can_not_be_is_named():
    scan = bumpy_ring()
    with pytest.raises(relief.Error, match="tolerance_not_met"):
        relief.remesh(*scan, base_faces=8, levels=0, tolerance=1e-5)
    with pytest.raises(relief.Error, match="face 3600: duplicate_face"):
        relief.remesh(scan[0], np.concatenate([scan[1], scan[1][:1]]))
    with pytest.raises(relief.Error, match="tolerance"):
        relief.remesh(*scan, tolerance=0)
    with pytest.raises(relief.Error, match="stopped"):
        relief.remesh(*scan, progress=lambda done: False)
