"""The tables of thresholds: every row of the modules of thresholds, and which modules use it.

Both are read where they are, the rows from the modules and their use from the imports, so that the
page cannot say anything else than the code.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path

from axisid.support.threshold import Threshold

ROOT = Path(__file__).resolve().parents[2]
_STAGES = ("codegen", "estimation")
#: Modules of rows, in the order in which an axis and a log become a result, with their headings.
SUBJECTS: Mapping[str, str] = {
    "axisid.estimation.thresholds": "From a log to a result",
}


def rows_of(subject: str) -> dict[str, Threshold[int] | Threshold[float]]:
    """The rows of a subject by name, as they are declared."""
    module = import_module(subject)
    return {name: row for name, row in vars(module).items() if isinstance(row, Threshold)}


@cache
def users() -> dict[str, list[str]]:
    """By row, the modules that import it, by their names without ``axisid.``."""
    found: dict[str, list[str]] = {}
    for module, file in _modules():
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module in SUBJECTS:
                for alias in node.names:
                    found.setdefault(alias.name, []).append(module)
    return found


def _modules() -> Iterator[tuple[str, Path]]:
    for folder in (*_STAGES, "src/axisid"):
        above = ROOT if folder in _STAGES else ROOT / folder
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = ".".join(file.relative_to(above).with_suffix("").parts)
            if folder in _STAGES or name.partition(".")[0] not in _STAGES:
                yield name.removesuffix(".__init__"), file


def table(subject: str, used: Mapping[str, list[str]]) -> str:
    """The rows of a subject as a table of Markdown."""
    lines = [
        "| name | value | unit | what is judged | source | used in |",
        "|---|---|---|---|---|---|",
    ]
    for name, row in rows_of(subject).items():
        cells = (
            f"`{name}`",
            f"{row.value:g}",
            row.unit,
            row.meaning,
            re.sub(r"\[(\w+\d{4})\]", r"[\1](references)", row.source),
            ", ".join(f"`{module}`" for module in used.get(name, ())),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def page() -> str:
    """All tables, each below its heading."""
    used = users()
    return "\n\n".join(f"## {title}\n\n{table(name, used)}" for name, title in SUBJECTS.items())
