"""The table of errors: every code, the sentence that comes with it, and which modules raise it.

Codes and sentences are read from the calls that make the errors, so that the page cannot say
anything else than the code.
"""

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_STAGES = ("modeling", "codegen", "estimation")


@dataclass(frozen=True, slots=True)
class CodedError:
    """A place where an error with a code of its own is made, or a class with one.

    Attributes
    ----------
    code : str
    error : str
        Its class, or the name of the argument that says which.
    sentence : str
        What it says; what is put in at run time stands in braces.
    module : str
        Where, without ``axisid.``.
    """

    code: str
    error: str
    sentence: str
    module: str


@cache
def coded_errors() -> tuple[CodedError, ...]:
    """Every place where an error with a code of its own is made, and every class, by code."""
    trees = dict(_trees())
    nodes = {
        module: [node for node in ast.walk(tree) if isinstance(node, (ast.Call, ast.ClassDef))]
        for module, tree in trees.items()
    }
    classes = _error_classes(node for of_one in nodes.values() for node in of_one)
    constants = _constants(trees.values())
    found = [
        error
        for module, of_one in nodes.items()
        for node in of_one
        for error in (*_made(node, module, constants), *_of_class(node, module, classes))
    ]
    return tuple(sorted(found, key=lambda error: (error.code, error.module)))


def _made(node: ast.AST, module: str, constants: Mapping[str, str]) -> Iterator[CodedError]:
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name) or not node.args:
        return
    for keyword in node.keywords:
        value = keyword.value
        known = value.value if isinstance(value, ast.Constant) else None
        code = constants.get(value.id) if isinstance(value, ast.Name) else known
        if keyword.arg == "code" and code is not None:
            yield CodedError(str(code), node.func.id, _sentence(node.args[0]), module)


def _of_class(node: ast.AST, module: str, classes: set[str]) -> Iterator[CodedError]:
    if not isinstance(node, ast.ClassDef) or node.name not in classes:
        return
    for line in node.body:
        target = (
            line.target if isinstance(line, ast.AnnAssign) else getattr(line, "targets", [0])[0]
        )
        value = getattr(line, "value", None)
        if isinstance(target, ast.Name) and target.id == "code" and isinstance(value, ast.Constant):
            sentence = f"*{(ast.get_docstring(node) or '').splitlines()[0]}*"
            yield CodedError(str(value.value), node.name, sentence, module)


def _constants(trees: Iterable[ast.Module]) -> dict[str, str]:
    return {
        target.id: str(node.value.value)
        for tree in trees
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name)
    }


def _sentence(text: ast.expr) -> str:
    if isinstance(text, ast.Constant):
        return str(text.value).strip()
    if isinstance(text, ast.JoinedStr):
        parts = (
            str(part.value) if isinstance(part, ast.Constant) else f"{{{_name(part)}}}"
            for part in text.values
        )
        return "".join(parts).strip()
    return ""


def _name(part: ast.expr) -> str:
    """What is put in, by its name where it is one, else dots."""
    value = part.value if isinstance(part, ast.FormattedValue) else part
    text = ast.unparse(value)
    return text if re.fullmatch(r"[\w.]+", text) else "..."


def _error_classes(nodes: Iterable[ast.AST]) -> set[str]:
    kinds = [
        (node.name, {ast.unparse(base) for base in node.bases})
        for node in nodes
        if isinstance(node, ast.ClassDef)
    ]
    found = {"AxisidError"}
    while more := {name for name, bases in kinds if bases & found} - found:
        found |= more
    return found


def _trees() -> Iterator[tuple[str, ast.Module]]:
    for folder in (*_STAGES, "src/axisid"):
        above = ROOT if folder in _STAGES else ROOT / folder
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = ".".join(file.relative_to(above).with_suffix("").parts)
            if folder in _STAGES or name.partition(".")[0] not in _STAGES:
                text = file.read_text(encoding="utf-8")
                yield name.removesuffix(".__init__"), ast.parse(text)


def page() -> str:
    """The table in Markdown: the sentences of each code, and where each is raised."""
    rows, last = [], ""
    for error in coded_errors():
        code = f"`{error.code}`" * (error.code != last)
        rows.append(f"| {code} | `{error.error}` | {_cell(error.sentence)} | `{error.module}` |")
        last = error.code
    return "\n".join(["| code | error | sentence | raised in |", "|---|---|---|---|", *rows])


def _cell(sentence: str) -> str:
    text = sentence.replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")
    return re.sub(r"\{([^{}]*)\}", r"`\1`", text.replace("{...}", "…"))
