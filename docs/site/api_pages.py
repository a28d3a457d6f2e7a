"""The API reference: a page for each public header, grouped by module, with what Doxygen finds in it.

Run with a header it is Doxygen's input filter: what a namespace of a header declares becomes a group of its own, so
that a page can show it with one directive and one namespace.
"""
import pathlib
import re
import sys

INCLUDE = pathlib.Path(__file__).resolve().parents[2] / "include"

MODULES = {
    "core": "Results and errors, grids, rasters and polygon meshes, parallel loops, vector kernels of rows.",
    "mesh": "Quadrangulations, triangulations, half-edge meshes: building, checks, refinement, location.",
    "spline": "Box splines, bicubic splines, the FVS and the Powell-Sabin element: evaluation and interpolation.",
    "multires": "Pyramids, schemes, hierarchies: analysis, synthesis, fits, bounds, moves.",
    "codec": "Files: what is kept, how it is coded, how it is opened again.",
    "io": "Rasters, meshes and points in and out; pictures; synthetic surfaces.",
    "edit": "Sessions: moves, undo and redo, for every kind of file.",
}

OPENING = re.compile(r"^namespace (\S+) \{$", re.MULTILINE)
CLOSING = re.compile(r"^\}  // namespace.*$", re.MULTILINE)
PRIVATE = ("detail",)  # namespaces that are not for users


def group(header: str, namespace: str) -> str:
    return re.sub(r"\W", "_", f"{header}_{namespace}")


def namespaces(text: str) -> list[str]:
    """Full names of a header's namespaces, in order of their opening; one within another follows it."""
    found, depth = [], []
    for line in re.findall(r"^(?:namespace \S+ \{|\}  // namespace.*)$", text, re.MULTILINE):
        if line.startswith("}"):
            depth.pop()
            continue
        depth.append(line.split()[1])
        found.append("::".join(depth))
    return found


def about(text: str) -> str:
    """The comment above the header's first namespace."""
    comment = re.search(r"((?:^///.*\n)+)(?=namespace )", text, re.MULTILINE)
    return "\n".join(line[3:].strip() for line in comment[1].splitlines()) if comment else ""


def summary(text: str) -> str:
    """The first sentence of that comment, or of the header's first one."""
    first = re.search(r"((?:^ *///.*\n)+)", text, re.MULTILINE)
    comment = about(text) or re.sub(r"^ *///", "", first[1] if first else "", flags=re.MULTILINE)
    return re.split(r"(?<=\.) ", " ".join(comment.split()))[0]


def filtered(header: str, text: str) -> str:
    names = iter(namespaces(text))

    def open_group(line: re.Match) -> str:
        return f"{line[0]} /** @addtogroup {group(header, next(names))}\n@{{ */"

    definitions = " ".join(f"/** @defgroup {group(header, name)} {name} */" for name in namespaces(text))
    # The comment above a namespace would be joined with those of all other headers; the page has it instead.
    text = re.sub(r"(?:^///.*\n)+(?=namespace )", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.MULTILINE)
    text = CLOSING.sub(r"/** @} */ \g<0>", OPENING.sub(open_group, text))
    # Designated initialisers are C++20 that Sphinx can not read.
    text = re.sub(r" = \{\.(?:[^{};]|\{[^{}]*\})*\};", ";", text)
    return f"{definitions} {text}"


def as_markdown(text: str) -> str:
    """Plain words, with what could be taken for markup escaped."""
    return re.sub(r"([\\`*_<>\[\]{}|$])", r"\\\1", text)


def page(header: str, text: str) -> str:
    parts = [f"# {header}\n", as_markdown(about(text)) + "\n"]
    shown = [name for name in namespaces(text) if name.split("::")[-1] not in PRIVATE]
    for name in shown:
        parts.append(f"Namespace `{name}`:\n\n```{{cpp:namespace}} {name}\n```\n\n```{{doxygengroup}} {group(header, name)}\n"
                     ":content-only:\n:members:\n:undoc-members:\n```\n\n```{cpp:namespace} NULL\n```\n")
    for macro in re.findall(r"^///.*\n#define (\w+)", text, re.MULTILINE):
        parts.append(f"```{{doxygendefine}} {macro}\n```\n")
    return "\n".join(parts)


def shorten_names(xml: pathlib.Path):
    """Breathe qualifies classes, but nothing else, by their namespaces; the pages do that for all."""
    known = {name for path in INCLUDE.rglob("*.h") for name in namespaces(path.read_text())}
    for path in [*xml.glob("class*.xml"), *xml.glob("struct*.xml")]:
        text = path.read_text()
        name = re.search(r"<compoundname>([^<]*)", text)[1]
        prefix = max((f"{space}::" for space in known if name.startswith(f"{space}::")), key=len, default="")
        path.write_text(text.replace(f"<compoundname>{name}", f"<compoundname>{name[len(prefix):]}", 1))


def table_page(title: str, introduction: str, column: str, rows: str, pages: list[str]) -> str:
    listed = "\n".join(pages)
    return (f"# {title}\n\n{introduction}\n\n| {column} | |\n|---|---|\n{rows}\n"
            f"```{{toctree}}\n:hidden:\n\n{listed}\n```\n")


def pages() -> dict[str, str]:
    """api/index.md, api/MODULE.md and api/MODULE/HEADER.md with their texts."""
    found = sorted(path.name for path in (INCLUDE / "relief").iterdir() if path.is_dir())
    modules = [name for name in MODULES if name in found] + [name for name in found if name not in MODULES]
    written = {"api/index.md": table_page(
        "C++ API", "Headers of a module include headers of modules above it in this table only; see "
        "[architecture](../architecture.md).", "module",
        "".join(f"| [{module}]({module}.md) | {MODULES.get(module, '')} |\n" for module in modules),
        modules)}
    for module in modules:
        rows, headers = "", []
        for path in sorted((INCLUDE / "relief" / module).glob("*.h")):
            text = path.read_text()
            headers.append(f"{module}/{path.stem}")
            rows += f"| [{path.name}]({module}/{path.stem}.md) | {as_markdown(summary(text))} |\n"
            written[f"api/{module}/{path.stem}.md"] = page(path.relative_to(INCLUDE).as_posix(), text)
        written[f"api/{module}.md"] = table_page(module, MODULES.get(module, ""), "header", rows, headers)
    return written


if __name__ == "__main__":
    source = pathlib.Path(sys.argv[1]).resolve()
    sys.stdout.write(filtered(source.relative_to(INCLUDE).as_posix(), source.read_text()))
