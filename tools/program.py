"""What the program says of itself, `relief --describe`, in the words that its manual and completions need."""
import json
import pathlib
import subprocess
import sys


class Option:
    """An option or, without dashes, a positional."""

    def __init__(self, about: dict):
        self.names: list[str] = about["names"]
        self.text: str = about["text"]
        self.choices: list[str] = about.get("choices", [])
        self.range: str = about.get("range", "")
        self.type: str = about.get("type", "")  # empty: a flag
        self.required: bool = about["required"]
        self.most: int | None = about["most"]
        self.least: int = about["least"]

    @property
    def positional(self) -> bool:
        return not self.names[0].startswith("-")

    @property
    def takes_file(self) -> bool:
        """Text that is not one of a few words may be the name of a file."""
        return self.type == "TEXT" and not self.choices

    @property
    def values(self) -> str:
        """What stands behind the name: "TEXT", "INT x 4", "TEXT ..."; empty for flags."""
        if self.most is None:
            return f"{self.type} ..."
        return f"{self.type} x {self.most}" if self.most > 1 else self.type


class Command:
    """The program or a verb of it. `options` are those that not all verbs have, `common` the others."""

    def __init__(self, about: dict, common: list[str]):
        self.name: str = about["name"]
        self.description: str = about["description"]
        head, _, examples = about["footer"].partition("Examples:\n")
        lines = [line for line in examples.splitlines() if line.startswith("  ")]
        self.examples = [line.strip() for line in lines]
        self.notes = [line for line in head.splitlines() + examples.splitlines() if line and line not in lines]
        everything = [Option(option) for option in about["options"]]
        self.positionals = [option for option in everything if option.positional]
        self.options = [option for option in everything if not option.positional and option.names[-1] not in common]
        self.common = [option for option in everything if not option.positional and option.names[-1] in common]
        self.groups: list[tuple[str, list[Option]]] = [
            (group["description"], [Option(option) for option in group["options"]]) for group in about["groups"]]

    @property
    def all_options(self) -> list[Option]:
        return self.options + [option for _, options in self.groups for option in options] + self.common


class Program:
    def __init__(self, path: pathlib.Path):
        """path: the program, already built."""
        about = json.loads(said_by(path, "--describe"))
        self.version = said_by(path, "--version").split()[1]
        verbs = about["verbs"]
        names = [{option["names"][-1] for option in verb["options"]} for verb in verbs]
        common = sorted(set.intersection(*names))
        self.itself = Command(about, [])
        self.verbs = [Command(verb, common) for verb in verbs]


def said_by(path: pathlib.Path, *words: str) -> str:
    try:
        return subprocess.run([path, *words], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"{path}: can not be run, build it first: make build ({error})")
