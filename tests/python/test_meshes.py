"""Meshes: files, subdivision, reversal, and .relief files, against the command line and closed forms."""

import numpy as np
import pytest

import relief

OCTAHEDRON = (np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float),
              np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
                       np.int32))


def ball(levels=3, scheme="loop"):
    return relief.subdivide(*OCTAHEDRON, scheme=scheme, levels=levels)


@pytest.mark.parametrize("scheme", ["loop", "sqrt3", "catmull-clark"])
def test_subdivision_is_that_of_the_program(scheme, program, tmp_path):
    relief.write(tmp_path / "a.ply", OCTAHEDRON)
    program("subdivide", tmp_path / "a.ply", tmp_path / "b.ply", "--scheme", scheme, "--levels", 2)
    expected = relief.read(tmp_path / "b.ply")
    vertices, faces = ball(2, scheme)
    assert np.array_equal(faces, expected.faces)
    assert np.abs(vertices - expected.vertices).max() < 1e-15  # kept memory adds in another order
    mesh = relief.subdivide(relief.Mesh(*OCTAHEDRON), scheme=scheme, levels=2)
    assert np.array_equal(mesh.vertices, expected.vertices) and np.array_equal(mesh.faces, expected.faces)


def test_both_precisions_and_all_kinds_of_faces():
    vertices, faces = ball(2)
    single, again = relief.subdivide(OCTAHEDRON[0].astype(np.float32), OCTAHEDRON[1].astype(np.uint32), levels=2)
    assert single.dtype == np.float32 and np.abs(single - vertices).max() < 1e-6 and np.array_equal(again, faces)
    pairs = (OCTAHEDRON[1].ravel(), np.arange(0, 25, 3))
    for kind in (OCTAHEDRON[1].astype(np.int64), OCTAHEDRON[1].tolist(), OCTAHEDRON[1][:, ::1], pairs):
        assert np.array_equal(relief.subdivide(OCTAHEDRON[0], kind, levels=2)[0], vertices)


def test_polygons_of_any_size_and_creases():
    cube = relief.Mesh([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
                       [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
                       creases=[(0, 1, np.inf), (1, 3, np.inf), (3, 2, np.inf), (2, 0, np.inf)])
    fine = relief.subdivide(cube, scheme="catmull-clark", levels=3)
    # The crease is a curve in the plane x = 0; the surface touches no other vertex of that plane from outside.
    assert fine.vertices[:, 0].min() == 0 and len(fine.creases) == 32
    limit = relief.subdivide(cube, scheme="catmull-clark", levels=1, limit=True)
    normals, corners = limit.attributes["normal"]
    assert corners is None and np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
    pentagon = relief.Mesh([[np.cos(a), np.sin(a), 0] for a in 2 * np.pi * np.arange(5) / 5] + [[2, 2, 0]],
                           ([0, 1, 2, 3, 4, 0, 5, 1], [0, 5, 8]))
    indices, offsets = pentagon.faces
    assert offsets.tolist() == [0, 5, 8] and indices.tolist() == [0, 1, 2, 3, 4, 0, 5, 1]


def test_mesh_views():
    mesh = relief.Mesh(*OCTAHEDRON)
    vertices = mesh.vertices
    vertices[0] = [3, 0, 0]
    assert mesh.vertices[0, 0] == 3 and not mesh.faces.flags.writeable
    del mesh
    assert vertices[0, 0] == 3


@pytest.mark.parametrize("scheme, levels", [("loop", 3), ("sqrt3", 4), ("catmull-clark", 3)])
@pytest.mark.parametrize("lift", ["none", "chebyshev"])
def test_reversal_finds_the_base_and_gives_the_mesh_back(scheme, levels, lift):
    vertices, faces = ball(levels, scheme)
    rng = np.random.default_rng(3)
    noisy = vertices + rng.normal(0, 0.01, vertices.shape)
    order = rng.permutation(len(noisy))  # shuffled numbers
    place = np.argsort(order)
    pyramid = relief.reverse(noisy[order], place[faces].astype(np.int32), scheme=scheme, levels=levels, lift=lift)
    assert pyramid.levels == levels and pyramid.scheme == scheme
    back = pyramid.synthesise()
    assert np.abs(back - noisy[order][pyramid.numbers]).max() < 1e-13
    shown = {tuple(sorted(face)) for face in pyramid.numbers[pyramid.faces(0)].tolist()}
    assert shown == {tuple(sorted(face)) for face in place[faces].tolist()}
    smooth = relief.reverse(vertices, faces, scheme=scheme, levels=levels, lift=lift)
    assert max(np.abs(band).max() for band in smooth.bands[1:]) < 1e-12  # a subdivision has no details
    bent = smooth.bands[0]
    bent *= [1, 1, 2]
    assert np.abs(smooth.synthesise() - vertices * [1, 1, 2]).max() < 1e-13


def test_reversal_of_what_is_no_subdivision_is_an_error():
    with pytest.raises(relief.Error, match="no_subdivision_connectivity"):
        relief.reverse([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    with pytest.raises(relief.Error, match="lifts are"):
        relief.reverse(*ball(), lift="x")


@pytest.mark.parametrize("options, flags", [
    ({"max_error": 0.01}, ["--max-error", 0.01]), ({}, []),
    ({"bytes": 600, "scheme": "loop", "levels": 2}, ["--bytes", 600, "--scheme", "loop", "--levels", 2])])
def test_files_are_those_of_the_program(options, flags, program, tmp_path):
    relief.write(tmp_path / "a.ply", ball())
    program("encode", tmp_path / "a.ply", tmp_path / "a.relief", *flags)
    for what in (ball(), relief.Mesh(*ball()), tmp_path / "a.ply"):
        file = relief.encode(what, **options)
        assert file.tobytes() == (tmp_path / "a.relief").read_bytes()
    program("decode", tmp_path / "a.relief", tmp_path / "c.ply", "--level", 1)
    coarse = relief.open(tmp_path / "a.relief").decode(1)
    assert np.allclose(coarse.vertices, relief.read(tmp_path / "c.ply").vertices, atol=1e-7)  # .ply may be float32
    assert np.abs(file.decode().vertices - ball()[0]).max() <= file.report["max_error"] + 1e-15


def test_quads_and_triangles_over_the_plane(tmp_path):
    i, j = np.mgrid[0:9, 0:9].astype(float)
    vertices = np.stack([j.ravel(), i.ravel(), (0.3 * i * j + j).ravel()], axis=1)
    k = np.add.outer(9 * np.arange(8), np.arange(8)).ravel()
    quads = np.stack([k, k + 1, k + 10, k + 9], axis=1)
    file = relief.encode((vertices, quads))
    assert isinstance(file, relief.QuadFile) and file.levels == 3
    assert np.array_equal(file.decode().vertices, vertices) and file(4.5, 2.5) == pytest.approx(0.3 * 11.25 + 4.5)
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    spline = relief.encode((vertices, triangles), scheme="powell-sabin", path=tmp_path / "t.relief")
    assert isinstance(relief.open(tmp_path / "t.relief"), relief.SplineFile)
    value, gradient = spline.evaluate([4.5, 2.5], derivatives=1)
    assert value == pytest.approx(0.3 * 11.25 + 4.5, abs=1e-12)
    assert gradient == pytest.approx([0.3 * 2.5 + 1, 0.3 * 4.5], abs=1e-12)  # a quadratic is reproduced


@pytest.mark.parametrize("vertices, faces", [
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]]), ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, -1]]),
    ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]]), ([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]]),
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2.5]]), ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], ([0, 1, 2], [0, 9])),
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], ([0, 1, 2], [1, 3])), ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [0, 1, 2]),
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2 ** 32]])])
def test_wrong_meshes_are_errors(vertices, faces):
    with pytest.raises(ValueError):
        relief.Mesh(vertices, faces)
    if np.isfinite(vertices).all():
        with pytest.raises(ValueError):
            relief.subdivide(vertices, faces)


def test_wrong_files_are_errors(tmp_path):
    (tmp_path / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n")
    with pytest.raises(relief.Error, match="bad.off"):
        relief.read(tmp_path / "bad.off")
    data = relief.encode(ball(), max_error=0.01).tobytes()
    rng = np.random.default_rng(5)
    for _ in range(200):
        damaged = bytearray(data)
        damaged[rng.integers(len(data))] ^= 1 << rng.integers(8)
        try:
            relief.open(damaged[:rng.integers(20, len(data) + 1)]).decode()
        except relief.Error as error:
            assert str(error)
