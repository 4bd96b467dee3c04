"""The public faces and the names that each lists."""

import ast
from importlib import import_module
from pathlib import Path

#: From the top down; `axisid` gives the others as attributes.
FACES = (
    "axisid",
    "axisid.elements",
    "axisid.control",
    "axisid.modeling",
    "axisid.codegen",
    "axisid.estimation",
)


def public_names(face: str) -> list[str]:
    """The names that a face lists in its stub, or in itself where all of it is imported at once."""
    file = Path(str(import_module(face).__file__))
    stub = file.with_suffix(".pyi")
    tree = ast.parse((stub if stub.exists() else file).read_text())
    return [
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    ]
