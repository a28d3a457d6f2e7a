"""relief.EditSession: what `relief edit --script` makes, undo to the bit, every kind of file."""

import json

import numpy as np
import pytest
from conftest import hills

import relief

COMMANDS = [{"do": "move", "level": 3, "points": [20], "delta": 30},
            {"do": "move", "level": 2, "points": [100, 101], "delta": -5, "falloff": {"radius": 3}},
            {"do": "undo"}, {"do": "redo"}]


def test_same_bytes_as_the_program(program, tmp_path):
    file = relief.encode(hills(65, 65), tmp_path / "a.relief", rms_error=1)
    (tmp_path / "script.json").write_text(json.dumps(COMMANDS))
    program("edit", tmp_path / "a.relief", tmp_path / "b.relief", "--script", tmp_path / "script.json")
    session = relief.EditSession(file)
    for command in COMMANDS:
        assert session.run(command)["touched"] > 0
    assert session.file().tobytes() == (tmp_path / "b.relief").read_bytes() and session.file().edited
    other = relief.EditSession(tmp_path / "a.relief")
    other.replay(session.script())
    assert other.file().tobytes() == session.file().tobytes()
    session.run({"do": "goto", "done": 0})
    assert session.file().tobytes() == file.tobytes() and session.history["done"] == 0


def test_questions():
    session = relief.EditSession(relief.encode(np.zeros((65, 65)), max_error=0.01))
    session.run(COMMANDS[0])
    assert session.measure()["max_error"] == 30
    positions, numbers = session.net(3)
    assert positions.shape == (81, 3) and positions[20, 2] == 30 and numbers[20] == 20
    x, y, _ = positions[20]
    probe = session.at(x, y)
    assert probe["value"] == pytest.approx(30) and session.at(1e9, 0) is None
    small = session.compress(1)
    assert np.abs(np.asarray(small.decode()) - np.asarray(session.file().decode())).max() <= 1
    assert session.description["kind"] == "raster" and session.description["max"][0] == 64


def test_meshes_and_splines():
    octahedron = ([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]],
                  [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    session = relief.EditSession(relief.encode(relief.subdivide(*octahedron, levels=2), max_error=1e-3))
    session.run({"do": "move", "level": 2, "points": [4], "delta": [0, 0, 1]})
    # The coarsest vertex 4 is the mesh's vertex at the top: Loop's rule for valence 4 leaves part of it.
    assert 0.1 < session.file().decode().vertices[:, 2].max() - 0.55 < 1
    positions, triangles = session.surface()
    assert positions.shape == (66, 3) and triangles.shape == (128, 3)
    x, y = np.random.default_rng(1).uniform(size=(2, 60))
    spline = relief.EditSession(relief.fit(x, y, x))
    spline.run({"do": "tilt", "level": 0, "points": [3], "slope": [1, 0]})
    assert spline.file().edited and spline.measure()["max_error"] > 0


@pytest.mark.parametrize("command", [{}, {"do": "fly"}, {"do": "move", "level": 99, "points": [0], "delta": 1},
                                     {"do": "move", "level": 0, "points": [-1], "delta": 1},
                                     {"do": "move", "level": 0, "points": [0], "delta": float("nan")},
                                     {"do": "tilt", "level": 0, "points": [0], "slope": [1, 1]}])
def test_wrong_commands_are_errors(command):
    session = relief.EditSession(relief.encode(np.zeros((9, 9))))
    with pytest.raises(ValueError):
        session.run(command)
    with pytest.raises(relief.Error, match="1|commands"):
        session.replay([command])
    with pytest.raises(TypeError):
        relief.EditSession(3)
