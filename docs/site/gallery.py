"""The gallery: every picture of tools/pictures.toml, drawn by the build, with its commands beneath."""
import hashlib
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from pictures import IMAGES, Picture, Studio, table

INTRODUCTION = """# Gallery

Every picture here was drawn by the program when these pages were built, with the commands below it. `dem.tif` is the
elevation model that `make demo` writes, `survey.csv` 4000 of its heights at random places; `quads.off` and `hills.off`
are heights over a ring of quads and of triangles. Where there is more than one picture, they are put side by side.
"""


def key(studio: Studio, picture: Picture) -> str:
    """Changes when the picture may: with its line of the table and with the programs that draw it."""
    digest = hashlib.sha256(repr(picture).encode())
    for name in picture.programs:
        path = pathlib.Path(studio.program(name))
        digest.update(path.read_bytes())
    return digest.hexdigest()


def drawn(studio: Studio, picture: Picture, folder: pathlib.Path) -> list[str] | None:
    """The commands of the picture, which is in the folder then, drawn unless it is there already. None: it can not
    be drawn here; the one of the repository, if there is one, is linked."""
    target = folder / picture.file
    if studio.missing(picture):
        if not picture.kept:
            return None
        target.unlink(missing_ok=True)
        target.symlink_to(IMAGES / picture.file)
        return [re.sub(r"\{bytes [^}]*\}", ".. bytes", line) for line in picture.lines]
    record = folder / f"{picture.name}.json"
    current = key(studio, picture)
    if target.exists() and record.exists():
        stored = json.loads(record.read_text())
        if stored["key"] == current:
            return stored["lines"]
    target.unlink(missing_ok=True)
    lines = studio.draw(picture, target)
    record.write_text(json.dumps({"key": current, "lines": lines}))
    return lines


def page(build: pathlib.Path, folder: pathlib.Path) -> str:
    """Draws what is new into the folder; the text of the page, which shows the pictures of gallery/."""
    folder.mkdir(parents=True, exist_ok=True)
    studio = Studio(build)
    parts, section = [INTRODUCTION], ""
    for picture in table():
        lines = drawn(studio, picture, folder)
        if lines is None:
            continue
        if picture.section != section:
            section = picture.section
            parts.append(f"## {section}\n")
        shown = "\n".join(lines)
        text = f"{picture.text}\n\n" if picture.text else ""
        parts.append(f"### {picture.title}\n\n![{picture.title}](gallery/{picture.file})\n\n{text}```sh\n{shown}\n```\n")
    return "\n".join(parts)
