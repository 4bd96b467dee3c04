"""The tables of thresholds: every row of `axisid.estimation.thresholds`, and which modules use it.

Both are read where they are, the rows from the modules and their use from the imports, so that the
page cannot say anything else than the code.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path

from axisid.estimation.thresholds.threshold import Threshold

ROOT = Path(__file__).resolve().parents[2]
ROOM = "axisid.estimation.thresholds"
#: Subjects in the order in which a log becomes a result, with their headings.
SUBJECTS: Mapping[str, str] = {
    "logs": "Reading a log",
    "records": "From a table to a record",
    "signals": "Filter and motion",
    "simulation": "Simulated loop",
    "regression": "Regression",
    "estimates": "Estimates",
    "moves": "Moves, repeats and the model's error",
    "diagnostics": "Diagnostics",
    "studies": "Comparisons, validation, friction curve",
}


def rows_of(subject: str) -> dict[str, Threshold[int] | Threshold[float]]:
    """The rows of a subject by name, as they are declared."""
    module = import_module(f"{ROOM}.{subject}")
    return {name: row for name, row in vars(module).items() if isinstance(row, Threshold)}


def users() -> dict[str, list[str]]:
    """By row, the modules that import it, by their names without ``axisid.``."""
    found: dict[str, list[str]] = {}
    for module, file in _modules():
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{ROOM}."):
                for alias in node.names:
                    found.setdefault(alias.name, []).append(module)
    return found


def _modules() -> Iterator[tuple[str, Path]]:
    for folder, above in (("estimation", ROOT), ("src/axisid", ROOT / "src" / "axisid")):
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = ".".join(file.relative_to(above).with_suffix("").parts)
            if folder == "estimation" or not name.startswith("estimation."):
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
