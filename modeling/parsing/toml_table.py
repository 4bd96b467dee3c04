"""TOML files written by a user: their tables, read as the arguments of declared objects.

The possible and the required keys, and the type of each, follow from the signature of the function
that the table calls. Mistakes are collected, not raised.
"""

import inspect
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, get_args, get_origin

import sympy

from axisid.modeling.declaration import Column
from axisid.modeling.quantities import number
from axisid.support.errors import FileError, ModelError, UsageError
from axisid.support.files import opened_regular

from .expression import read_expression
from .grammar import Elements, TextError, nearest

T = TypeVar("T")
Symbols = Mapping[str, sympy.Symbol]

_LONGEST_MISTAKE = 600
_NONE: Mapping[str, Any] = MappingProxyType({})


@dataclass(slots=True)
class TomlTable:
    """A table of a TOML document, and the list of mistakes in the document.

    Attributes
    ----------
    path : str
        Keys that lead to the table; empty for the document.
    values : mapping
        Values as TOML has them.
    mistakes : list of str
        Mistakes found so far, shared by all tables of the document; every method adds to it.
    """

    path: str
    values: Mapping[str, Any]
    mistakes: list[str]

    def say(self, key: str, problem: str, pointer: str = "") -> None:
        """Add a mistake.

        Parameters
        ----------
        key : str
        problem : str
            The mistake, a sentence.
        pointer : str
            A line of the text with a caret below, printed on lines of its own; empty for none.
        """
        if len(problem) > _LONGEST_MISTAKE:
            problem = f"{problem[:_LONGEST_MISTAKE]} ..."
        where = f"{self.at(key)}: " if self.at(key) else ""
        lines = "".join(f"\n    {line}" for line in pointer.splitlines())
        self.mistakes.append(f"{where}{problem}{lines}")

    def at(self, key: str) -> str:
        """Return the path of a key from the document, as in ``control.gains.kp``."""
        bare = key if re.fullmatch(r"[\w-]*(\[\d+\])?", key, re.ASCII) else repr(key[:60])
        return f"{self.path}.{bare}" if self.path and bare else self.path or bare

    def only(self, *keys: str) -> None:
        """Report each key of the table that is not one of these as a mistake."""
        for key in self.values:
            if key not in keys:
                listed = f"the keys here are {', '.join(keys)}" if keys else "there are none here"
                self.say(key, f"there is no such key: {listed}.{nearest(key, keys)}")

    def needs(self, *keys: str) -> None:
        """Report each of these keys that is missing as a mistake."""
        for key in keys:
            if key not in self.values:
                self.say(key, "it is missing. Add it.")

    def table(self, key: str) -> "TomlTable":
        """Return the table under a key; empty if it is absent or not a table."""
        value = self.values.get(key, {})
        if not isinstance(value, Mapping):
            self.say(key, f"it is {value!r}. Give a table, as in [{self.at(key)}].")
            value = {}
        return TomlTable(self.at(key), value, self.mistakes)

    def items(self, key: str) -> "TomlTable":
        """Return the items of a list as a table, with the keys ``key[1]``, ``key[2]``, ...

        A value that is not a list is the only item, with the key itself.
        """
        value, items = self.values[key], {key: self.values[key]}
        if isinstance(value, list):
            items = {f"{key}[{i}]": item for i, item in enumerate(value, 1)}
        return TomlTable(self.path, items, self.mistakes)

    def attempt(self, key: str, make: Callable[[], T]) -> T | None:
        """Return the result of a function; after an error None, and the error becomes a mistake."""
        try:
            return make()
        except TextError as error:
            self.say(key, f"{error.where}: {error.reason}", error.pointer)
        except (ModelError, UsageError) as error:
            self.say(key, str(error))
        return None

    def chosen(self, key: str, options: Mapping[str, T], what: str, hint: str = "") -> T | None:
        """Return the option that the value of a key names; otherwise None and a mistake.

        Parameters
        ----------
        key : str
        options : mapping of str to object
        what : str
            Kind of the options, for the message.
        hint : str
            End of the message.
        """
        name = self.values.get(key)
        if isinstance(name, str) and name in options:
            return options[name]
        like = nearest(name, options) if isinstance(name, str) else ""
        self.say(key, f"there is no {what} {name!r}. Choose from {', '.join(options)}{hint}.{like}")
        return None

    def read(
        self, key: str, kind: Any, symbols: Symbols = _NONE, elements: Elements = _NONE
    ) -> Any:
        """Return the value of a key; None and a mistake if it is not of the wanted kind.

        Parameters
        ----------
        key : str
        kind : type
            Type as a signature declares it. A type other than text, number, switch or list means an
            expression.
        symbols : mapping of str to sympy.Symbol
            Symbols that an expression may name.
        elements : mapping of str to callable, optional
            Friction and loads that an expression may call.
        """
        value = self.values[key]
        if get_origin(kind) in (tuple, Iterable):
            inner = self.items(key)
            found = [inner.read(k, get_args(kind)[0], symbols, elements) for k in inner.values]
            return None if None in found else found
        if kind in _KINDS:
            return self.attempt(key, lambda: _KINDS[kind](value))
        return self.attempt(key, lambda: _expression(value, symbols, elements))

    def read_all(self, keys: Iterable[str], kind: Any, symbols: Symbols = _NONE) -> dict[str, Any]:
        """Return the values of these keys that are of a kind; any other key is a mistake."""
        self.only(*keys)
        found = {key: self.read(key, kind, symbols) for key in keys if key in self.values}
        return {key: value for key, value in found.items() if value is not None}

    def made(
        self,
        make: Callable[..., T],
        symbols: Symbols = _NONE,
        *,
        arguments: Mapping[str, inspect.Parameter] | None = None,
        name: str = "",
        given: Mapping[str, Any] = _NONE,
        beside: Collection[str] = (),
        own: Mapping[str, Symbols] = _NONE,
        elements: Mapping[str, Elements] = _NONE,
    ) -> T | None:
        """Return the object that a function makes from the keys of the table; None after a mistake.

        The keys are checked against the arguments of the function, and the values are read. A value
        that could not be read is replaced by an acceptable one. If the function refuses the
        arguments, the argument that causes this is searched, reported and left out, and the
        function is called again, so that all mistakes are found.

        Parameters
        ----------
        make : callable
        symbols : mapping of str to sympy.Symbol
            Symbols that expressions may name.
        arguments : mapping of str to inspect.Parameter
            Arguments of `make`, if its signature does not state them.
        name : str
            The argument ``name``, if it is the key of the table.
        given : mapping
            Values of arguments that are not keys of the table.
        beside : collection of str
            Keys of the table that are not arguments.
        own : mapping of str to mapping
            Symbols that the expressions of single keys may name instead of `symbols`.
        elements : mapping of str to mapping
            Friction and loads that the expressions of single keys may call.
        """
        before = len(self.mistakes)
        others = {*given, "name"} if name else given
        known = arguments or inspect.signature(make).parameters
        keys = {key: argument for key, argument in known.items() if key not in others}
        needed = {key: argument for key, argument in known.items() if argument.default is _ABSENT}
        self.only(*beside, *keys)
        self.needs(*(key for key in needed if key in keys))
        found = {
            key: self.read(
                key, keys[key].annotation, own.get(key, symbols), elements.get(key, _NONE)
            )
            for key in self.values
            if key in keys
        }
        stand_ins = {key: _neutral(argument) for key, argument in known.items()}
        # A value that could not be read is reported already, and a substitute replaces it.
        fields = {key: stand_ins[key] if value is None else value for key, value in found.items()}
        fields |= {"name": name} if name else {}
        neutral = {**{key: stand_ins[key] for key in needed}, **given}
        result: T | ModelError | None = _tried(make, {**neutral, **fields})
        while isinstance(result, ModelError):
            key, fields = _without_guilty(make, neutral, fields, stand_ins, result)
            if found.get(key, "") is not None and (key or len(self.mistakes) == before):
                self.say(key if key in self.values else "", str(result))
            result = _tried(make, {**neutral, **fields}) if key else None
        return result if len(self.mistakes) == before else None

    def each(self, make: Callable[..., T], **how: Any) -> dict[str, T | None]:
        """Return the objects made from the tables in this table, by name; None after a mistake.

        Arguments are those of `made`.
        """
        return {name: self.table(name).made(make, name=name, **how) for name in self.values}


_ABSENT = inspect.Parameter.empty


def _without_guilty(
    make: Callable[..., Any],
    neutral: Mapping[str, Any],
    fields: Mapping[str, Any],
    stand_ins: Mapping[str, Any],
    error: ModelError,
) -> tuple[str, dict[str, Any]]:
    """Return the argument that causes a refusal, and the arguments without it.

    First each argument is left out, or replaced by an acceptable value, to see if the function then
    accepts the rest. Otherwise each argument is tried alone among acceptable values. The name is
    empty if none is found.

    Parameters
    ----------
    make : callable
    neutral : mapping
        Acceptable values of the required arguments.
    fields : mapping
        Values from the table.
    stand_ins : mapping
        An acceptable value for each argument.
    error : ModelError
        The refusal.
    """
    for key in fields:
        without = {name: value for name, value in fields.items() if name != key}
        for others in (without, {**without, key: stand_ins[key]}):
            if not isinstance(_tried(make, {**neutral, **others}), ModelError):
                return key, others
    of_none, wanted = str(_tried(make, neutral)), str(error)
    alone = (k for k in fields if str(_tried(make, {**neutral, k: fields[k]})) == wanted != of_none)
    guilty = next(alone, "")
    return guilty, {name: value for name, value in fields.items() if name != guilty}


def _tried(make: Callable[..., T], fields: Mapping[str, Any]) -> T | ModelError:
    """Return the object that a function makes, or the error with which it refuses."""
    try:
        return make(**fields)
    except ModelError as error:
        return error


def _neutral(argument: inspect.Parameter) -> Any:
    """Return an acceptable value for an argument, whatever the other arguments are."""
    kind = argument.annotation
    if str in (kind, *get_args(kind)):
        return "1" if argument.name == "unit" else "x"
    return (1.0,) if get_origin(kind) is tuple else 1 if kind is int else 1.0


def _plain(kind: type, value: object) -> Any:
    """Return a text, a whole number or a switch, if the value is of this kind."""
    if type(value) is kind and (not isinstance(value, str) or value.isprintable()):
        return value
    raise ModelError(f"it is {value!r}. Give {_GIVE[kind]}.", code="toml")


_GIVE = {str: "one line of text in quotes", int: "a whole number", bool: "true or false"}


# The object made from it decides whether it may be infinite.
_number = partial(number, what="it", finite=False)


def _expression(value: Any, symbols: Symbols, elements: Elements) -> Any:
    """Return an expression given as text, or a plain number."""
    if isinstance(value, str):
        return read_expression(value, symbols, elements)
    if isinstance(value, (list, Mapping)):
        raise ModelError(
            f"it is {value!r}. Give an expression in quotes, or a number.", code="toml"
        )
    number(value, "it")
    return value


#: Functions that read a value, by the kind of its argument.
_KINDS: Mapping[Any, Callable[[Any], Any]] = {
    **{kind: partial(_plain, kind) for kind in _GIVE},
    float: _number,
    float | None: _number,
    float | Any: _number,
    **dict.fromkeys((str | int, float | str), lambda value: value),
}


_LARGEST_FILE = 50_000


def read_toml(file: Path, read: Callable[[TomlTable], T | None], error: type[FileError]) -> T:
    """Return the object built from the table of a file.

    Parameters
    ----------
    file : Path
    read : callable
        Function that makes the object, or adds mistakes to the table.
    error : type of FileError

    Raises
    ------
    FileError
        Error of that type: the file cannot be read, or has mistakes, all of which are named.
    """
    mistakes: list[str] = []
    made = read(TomlTable("", toml_document(file, error), mistakes))
    if made is None or mistakes:
        count = "a mistake" if len(mistakes) == 1 else f"{len(mistakes)} mistakes"
        raise error(f"{file} has {count}:", mistakes)
    return made


def read_columns(table: TomlTable, roles: Iterable[str]) -> dict[str, str]:
    """Return the columns by role as text; each is a text or a table of the column's properties."""
    keys = dict.fromkeys(roles)
    table.only(*keys)
    found = {
        key: table.table(key).made(Column)
        if isinstance(table.values[key], Mapping)
        else table.read(key, str)
        for key in keys
        if key in table.values
    }
    return {key: str(column) for key, column in found.items() if column is not None}


_DEEPEST_KEY = 32  # parts; valid keys have 4 at most
# Memory and time of the parser grow with the square of the parts of a key.
_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{_DEEPEST_KEY}}}")
# Strings may have any number of dots. An unterminated one extends as far as it can, like a comment.
_STRINGS = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\Z)'
    r"|'''.*?(?:'''|\Z)"
    r'|"(?:[^"\\\n]|\\.)*"?'
    r"|'[^'\n]*'?"
    r"|#[^\n]*",
    re.DOTALL,
)


def _as_part(found: re.Match[str]) -> str:
    """Return what replaces a string while keys are checked: a letter; nothing for a comment."""
    return "" if found[0].startswith("#") else "q"


def toml_document(file: Path, error: type[FileError]) -> dict[str, Any]:
    """Return the table of a TOML file.

    Raises
    ------
    FileError
        Error of that type: the file cannot be read, or is not TOML.
    """
    try:
        with opened_regular(file) as stream:
            content = stream.read(_LARGEST_FILE + 1)
    except (OSError, ValueError) as wrong:  # a null in the name
        why = getattr(wrong, "strerror", None) or str(wrong)
        raise error(f"{str(file)!r} cannot be read: {why}. Check the path.") from wrong
    if len(content) > _LARGEST_FILE:
        raise error(
            f"{file} is larger than {_LARGEST_FILE} bytes, the limit for such a file. Keep data in "
            "the log, not in this file.",
            code="toml",
        )
    try:
        text = content.decode("utf-8-sig")
        if _LONG_KEY.search(_STRINGS.sub(_as_part, text)):
            raise RecursionError
        return tomllib.loads(text)
    except (ValueError, RecursionError) as wrong:  # for text that is not UTF-8 too
        if isinstance(wrong, RecursionError):
            raise error(
                f"{file} is nested too deeply: a key or a value has too many levels. Use keys with "
                "few dots and tables with few levels."
            ) from wrong
        what = str(wrong)
        hint = " (text and expressions need quotes)" if "Invalid value" in what else ""
        raise error(f"{file} is not valid TOML: {what}{hint}.") from wrong
