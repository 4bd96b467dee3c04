"""A small evaluator of IEC 61131-3 Structured Text: functions of LREAL and BOOL, strictly typed.

It knows what the standard has and refuses everything else: identifiers that are not legal, names
that are not declared or declared twice, numbers without a type, BOOL where LREAL is due.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field

Value = float | bool

_WORD = re.compile(
    r"\s+|\(\*(?:(?!\*\)|\(\*).)*\*\)|LREAL#-?\d+\.\d+(?:E[+-]?\d+)?|[A-Za-z_]\w*|:=|<>|<=|>=|[-+*/()<>=,;:]",
    re.DOTALL | re.ASCII,
)
_IDENTIFIER = re.compile(r"(?:[A-Za-z]|_[A-Za-z0-9])(?:_?[A-Za-z0-9])*")
_KEYWORDS = frozenset(
    "FUNCTION END_FUNCTION VAR VAR_INPUT CONSTANT END_VAR LREAL BOOL AND OR NOT XOR MOD IF THEN "
    "ELSE END_IF RETURN REAL INT TRUE FALSE D DT R S N L P T ST LD DO BY TO OF ON AT".split()
)
_FUNCTIONS: dict[str, tuple[Callable[..., float], int]] = {
    "SIN": (math.sin, 1),
    "COS": (math.cos, 1),
    "TAN": (math.tan, 1),
    "ASIN": (math.asin, 1),
    "ACOS": (math.acos, 1),
    "ATAN": (math.atan, 1),
    "ATAN2": (math.atan2, 2),
    "EXP": (math.exp, 1),
    "LN": (math.log, 1),
    "SQRT": (math.sqrt, 1),
    "ABS": (abs, 1),
    "EXPT": (math.pow, 2),
    "MIN": (min, 2),
    "MAX": (max, 2),
    "LIMIT": (lambda low, x, high: min(max(low, x), high), 3),
}
_LEVELS = (("OR",), ("AND",), ("=", "<>"), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/"))
_BINARY: dict[str, Callable[[float, float], Value]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


class StructuredTextError(Exception):
    """The text is not what the standard allows."""


@dataclass
class Function:
    """A function: names of its inputs, values of its constants, and where its body begins."""

    name: str
    inputs: list[str] = field(default_factory=list)
    values: dict[str, float | None] = field(default_factory=dict)
    constants: set[str] = field(default_factory=set)
    body: int = 0


class StructuredText:
    """Functions read from a text; call one by its name."""

    def __init__(self, text: str) -> None:
        self._words: list[str] = []
        position = 0
        while position < len(text):
            match = _WORD.match(text, position)
            if match is None:
                raise StructuredTextError(f"no token: {text[position : position + 20]!r}")
            if match[0].strip() and not match[0].startswith("(*"):
                self._words.append(match[0])
            position = match.end()
        self._at = 0
        self.functions: dict[str, Function] = {}
        while self._at < len(self._words):
            function = self._declaration()
            self.functions[function.name.lower()] = function

    def __call__(self, name: str, *arguments: float) -> float:
        function = self.functions[name.lower()]
        if len(arguments) != len(function.inputs):
            raise StructuredTextError(f"{name} takes {len(function.inputs)}, not {len(arguments)}")
        values = dict(function.values)
        values.update(zip(function.inputs, arguments, strict=True))
        back, self._at = self._at, function.body
        while self._words[self._at] != "END_FUNCTION":
            target = self._name().lower()
            self._expect(":=")
            if target not in values or target in {*function.constants, *function.inputs}:
                raise StructuredTextError(f"{target} cannot be assigned")
            values[target] = _real(self._expression(values))
            self._expect(";")
        self._at = back
        return _real(values[function.name.lower()])

    def _declaration(self) -> Function:
        self._expect("FUNCTION")
        function = Function(self._name())
        function.values[function.name.lower()] = None
        self._expect(":")
        self._expect("LREAL")
        while self._words[self._at].startswith("VAR"):
            kind = self._next()
            constant = kind == "VAR" and self._words[self._at] == "CONSTANT"
            self._at += constant
            while self._words[self._at] != "END_VAR":
                name = self._name().lower()
                if name in function.values or name in self.functions:
                    raise StructuredTextError(f"{name} is declared twice")
                self._expect(":")
                self._expect("LREAL")
                function.values[name] = None
                if constant:
                    self._expect(":=")
                    function.values[name] = _real(self._expression({}))
                    function.constants.add(name)
                if kind == "VAR_INPUT":
                    function.inputs.append(name)
                self._expect(";")
            self._at += 1
        function.body = self._at
        self._at = self._words.index("END_FUNCTION", self._at) + 1
        return function

    def _expression(self, values: dict[str, float | None], level: int = 0) -> Value:
        if level == len(_LEVELS):
            return self._unary(values)
        result = self._expression(values, level + 1)
        while self._words[self._at] in _LEVELS[level]:
            operator = self._next()
            right = self._expression(values, level + 1)
            if operator in ("AND", "OR"):
                both = (_bool(result), _bool(right))
                result = all(both) if operator == "AND" else any(both)
            else:
                result = _BINARY[operator](_real(result), _real(right))
        return result

    def _unary(self, values: dict[str, float | None]) -> Value:
        word = self._next()
        if word == "-":
            return -_real(self._primary(self._next(), values))
        if word == "NOT":
            return not _bool(self._primary(self._next(), values))
        return self._primary(word, values)

    def _primary(self, word: str, values: dict[str, float | None]) -> Value:
        if word == "(":
            inner = self._expression(values)
            self._expect(")")
            return inner
        if word.startswith("LREAL#"):
            return float(word.removeprefix("LREAL#"))
        if self._words[self._at] == "(":
            return self._call(word, values)
        value = values.get(word.lower())
        if value is None:
            raise StructuredTextError(f"{word} has no value")
        return value

    def _call(self, name: str, values: dict[str, float | None]) -> Value:
        arguments, separator = [], self._next()
        while separator in ("(", ","):
            arguments.append(self._expression(values))
            separator = self._next()
        if separator != ")":
            raise StructuredTextError(f"{separator} in a call of {name}")
        if name == "SEL":
            chosen, zero, one = arguments
            return _real(one) if _bool(chosen) else _real(zero)
        if name in _FUNCTIONS:
            function, count = _FUNCTIONS[name]
            if len(arguments) != count:
                raise StructuredTextError(f"{name} takes {count} arguments")
            return function(*map(_real, arguments))
        return self(name, *map(_real, arguments))

    def _name(self) -> str:
        name = self._next()
        if not _IDENTIFIER.fullmatch(name) or name.upper() in {*_KEYWORDS, *_FUNCTIONS, "SEL"}:
            raise StructuredTextError(f"{name} is no identifier")
        return name

    def _next(self) -> str:
        self._at += 1
        return self._words[self._at - 1]

    def _expect(self, word: str) -> None:
        if (found := self._next()) != word:
            raise StructuredTextError(f"{found} in place of {word}")


def _real(value: Value | None) -> float:
    if isinstance(value, bool) or value is None:
        raise StructuredTextError(f"{value} is no LREAL")
    return value


def _bool(value: Value) -> bool:
    if not isinstance(value, bool):
        raise StructuredTextError(f"{value} is no BOOL")
    return value
