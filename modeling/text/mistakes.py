"""What is wrong with a text, and where."""

import difflib
from collections.abc import Collection
from functools import partial
from typing import Any

from axisid.support.errors import UsageError

_SHOWN = 60  # characters around a mistake


class TextError(UsageError):
    """A text cannot be read.

    Parameters
    ----------
    reason : str
        A sentence.
    text : str
        All of it.
    offset : int
        Of the offending character.
    code : str
        Of the mistake.

    Attributes
    ----------
    reason, where, pointer : str
        The sentence; ``column 3``; the line of the text over a caret.
    """

    code = "formula"

    def __init__(self, reason: str, text: str, offset: int, *, code: str = "") -> None:
        place = min(max(offset, 0), len(text))
        before = text[:place].split("\n")
        line, column = len(before), len(before[-1])
        whole = text.split("\n")[line - 1]
        self.where = (f"line {line}, " if "\n" in text.strip() else "") + f"column {column + 1}"
        start = max(0, column - _SHOWN // 2)
        shown = "".join(c if c.isprintable() else "?" for c in whole[start : start + _SHOWN])
        self.pointer = f"{shown}\n{' ' * (column - start)}^" if shown.strip() else ""
        super().__init__(f"{shown.strip()!r} cannot be read at {self.where}: {reason}", code=code)
        self._given = reason, text, offset
        self.reason = reason

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), code=self.code), self._given


def nearest(name: str, names: Collection[str]) -> str:
    """The name that is most like another one, as a question; empty if none is."""
    close = difflib.get_close_matches(name[:50], list(names), 1)
    return f" Did you mean {close[0]!r}?" if close else ""
