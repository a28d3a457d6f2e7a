"""Draws the pictures of tools/pictures.toml: the one list behind docs/images and the gallery of the site.

A picture is what its commands, run as they are shown, leave in an empty folder that has the `inputs` they name:

    dem.tif       the elevation model of the demonstration (tools/demo_dem.py)
    survey.csv    4000 of its heights at random places
    quads.off     heights over a ring of quads
    hills.off     heights over triangles around a lake
    FOLDER/FILE   a file of the folder of real data, if there is one (RELIEF_DATA)

`panels` are put side by side. {bytes FILE LEVEL WIDTH} in a command stands for what `relief info` says a level needs,
in the middle of so many characters; the width may be left out.
"""
import dataclasses
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

import numpy
from osgeo import gdal

ROOT = pathlib.Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
DATA = pathlib.Path(os.environ.get("RELIEF_DATA", ROOT.parent / "shared" / "data"))
gdal.UseExceptions()


@dataclasses.dataclass
class Picture:
    name: str
    title: str
    section: str
    commands: str
    panels: list[str]
    text: str = ""
    inputs: list[str] = dataclasses.field(default_factory=list)
    programs: list[str] = dataclasses.field(default_factory=lambda: ["relief"])
    kept: bool = False  # in docs/images, which is part of the repository

    @property
    def file(self) -> str:
        return self.name + pathlib.Path(self.panels[0]).suffix

    @property
    def lines(self) -> list[str]:
        return self.commands.strip().splitlines()


def table() -> list[Picture]:
    with open(ROOT / "tools" / "pictures.toml", "rb") as file:
        return [Picture(**entry) for entry in tomllib.load(file)["picture"]]


def read_panel(path: pathlib.Path) -> numpy.ndarray:
    """Channels x rows x cols with three channels; what is transparent is white."""
    pixels = gdal.Open(str(path)).ReadAsArray()
    pixels = pixels[numpy.newaxis] if pixels.ndim == 2 else pixels
    return numpy.repeat(pixels, 3, axis=0) if len(pixels) == 1 else pixels[:3]


def write_png(path: pathlib.Path, pixels: numpy.ndarray):
    """pixels: channels x rows x cols; pictures without colour are stored grey."""
    if (pixels == pixels[0]).all():
        pixels = pixels[:1]
    memory = gdal.GetDriverByName("MEM").Create("", pixels.shape[2], pixels.shape[1], pixels.shape[0])
    memory.WriteArray(numpy.ascontiguousarray(pixels))
    gdal.GetDriverByName("PNG").CreateCopy(str(path), memory, options=["ZLEVEL=9"]).FlushCache()
    path.with_name(path.name + ".aux.xml").unlink(missing_ok=True)


def side_by_side(path: pathlib.Path, panels: list[pathlib.Path]):
    """Pictures standing on one line."""
    arrays = [read_panel(panel) for panel in panels]
    height = max(array.shape[1] for array in arrays)
    standing = [numpy.pad(array, ((0, 0), (height - array.shape[1], 0), (0, 8)), constant_values=255)
                for array in arrays]
    write_png(path, numpy.concatenate(standing, axis=2)[:, :, :-8])


def write_survey(dem: pathlib.Path, path: pathlib.Path):
    heights = gdal.Open(str(dem)).ReadAsArray()
    random = numpy.random.default_rng(1)
    cols, rows = (random.uniform(0, size, 4000) for size in heights.shape[::-1])
    values = heights[rows.astype(int), cols.astype(int)]
    numpy.savetxt(path, numpy.column_stack([30 * cols, -30 * rows, values]), delimiter=",", fmt="%.1f")


def write_off(path: pathlib.Path, vertices: list[tuple], faces: list[tuple]):
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(f"{number:.6f}" for number in vertex) for vertex in vertices]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_ring(path: pathlib.Path, rings: int, spokes: int, corners: int):
    """Waves around a hole: quads, or triangles of which half the rings are turned by half a step."""
    vertices = []
    for ring in range(rings + 1):
        r = 0.25 + 0.75 * ring / rings
        for spoke in range(spokes):
            angle = 2 * math.pi * (spoke + (ring % 2) * (0.5 if corners == 3 else 0)) / spokes
            z = 0.25 * math.cos(9 * r) * math.exp(-r * r) + 0.08 * r * math.sin(5 * angle)
            vertices.append((r * math.cos(angle), r * math.sin(angle), z))
    faces = []
    for ring in range(rings):
        for spoke in range(spokes):
            a, b = ring * spokes + spoke, ring * spokes + (spoke + 1) % spokes
            c, d = a + spokes, b + spokes
            if corners == 4:
                faces.append((a, c, d, b))
            elif ring % 2 == 0:
                faces += [(a, c, b), (b, c, d)]
            else:
                faces += [(a, c, d), (a, d, b)]
    write_off(path, vertices, faces)


class Studio:
    """Runs the commands of pictures; what several of them share is run once."""

    def __init__(self, build: pathlib.Path):
        self.path = os.pathsep.join([str(build), str(build / "examples"), os.environ["PATH"]])
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)
        self.done: dict[str, tuple[pathlib.Path, list[str]]] = {}

    def program(self, name: str) -> str | None:
        return shutil.which(name, path=self.path)

    def missing(self, picture: Picture) -> list[str]:
        """What must be there and is not: programs, and files of the folder of data."""
        return ([name for name in picture.programs if not self.program(name)]
                + [name for name in picture.inputs if "/" in name and not (DATA / name).exists()])

    def input(self, name: str) -> pathlib.Path:
        if "/" in name:
            return DATA / name
        path = self.folder / name
        if path.exists():
            return path
        if name == "dem.tif":
            self.run(self.folder, f"/usr/bin/python3 '{ROOT}/tools/demo_dem.py' {name}")
        elif name == "survey.csv":
            write_survey(self.input("dem.tif"), path)
        elif name == "quads.off":
            write_ring(path, 16, 32, 4)
        elif name == "hills.off":
            write_ring(path, 12, 32, 3)
        else:
            sys.exit(f"pictures: no input is called {name}; see the beginning of tools/pictures.py")
        return path

    def run(self, folder: pathlib.Path, line: str) -> str:
        done = subprocess.run(["sh", "-c", line], cwd=folder, env={**os.environ, "PATH": self.path},
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"pictures: {line}\n{done.stderr.strip()}")
        return done.stdout

    def bytes_for(self, folder: pathlib.Path, file: str, level: str, width: str | None) -> str:
        levels = json.loads(self.run(folder, f"relief info {file} --json"))["level_list"]
        return f"{levels[int(level)]['bytes']:,} bytes".replace(",", " ").center(int(width or 0))

    def developed(self, picture: Picture) -> tuple[pathlib.Path, list[str]]:
        """The folder after the commands, and the commands as they were run."""
        if picture.commands not in self.done:
            folder = self.folder / f"picture-{len(self.done)}"
            folder.mkdir()
            for name in picture.inputs:
                (folder / pathlib.Path(name).name).symlink_to(self.input(name))
            lines = []
            for line in picture.lines:
                line = re.sub(r"\{bytes (\S+) (\d+)(?: (\d+))?\}", lambda found: self.bytes_for(folder, *found.groups()), line)
                self.run(folder, line)
                lines.append(line)
            self.done[picture.commands] = folder, lines
        return self.done[picture.commands]

    def draw(self, picture: Picture, target: pathlib.Path) -> list[str]:
        """Writes the picture and returns its commands. Requires: nothing is missing."""
        folder, lines = self.developed(picture)
        if target.suffix == ".svg":
            shutil.copy(folder / picture.panels[0], target)
        else:
            side_by_side(target, [folder / panel for panel in picture.panels])
        return lines
