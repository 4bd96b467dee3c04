"""Targets of an export: languages of functions, and formats of tables.

In: the result to write. Out: text. Knows nothing of the modules that write: a target names its
writer, which is imported when it writes, so that the command line can show the targets in its help
without these imports.
"""

from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportTarget:
    """A language of feed-forward functions, or a format of parameter tables.

    Attributes
    ----------
    name : str
        Name of the target, as in ``axisid export --to NAME``.
    writer : str
        ``module:function`` that returns the text. For a language its argument is a `FeedForward`;
        for a table its arguments are a `FittedAxis` and the names of methods.
    language : str
        Name of the language in a sentence; empty for a table.
    one_method : bool
        True for a table that can contain only one method.
    """

    name: str
    writer: str
    language: str = ""
    one_method: bool = False

    def write(self, *source: Any) -> str:
        """Return the text that the writer makes from its arguments, `source`."""
        return str(resolve_name(self.writer)(*source))


_PRINTERS, _TABLES = "axisid.codegen.printers", "axisid.exports"
#: All targets, in the order of help and messages.
TARGETS = (
    ExportTarget(name="c", language="C99", writer=f"{_PRINTERS}.c:print_c99"),
    ExportTarget(
        name="st", language="Structured Text", writer=f"{_PRINTERS}.structured_text:print_st"
    ),
    ExportTarget(name="python", language="Python", writer=f"{_PRINTERS}.python:print_python"),
    ExportTarget(name="json", writer=f"{_TABLES}:parameters_json"),
    ExportTarget(name="toml", writer=f"{_TABLES}:parameters_toml", one_method=True),
    ExportTarget(name="csv", writer=f"{_TABLES}:parameters_csv"),
    ExportTarget(name="latex", writer=f"{_TABLES}:parameters_latex"),
)
