"""Every example in a docstring, and every Python block of docs/python.md and README.md, runs and says what it says."""

import doctest
import inspect
import pathlib
import re

import pytest

import relief

ROOT = pathlib.Path(__file__).resolve().parents[2]


def documented():
    for name in relief.__all__:
        thing = getattr(relief, name)
        yield name, thing.__doc__
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") or member in ("__call__",):
                yield f"{name}.{member}", value.__doc__


@pytest.mark.parametrize("name, doc", documented(), ids=lambda text: text if text.isidentifier() else "")
def test_docstring(name, doc):
    assert doc and len(doc.strip()) > 5, f"{name} has no docstring"
    test = doctest.DocTestParser().get_doctest(doc, {}, name, None, 0)
    assert doctest.DocTestRunner().run(test).failed == 0


@pytest.mark.parametrize("page", ["docs/python.md"])
def test_page(page, tmp_path, monkeypatch):
    """Blocks run one after another, in one folder; lines `# ValueError: text` follow a line that raises it."""
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
