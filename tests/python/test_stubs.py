"""The type stubs name what the package has: every function with its arguments and defaults, every member."""

import ast
import inspect
import pathlib

import relief

TREE = ast.parse((pathlib.Path(relief.__file__).parent / "__init__.pyi").read_text())


def members(node):
    found = {}
    for item in node.body:
        if isinstance(item, ast.FunctionDef):
            found[item.name] = item
        elif isinstance(item, ast.AnnAssign):
            found[item.target.id] = item
    return found


CLASSES = {node.name: node for node in TREE.body if isinstance(node, ast.ClassDef)}


def test_functions_have_their_arguments():
    stubs = members(TREE)
    for name in relief.__all__:
        thing = getattr(relief, name)
        if inspect.isfunction(thing) and name != "subdivide":
            arguments = stubs[name].args
            listed = [a.arg for a in arguments.args + arguments.kwonlyargs]
            signature = inspect.signature(thing)
            assert listed == list(signature.parameters), name
            required = len([p for p in signature.parameters.values() if p.default is p.empty])
            assert len(arguments.args) - len(arguments.defaults) == required, name
        elif inspect.isclass(thing):
            assert name in CLASSES
        else:
            assert name in stubs


def test_classes_have_their_members():
    for name, node in CLASSES.items():
        if name.startswith("_"):
            continue
        known = members(node)
        for base in node.bases:
            known |= members(CLASSES[base.id]) if base.id in CLASSES else {}
        has = {m for m in vars(getattr(relief, name)) if not m.startswith("_")}
        assert {m for m in known if not m.startswith("_")} - {"code", "where", "message"} == has, name
