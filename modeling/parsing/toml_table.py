"""Read the tables of a user's TOML file as the arguments of declared objects.

The possible and the required keys, and the type of each, follow from the signature of the function
that the table calls. Mistakes are collected in a list, not raised, so that a user sees all of them
at once.
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
        Keys that lead to the table, as in ``control.gains``; empty for the whole document.
    values : mapping
        Values by key, in the types of `tomllib`.
    mistakes : list of str
        Mistakes found so far, shared by all tables of the document; every method adds to it.
    """

    path: str
    values: Mapping[str, Any]
    mistakes: list[str]

    def say(self, key: str, problem: str, pointer: str = "") -> None:
        """Append a mistake to the list, with the path of its key.

        Parameters
        ----------
        key : str
            Key of this table; empty for the table itself.
        problem : str
            The mistake and its remedy, in sentences.
        pointer : str
            A line of the text with a caret below, printed on separate lines; empty for none.
        """
        if len(problem) > _LONGEST_MISTAKE:
            problem = f"{problem[:_LONGEST_MISTAKE]} ..."
        where = f"{self.at(key)}: " if self.at(key) else ""
        lines = "".join(f"\n    {line}" for line in pointer.splitlines())
        self.mistakes.append(f"{where}{problem}{lines}")

    def at(self, key: str) -> str:
        """Return the path of a key of this table from the document: ``control.gains.kp``."""
        bare = key if re.fullmatch(r"[\w-]*(\[\d+\])?", key, re.ASCII) else repr(key[:60])
        return f"{self.path}.{bare}" if self.path and bare else self.path or bare

    def only(self, *keys: str) -> None:
        """Report each key of the table that is not one of these as a mistake."""
        for key in self.values:
            if key not in keys:
                listed = f"Known keys are {', '.join(keys)}" if keys else "This table has no keys"
                self.say(key, f"the key is unknown. {listed}.{nearest(key, keys)}")

    def needs(self, *keys: str) -> None:
        """Report each of these keys that is missing as a mistake."""
        for key in keys:
            if key not in self.values:
                self.say(key, "the key is missing. Add the key.")

    def table(self, key: str) -> "TomlTable":
        """Return the table under a key; an empty table if the key is absent.

        A value that is not a table is a mistake, and gives an empty table too.
        """
        value = self.values.get(key, {})
        if not isinstance(value, Mapping):
            self.say(key, f"the value is {value!r}. Give a table, as in [{self.at(key)}].")
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
        """Call a function without arguments and return its result; None if it refuses.

        The refusal, a `TextError`, `ModelError` or `UsageError`, is added as a mistake.
        """
        try:
            return make()
        except TextError as error:
            self.say(key, f"{error.where}: {error.reason}", error.pointer)
        except (ModelError, UsageError) as error:
            self.say(key, str(error))
        return None

    def chosen(self, key: str, options: Mapping[str, T], what: str, hint: str = "") -> T | None:
        """Return the option whose name is the value of a key; None after a mistake.

        Parameters
        ----------
        key : str
        options : mapping of str to object
            Permitted options by name.
        what : str
            Noun for an option in the message, such as ``law``.
        hint : str
            Clause after the names of the options in the message; empty for none.
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
        """Return the value of a key in the type of an argument; None after a mistake.

        Parameters
        ----------
        key : str
        kind : type
            Annotation of the argument. A tuple or an iterable takes a list. A type other than text,
            number and bool takes an expression.
        symbols : mapping of str to sympy.Symbol
            Symbols that an expression may name.
        elements : mapping of str to callable, optional
            Elements of friction and load that an expression may call.
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
        """Return the values of the given keys that are in the table, by key.

        All have one type `kind`, as in `read`. A value of another type is omitted after a mistake,
        and any other key of the table is a mistake.
        """
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
        arguments, the argument that causes the refusal is searched, reported and omitted. The
        function is then called again, until it accepts, so that all mistakes are found.

        Parameters
        ----------
        make : callable
            Function whose arguments are the keys of the table.
        symbols : mapping of str to sympy.Symbol
            Symbols that expressions may name.
        arguments : mapping of str to inspect.Parameter
            Arguments of `make`, if its signature does not state them.
        name : str
            Value of the argument ``name``, if the table's own key is the name, as in
            ``[parameters.M]``; empty if ``name`` is an ordinary argument.
        given : mapping
            Values of arguments that are not keys of the table.
        beside : collection of str
            Further permitted keys of the table, which are not arguments.
        own : mapping of str to mapping
            For single keys, the symbols that their expressions may name instead of `symbols`.
        elements : mapping of str to mapping
            For single keys, the elements of friction and load that their expressions may call.
        """
        count_before = len(self.mistakes)
        known = arguments or inspect.signature(make).parameters
        # Check the keys: each must be an argument, and each argument without default must be there.
        not_keys = {*given, "name"} if name else given
        keys = {key: argument for key, argument in known.items() if key not in not_keys}
        needed = {key: argument for key, argument in known.items() if argument.default is _ABSENT}
        self.only(*beside, *keys)
        self.needs(*(key for key in needed if key in keys))
        # Read the values; None stands for a value that could not be read.
        found = {
            key: self.read(
                key, keys[key].annotation, own.get(key, symbols), elements.get(key, _NONE)
            )
            for key in self.values
            if key in keys
        }
        # A value that could not be read is reported already, and a substitute replaces it.
        stand_ins = {key: _neutral(argument) for key, argument in known.items()}
        fields = {key: stand_ins[key] if value is None else value for key, value in found.items()}
        fields |= {"name": name} if name else {}
        neutral = {**{key: stand_ins[key] for key in needed}, **given}
        # Call the function until it accepts, each time without the argument that it refused.
        result: T | ModelError | None = _result_or_refusal(make, {**neutral, **fields})
        while isinstance(result, ModelError):
            key, fields = _without_refused(make, neutral, fields, stand_ins, result)
            # Not reported: a substitute that is refused, and, if there are other mistakes already,
            # a refusal for which no argument was found.
            if found.get(key, "") is not None and (key or len(self.mistakes) == count_before):
                self.say(key if key in self.values else "", str(result))
            result = _result_or_refusal(make, {**neutral, **fields}) if key else None
        return result if len(self.mistakes) == count_before else None

    def each(self, make: Callable[..., T], **how: Any) -> dict[str, T | None]:
        """Return the objects made from the tables in this table, by name.

        A table with a mistake gives None. The arguments are those of `made`.
        """
        return {name: self.table(name).made(make, name=name, **how) for name in self.values}


_ABSENT = inspect.Parameter.empty


def _without_refused(
    make: Callable[..., Any],
    neutral: Mapping[str, Any],
    fields: Mapping[str, Any],
    stand_ins: Mapping[str, Any],
    error: ModelError,
) -> tuple[str, dict[str, Any]]:
    """Return the name of the argument that causes a refusal, and the arguments without it.

    First each argument is omitted, or replaced by an acceptable value, to see if the function then
    accepts the rest. Otherwise each argument is tried alone among acceptable values: the argument
    that gives the same refusal is the cause. The name is empty if no argument is found.

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
            if not isinstance(_result_or_refusal(make, {**neutral, **others}), ModelError):
                return key, others
    refusal, of_neutral = str(error), str(_result_or_refusal(make, neutral))
    refused = ""
    for key in fields:
        of_key = str(_result_or_refusal(make, {**neutral, key: fields[key]}))
        if of_key == refusal != of_neutral:
            refused = key
            break
    return refused, {name: value for name, value in fields.items() if name != refused}


def _result_or_refusal(make: Callable[..., T], fields: Mapping[str, Any]) -> T | ModelError:
    """Return the object that a function makes, or the error with which it refuses."""
    try:
        return make(**fields)
    except ModelError as error:
        return error


def _neutral(argument: inspect.Parameter) -> Any:
    """Return a value for an argument that most functions accept: 1, or a name for a text."""
    kind = argument.annotation
    if str in (kind, *get_args(kind)):
        return "1" if argument.name == "unit" else "x"
    if get_origin(kind) is tuple:
        return (1.0,)
    return 1 if kind is int else 1.0


def _plain(kind: type, value: object) -> Any:
    """Return a value that is a text, a whole number or a bool; refuse a value of another type."""
    if type(value) is kind and (not isinstance(value, str) or value.isprintable()):
        return value
    raise ModelError(f"the value is {value!r}. Give {_GIVE[kind]}.", code="toml")


_GIVE = {str: "one line of text in quotes", int: "a whole number", bool: "true or false"}


# The function that takes the number as an argument decides whether it may be infinite.
_number = partial(number, what="the value", finite=False)


def _expression(value: Any, symbols: Symbols, elements: Elements) -> Any:
    """Return the expression that a text contains, or the value itself if it is a plain number."""
    if isinstance(value, str):
        return read_expression(value, symbols, elements)
    if isinstance(value, (list, Mapping)):
        raise ModelError(
            f"the value is {value!r}. Give an expression in quotes, or a number.", code="toml"
        )
    number(value, "the value")
    return value


#: Functions that read a value, by the annotation of its argument.
_KINDS: Mapping[Any, Callable[[Any], Any]] = {
    **{kind: partial(_plain, kind) for kind in _GIVE},
    float: _number,
    float | None: _number,
    float | Any: _number,
    **dict.fromkeys((str | int, float | str), lambda value: value),
}


_LARGEST_FILE = 50_000


def read_toml(file: Path, read: Callable[[TomlTable], T | None], error: type[FileError]) -> T:
    """Return the object that a function builds from the table of a TOML file.

    Parameters
    ----------
    file : Path
    read : callable
        Function that takes the table and returns the object. It adds mistakes to the table, and may
        then return None.
    error : type of FileError
        Type of the error that is raised.

    Raises
    ------
    FileError
        The file cannot be read, or has mistakes; the message lists all mistakes.
    """
    mistakes: list[str] = []
    result = read(TomlTable("", toml_document(file, error), mistakes))
    if result is None or mistakes:
        count = "a mistake" if len(mistakes) == 1 else f"{len(mistakes)} mistakes"
        raise error(f"{file} has {count}:", mistakes)
    return result


def read_columns(table: TomlTable, roles: Iterable[str]) -> dict[str, str]:
    """Return the columns of a log by role, each as the text that ``--columns`` takes.

    Parameters
    ----------
    table : TomlTable
        For each role, a text or a table of the arguments of `Column`.
    roles : iterable of str
        Permitted roles; another key is a mistake.
    """
    keys = dict.fromkeys(roles)
    table.only(*keys)
    texts: dict[str, str] = {}
    for key in keys:
        if key not in table.values:
            continue
        if isinstance(table.values[key], Mapping):
            column = table.table(key).made(Column)
        else:
            column = table.read(key, str)
        if column is not None:
            texts[key] = str(column)
    return texts


_DEEPEST_KEY = 32  # parts of a dotted key; keys of a declaration have 4 at most
# A key of so many parts is refused: the parser's memory and time grow with the square of the parts.
_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{_DEEPEST_KEY}}}")
# Strings and comments, which may have any number of dots. An unterminated string extends as far as
# it can.
_STRINGS = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\Z)'
    r"|'''.*?(?:'''|\Z)"
    r'|"(?:[^"\\\n]|\\.)*"?'
    r"|'[^'\n]*'?"
    r"|#[^\n]*",
    re.DOTALL,
)


def _as_part(found: re.Match[str]) -> str:
    """Return the text that replaces a match of `_STRINGS` while keys are checked.

    It is a letter for a string, and empty for a comment.
    """
    return "" if found[0].startswith("#") else "q"


def toml_document(file: Path, error: type[FileError]) -> dict[str, Any]:
    """Return the values of a TOML file by key.

    Parameters
    ----------
    file : Path
    error : type of FileError
        Type of the error that is raised.

    Raises
    ------
    FileError
        The file cannot be read, is larger than 50000 bytes, is nested too deeply, or is not TOML.
    """
    try:
        with opened_regular(file) as stream:
            content = stream.read(_LARGEST_FILE + 1)
    except (OSError, ValueError) as wrong:  # a null in the name
        why = getattr(wrong, "strerror", None) or str(wrong)
        raise error(f"{str(file)!r} cannot be read: {why}. Check the path.") from wrong
    if len(content) > _LARGEST_FILE:
        raise error(
            f"{file} is larger than {_LARGEST_FILE} bytes, the limit for a TOML file. Keep data in "
            "the log, not in this file.",
            code="toml",
        )
    try:
        text = content.decode("utf-8-sig")
        if _LONG_KEY.search(_STRINGS.sub(_as_part, text)):
            raise RecursionError
        return tomllib.loads(text)
    except (ValueError, RecursionError) as wrong:  # ValueError also if the text is not UTF-8
        if isinstance(wrong, RecursionError):
            raise error(
                f"{file} is nested too deeply: a key or a value has too many levels. Use keys with "
                "few dots and tables with few levels."
            ) from wrong
        reason = str(wrong)
        remedy = "Correct the file"
        if "Invalid value" in reason:
            remedy = "Put texts and expressions in quotes"
        raise error(f"{file} is not valid TOML: {reason}. {remedy}.") from wrong
