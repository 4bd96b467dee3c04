"""Modules, their rooms, and what imports what: ``python -m tests.rooms`` lists modules to be read.

Those that a single other one imports, of their own room: a part of that one, perhaps.
"""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

STAGES = ("modeling", "codegen", "estimation")

Import = tuple[str, int, str, str]  # module, its line, what it imports from, the name


def modules_of(root: Path) -> dict[str, Path]:
    """Every module by its name without ``axisid.``; a package has the name of its folder."""
    found = {}
    for base in (*(root / stage for stage in STAGES), root / "src" / "axisid"):
        above = base.parent if base.name in STAGES else base
        for file in sorted(base.rglob("*.py")):
            parts = file.relative_to(above).with_suffix("").parts
            if base.name in STAGES or parts[0] not in STAGES:
                found[".".join(parts).removesuffix("__init__").removesuffix(".")] = file
    return found


def imports_of(name: str, file: Path) -> Iterator[Import]:
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if f"{alias.name}.".startswith("axisid."):
                    yield name, node.lineno, alias.name.partition(".")[2], ""
        elif isinstance(node, ast.ImportFrom):
            source = node.module or ""
            if node.level:
                parts = package.split(".")[: len(package.split(".")) - node.level + 1]
                source = ".".join(["axisid", *parts, *filter(None, [source])])
            if f"{source}.".startswith("axisid."):
                for alias in node.names:
                    yield name, node.lineno, source.partition(".")[2], alias.name


def room_of(module: str, modules: dict[str, Path]) -> str:
    return module if modules[module].name == "__init__.py" else module.rpartition(".")[0]


def origin_of(source: str, name: str, imports: dict[tuple[str, str], str]) -> str:
    """The module that a face has a name from."""
    while (source, name) in imports:
        source = imports[source, name]
    return source


def graph_of(modules: dict[str, Path]) -> dict[str, set[str]]:
    """What modules import names of, through faces, which are no modules here."""
    imports = [each for name in modules for each in imports_of(name, modules[name])]
    faces = {
        (module, name): source
        for module, _, source, name in imports
        if modules[module].name == "__init__.py"
    }
    graph: dict[str, set[str]] = {}
    for module, _, source, name in imports:
        if modules[module].name != "__init__.py":
            full = f"{source}.{name}".strip(".")
            is_module = full in modules and (source, name) not in faces
            found = full if is_module else origin_of(source, name, faces)
            graph.setdefault(module, set()).add(found)
    return graph


def lone_importers(modules: dict[str, Path]) -> Iterator[tuple[str, str]]:
    """Modules that a single other one imports, of their own room, and that one."""
    importers = defaultdict(list)
    for module, imported in graph_of(modules).items():
        for each in imported:
            importers[each].append(module)
    for name, (first, *others) in sorted(importers.items()):
        if not others and name in modules and room_of(name, modules) == room_of(first, modules):
            yield name, first


if __name__ == "__main__":
    for name, importer in lone_importers(modules_of(Path(__file__).resolve().parents[1])):
        print(f"{name:50} {importer}")
