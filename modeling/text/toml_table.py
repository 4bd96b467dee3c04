"""One table of a TOML declaration, read key by key; mistakes are collected, not raised."""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import sympy

from axisid.modeling.quantities import Parameter, check_name, check_symbol, expression, number
from axisid.support.errors import ModelError

from .element_calls import ElementCalls
from .expression import read_expression
from .grammar import DYNAMICS
from .mistakes import TextError, nearest

T = TypeVar("T")
Symbols = Mapping[str, sympy.Symbol]

_LONGEST_MISTAKE = 600


@dataclass(slots=True)
class Table:
    """A table and what is wrong with it.

    Attributes
    ----------
    path : str
        Keys that lead to it; empty for the document.
    values : mapping
        As TOML has it.
    mistakes : list of str
        Shared by all tables of a document; every method adds to it.
    """

    path: str
    values: Mapping[str, Any]
    mistakes: list[str]
    _before: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._before = len(self.mistakes)

    @property
    def fine(self) -> bool:
        """Whether nothing was wrong since this table was opened."""
        return len(self.mistakes) == self._before

    def say(self, key: str, problem: str, pointer: str = "") -> None:
        """Add a mistake; the pointer, a line of text over a caret, is set off."""
        if len(problem) > _LONGEST_MISTAKE:
            problem = f"{problem[:_LONGEST_MISTAKE]} ..."
        where = f"{self.at(key)}: " if self.at(key) else ""
        lines = "".join(f"\n    {line}" for line in pointer.splitlines())
        self.mistakes.append(f"{where}{problem}{lines}")

    def at(self, key: str) -> str:
        """The path of a key."""
        bare = key if re.fullmatch(r"[\w-]*(\[\d+\])?", key, re.ASCII) else repr(key[:60])
        return f"{self.path}.{bare}" if self.path and bare else self.path or bare

    def only(self, *keys: str) -> None:
        """Refuse other keys than these."""
        for key in self.values:
            if key not in keys:
                listed = f"the keys here are {', '.join(keys)}" if keys else "there are none here"
                self.say(key, f"there is no such key; {listed}.{nearest(key, keys)}")

    def needs(self, *keys: str) -> None:
        """Refuse the absence of keys."""
        for key in keys:
            if key not in self.values:
                self.say(key, "it is missing; add it.")

    def text(self, key: str) -> str:
        """One line of text."""
        value = self.values.get(key, "")
        if isinstance(value, str) and value.isprintable():
            return value
        self.say(key, f"it is {value!r}; give one line of text in quotes.")
        return ""

    def number(self, key: str, *, finite: bool = True) -> float:
        """A float."""
        value = self.values.get(key, 0.0)
        return self.attempt(key, lambda: number(value, "it", finite=finite)) or 0.0

    def numbers(self, key: str) -> list[float]:
        """A list of floats; one alone is a list of one."""
        value = self.values.get(key, [])
        items = {
            f"{key}[{i}]": v for i, v in enumerate(value if isinstance(value, list) else [value], 1)
        }
        return [Table(self.path, items, self.mistakes).number(k) for k in items]

    def whole(self, key: str, default: int) -> int:
        """An integer."""
        value = self.values.get(key, default)
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        self.say(key, f"it is {value!r}; give a whole number.")
        return default

    def switch(self, key: str, *, default: bool) -> bool:
        """True or false."""
        value = self.values.get(key, default)
        if isinstance(value, bool):
            return value
        self.say(key, f"it is {value!r}; give true or false.")
        return default

    def table(self, key: str) -> "Table":
        """The table under a key; empty if it is absent or none."""
        value = self.values.get(key, {})
        if not isinstance(value, Mapping):
            self.say(key, f"it is {value!r}; give a table, as in [{self.at(key)}].")
            value = {}
        return Table(self.at(key), value, self.mistakes)

    def tables(self, key: str) -> "list[Table]":
        """The tables that are listed under a key."""
        listed = self.values.get(key, [])
        if isinstance(listed, list) and all(isinstance(item, Mapping) for item in listed):
            return [
                Table(f"{self.at(key)}[{i}]", item, self.mistakes)
                for i, item in enumerate(listed, 1)
            ]
        self.say(key, f"it is {listed!r}; give a list of tables, as in [{{ ... }}, {{ ... }}].")
        return []

    def expression(
        self, key: str, symbols: Symbols, elements: ElementCalls | None = None
    ) -> sympy.Expr:
        """An expression as text, or a number; 0 if it is absent or wrong.

        Parameters
        ----------
        key : str
        symbols : mapping of str to sympy.Symbol
        elements : ElementCalls, optional
            Friction and loads that the text may call.
        """
        value = self.values.get(key, 0)
        if isinstance(value, str):
            try:
                return read_expression(value, symbols, DYNAMICS, elements)
            except TextError as error:
                self.say(key, f"{error.where}: {error.reason}", error.pointer)
                return sympy.S.Zero
        if isinstance(value, (list, Mapping)):
            self.say(key, f"it is {value!r}; give an expression in quotes, or a number.")
            return sympy.S.Zero
        self.number(key)
        return expression(value, key) if self.fine else sympy.S.Zero

    def expressions(
        self, key: str, symbols: Symbols, elements: ElementCalls | None = None
    ) -> list[sympy.Expr]:
        """A list of expressions; one alone is a list of one."""
        value = self.values.get(key, [])
        if not isinstance(value, list):
            return [self.expression(key, symbols, elements)]
        items = {f"{key}[{i}]": item for i, item in enumerate(value, 1)}
        inner = Table(self.path, items, self.mistakes)
        return [inner.expression(k, symbols, elements) for k in items]

    def attempt(self, key: str, make: Callable[[], T]) -> T | None:
        """What is made, or None and a mistake."""
        try:
            return make()
        except ModelError as error:
            self.say(key, str(error))
            return None

    def made(
        self,
        make: Callable[..., T],
        fields: Mapping[str, Any],
        neutral: Mapping[str, Any],
        apart: Collection[str] = (),
    ) -> T | None:
        """What is made of fields, or None and all mistakes.

        Parameters
        ----------
        make : callable
        fields : mapping
            Its arguments.
        neutral : mapping
            Arguments that it takes without complaint.
        apart : collection of str
            Fields that are tried among neutral ones first, so that none hides another.
        """
        for key in apart:
            if key in fields:
                alone = {**neutral, key: fields[key]}
                self.attempt(key, lambda alone=alone: make(**alone))  # type: ignore[misc]
        return self.attempt("", lambda: make(**{**neutral, **fields})) if self.fine else None


def checked_name(
    table: Table, key: str, name: Any, what: str, check: Callable[[Any, str], None] = check_name
) -> str | None:
    """The name if it may be used; else None and a mistake."""

    def checked() -> str:
        check(name, what)
        return str(name)

    return table.attempt(key, checked)


def read_parameter(root: Table, name: str, unit: str = "") -> Parameter | None:
    """A parameter from its table, of a unit that is given in it or goes without saying."""
    checked = checked_name(root, name, name, "a parameter", check_symbol)
    table = root.table(name)
    table.only("unit", "nominal", "lower", "upper", "description", "known", "known_sd")
    table.needs(*([] if unit else ["unit"]))
    fields: dict[str, Any] = {"description": table.text("description")}
    fields |= {"unit": unit} if unit else {}
    fields |= {"unit": table.values["unit"]} if "unit" in table.values else {}
    fields |= {
        key: table.number(key, finite=key not in ("lower", "upper"))
        for key in ("nominal", "lower", "upper", "known", "known_sd")
        if key in table.values
    }
    neutral = {"name": checked or "p", "unit": "1"}
    parameter = table.made(Parameter, fields, neutral, apart=("unit",))
    return parameter if checked else None
