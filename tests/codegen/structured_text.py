"""IEC 61131-3 Structured Text, functions of LREAL and BOOL, turned into Python and run.

What the standard has not is refused: identifiers that are not legal, names that are not declared or
declared twice, numbers without a type, BOOL where LREAL is due.
"""

import math
import re
from collections.abc import Callable, Iterator
from typing import Any

_WORD = re.compile(
    r"\s+|\(\*(?:(?!\*\)|\(\*).)*\*\)|LREAL#-?\d+\.\d+(?:E[+-]?\d+)?|[A-Za-z_]\w*|:=|<>|<=|>=|[-+*/()<>=,;:]",
    re.DOTALL | re.ASCII,
)
_IDENTIFIER = re.compile(r"(?:[A-Za-z]|_[A-Za-z0-9])(?:_?[A-Za-z0-9])*")
_KEYWORDS = frozenset(
    "FUNCTION END_FUNCTION VAR VAR_INPUT CONSTANT END_VAR LREAL BOOL AND OR NOT XOR MOD IF THEN "
    "ELSE END_IF RETURN REAL INT TRUE FALSE D DT R S N L P T ST LD DO BY TO OF ON AT SEL".split()
)
#: Bits of Python refuse what is no BOOL, as AND and OR do.
_PYTHON = {"AND": "&", "OR": "|", "NOT": "not", "=": "==", "<>": "!="}


def _real(value: object) -> float:
    if not isinstance(value, float):
        raise StructuredTextError(f"{value} is no LREAL")
    return value


def _sel(chosen: object, zero: float, one: float) -> float:
    if not isinstance(chosen, bool):
        raise StructuredTextError(f"{chosen} is no BOOL")
    return _real(one) if chosen else _real(zero)


def _of_reals(function: Callable[..., float]) -> Callable[..., float]:
    return lambda *arguments: float(function(*map(_real, arguments)))


_FUNCTIONS: dict[str, Callable[..., float]] = {
    name: _of_reals(getattr(math, python))
    for name, python in zip(
        "SIN COS TAN ASIN ACOS ATAN ATAN2 EXP LN SQRT ABS EXPT".split(),
        "sin cos tan asin acos atan atan2 exp log sqrt fabs pow".split(),
        strict=True,
    )
}
_FUNCTIONS |= {"MIN": _of_reals(min), "MAX": _of_reals(max), "SEL": _sel}
_FUNCTIONS["LIMIT"] = _of_reals(lambda low, x, high: min(max(low, x), high))


class StructuredTextError(Exception):
    """The text is not what the standard allows."""


def structured_text(text: str) -> dict[str, Callable[..., float]]:
    """Functions of a text by their names, in lower case."""
    words = list(_words(text))
    made: dict[str, Any] = {**_FUNCTIONS, "_real": _real}
    names = []
    while words:
        end = words.index("END_FUNCTION")
        name, source = _python(words[:end], names)
        exec(source, made)
        names.append(name)
        words = words[end + 1 :]
    return {name: made[f"v_{name}"] for name in names}


def _words(text: str) -> Iterator[str]:
    position = 0
    while position < len(text):
        match = _WORD.match(text, position)
        if match is None:
            raise StructuredTextError(f"no token: {text[position : position + 20]!r}")
        if match[0].strip() and not match[0].startswith("(*"):
            yield match[0]
        position = match.end()


def _python(words: list[str], others: list[str]) -> tuple[str, str]:
    """The name of a function, and its source in Python."""
    function, name, *kind = words[:4]
    assert [function, *kind] == ["FUNCTION", ":", "LREAL"]
    declared, inputs, lines = [*others, _legal(name)], [], []
    rest = " ".join(words[4:])
    while block := re.match(r"(VAR_INPUT|VAR CONSTANT|VAR) (.*?) END_VAR ?", rest):
        for line in filter(None, block[2].split(" ;")):
            variable, kind_of, value = re.fullmatch(r" ?(\S+) : (\S+)(?: := (.*))?", line).groups()
            assert (kind_of, value is None) == ("LREAL", block[1] != "VAR CONSTANT")
            declared.append(_legal(variable))
            inputs += [declared[-1]] if block[1] == "VAR_INPUT" else []
            lines += [f"{variable} := {value}"] if value else []
        rest = rest[block.end() :]
    if len(set(declared)) < len(declared):
        raise StructuredTextError(f"one of {declared} is declared twice")
    source = [f"def v_{declared[len(others)]}({', '.join(f'v_{each}' for each in inputs)}):"]
    for line in [*lines, *filter(None, rest.split(" ;"))]:
        target, value = line.split(" := ")
        if target.strip().lower() not in set(declared) - set(inputs):
            raise StructuredTextError(f"{target} cannot be assigned")
        translated = " ".join(map(_word, value.split()))
        source.append(f"    v_{target.strip().lower()} = _real({translated})")
    return declared[len(others)], "\n".join([*source, f"    return v_{declared[len(others)]}", ""])


def _word(word: str) -> str:
    if word.startswith("LREAL#"):
        return word.removeprefix("LREAL#")
    is_name = re.match(r"\w", word) and word not in _PYTHON and word not in _FUNCTIONS
    return f"v_{_legal(word)}" if is_name else _PYTHON.get(word, word)


def _legal(name: str) -> str:
    if not _IDENTIFIER.fullmatch(name) or name.upper() in {*_KEYWORDS, *_FUNCTIONS}:
        raise StructuredTextError(f"{name} is no identifier")
    return name.lower()
