"""Modules, their rooms, and what imports what: ``python -m tests.rooms`` lists modules to be read.

Those that a single other one imports, of their own room: a part of that one, perhaps.
"""

import ast
from collections import defaultdict
from collections.abc import Iterator
from glob import glob
from pathlib import Path
from typing import NamedTuple

#: Packages that give the names of the rooms in them, when they are asked; nobody below uses them.
FACES = ("", "modeling", "codegen", "estimation")


class Import(NamedTuple):
    """A name that a module takes of another, or of a library."""

    module: str
    line: int
    level: int
    source: str  # absolute, without ``axisid.``
    name: str
    own: bool  # of axisid


def modules_of(root: Path) -> dict[str, Path]:
    """Every module by its name without ``axisid.``; a package has the name of its folder."""
    package = root / "src" / "axisid"
    files = glob("**/*.py", root_dir=package, recursive=True)  # follows the links to the stages
    names = (file.removesuffix(".py").replace("/", ".").removesuffix("__init__") for file in files)
    return {name.rstrip("."): package / file for name, file in zip(names, files, strict=True)}


def imports_of(modules: dict[str, Path]) -> Iterator[Import]:
    """All of them, late ones and those for types too."""
    for module, file in modules.items():
        package = (module if file.name == "__init__.py" else module.rpartition(".")[0]).split(".")
        stub = file.with_suffix(".pyi")
        names = stub if stub.exists() and module not in FACES else file
        for node in ast.walk(ast.parse(names.read_text())):
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                level = getattr(node, "level", 0)
                above = ["axisid", *package[: len(package) - level + 1]] if level else []
                for alias in node.names:
                    named = isinstance(node, ast.ImportFrom)
                    source = ".".join(filter(None, [*above, node.module if named else alias.name]))
                    own = f"{source}.".startswith("axisid.")
                    inside = source.partition(".")[2] if own else source
                    name = alias.name if named else ""
                    yield Import(module, node.lineno, level, inside, name, own)


def room_of(module: str, modules: dict[str, Path]) -> str:
    """A module beside rooms is one by itself."""
    above = module.rpartition(".")[0]
    alone = modules[module].name == "__init__.py" or above in FACES
    return module if alone else above


def origin_of(source: str, name: str, imports: dict[tuple[str, str], str]) -> str:
    """The module that a face has a name from."""
    while (source, name) in imports:
        source = imports[source, name]
    return source


def graph_of(modules: dict[str, Path]) -> dict[str, set[str]]:
    """What modules import names of, through faces, which are no modules here."""
    imports = [each for each in imports_of(modules) if each.own]
    of_face = {each: modules[each.module].name == "__init__.py" for each in imports}
    faces = {(each.module, each.name): each.source for each in imports if of_face[each]}
    graph = defaultdict(set)
    for each in imports:
        if not of_face[each]:
            full = f"{each.source}.{each.name}".strip(".")
            is_module = full in modules and (each.source, each.name) not in faces
            found = full if is_module else origin_of(each.source, each.name, faces)
            graph[each.module].add(found)
    return graph


if __name__ == "__main__":
    modules, importers = modules_of(Path(__file__).resolve().parents[1]), defaultdict(list)
    for module, imported in graph_of(modules).items():
        for each in imported & modules.keys():
            importers[each].append(module)
    for name, (first, *others) in sorted(importers.items()):
        if not others and room_of(name, modules) == room_of(first, modules):
            print(f"{name:50} {first}")
