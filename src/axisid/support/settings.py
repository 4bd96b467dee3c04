"""Settings in sentences, spelled as the user types them.

A setting is an argument in Python, an option of the running command, or a key of a log's
``run.toml``. `setting` gives the text of a setting while a sentence is made. Who runs the program
(`settings_typed`, `settings_in_python`) decides the spelling.
"""

import json
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TypeAlias

#: Placeholders of numbers, which are written without quotes. Other names in capitals, such as the
#: mass M, are texts.
_NUMBERS = ("VALUE", "V1", "V2", "SECONDS", "FACTOR", "HZ")
_NUMBER = re.compile(r"[+-]?\d+(\.\d*)?(e[+-]?\d+)?")

#: Settings that are functions of an axis in Python, and options on the command line.
_FUNCTIONS = ("fix", "leave_out")

SettingValue: TypeAlias = str | bool | tuple[str, ...] | Mapping[str, str | tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class _Typed:
    """Spelling of settings for the running command.

    Attributes
    ----------
    options : mapping of str to str
        Options of the command by the argument in Python.
    keys : collection of str
        Keys of a ``run.toml``.
    """

    options: Mapping[str, str]
    keys: Collection[str]


#: Spelling for the running command; None for arguments in Python.
_TYPED: ContextVar[_Typed | None] = ContextVar("typed", default=None)


@contextmanager
def settings_typed(options: Mapping[str, str], keys: Collection[str]) -> Iterator[None]:
    """Spell settings as options of a command and as keys of a ``run.toml``, within the context.

    Parameters
    ----------
    options : mapping of str to str
        Options of the command by the argument in Python: ``--skip-bad`` by ``skip_bad``.
    keys : collection of str
        Keys of a ``run.toml``.
    """
    with _spelled(_Typed(options, keys)):
        yield


@contextmanager
def settings_in_python() -> Iterator[None]:
    """Spell settings as arguments in Python within the context, even while a command runs.

    This is used for text in files and in other processes.
    """
    with _spelled(None):
        yield


@contextmanager
def _spelled(typed: _Typed | None) -> Iterator[None]:
    """Spell settings for a command within the context; None: as arguments in Python."""
    token = _TYPED.set(typed)
    try:
        yield
    finally:
        _TYPED.reset(token)


def setting(name: str, value: SettingValue) -> str:
    """Return a setting as the user types it.

    Parameters
    ----------
    name : str
        Name of the argument in Python: ``skip_bad``.
    value : str, True, tuple of str, or mapping of str to str or tuple of str
        Value of the setting. A text in capitals, such as ``VALUE``, is a placeholder for a value
        that the user chooses.

    Returns
    -------
    str
        ``gaps="split"`` in Python, ``--gaps split`` for a command that has the option, otherwise
        ``gaps = "split" in run.toml`` for a key of a ``run.toml``.
    """
    typed = _TYPED.get()
    if typed is not None and name in typed.options:
        return f"{typed.options[name]} {_as_option(value)}".rstrip()
    if typed is not None and name in typed.keys:
        return f"{name} = {_as_toml(value)} in run.toml"
    if name in _FUNCTIONS and not isinstance(value, (str, bool, tuple)):
        pairs = ", ".join(f"{key}={_as_python(each)}" for key, each in value.items())
        return f"{name}(axis, {pairs})"
    if name in _FUNCTIONS:
        return f"{name}(axis, {_as_python(value)})"
    return f"{name}={_as_python(value)}"


def all_methods() -> str:
    """Return the text that prints a result with all methods: an option, or a call in Python."""
    return "summary(every=True)" if _TYPED.get() is None else "--all"


def other_command(command: str, name: str, value: SettingValue) -> str:
    """Return a command other than the running one, with one setting, as the user types it.

    For a command this is ``axisid fit --output open-loop``; in Python it is a call of the function,
    ``axisid.fit(..., output="open-loop")``.
    """
    if _TYPED.get() is None:
        return f"axisid.{command}(..., {name}={_as_python(value)})"
    return f"axisid {command} --{name.replace('_', '-')} {_as_option(value)}".rstrip()


def _as_option(value: SettingValue) -> str:
    """Return a value as the argument of a command-line option; empty for a flag."""
    if isinstance(value, bool):
        return ""
    if isinstance(value, tuple):
        return ",".join(value)
    if isinstance(value, str):
        return value
    return ",".join(f"{key}={_as_option(each)}" for key, each in value.items())


def _as_toml(value: SettingValue) -> str:
    """Return a value as it is written in a TOML file."""
    if isinstance(value, bool):
        return "true"
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{key} = {_as_toml(each)}" for key, each in value.items())
        return f"{{ {pairs} }}"
    return _as_literal(value)


def _as_python(value: SettingValue) -> str:
    """Return a value as a Python expression."""
    if isinstance(value, bool):
        return "True"
    if isinstance(value, Mapping):
        pairs = ", ".join(f'"{key}": {_as_python(each)}' for key, each in value.items())
        return f"{{{pairs}}}"
    return _as_literal(value)


def _as_literal(value: str | tuple[str, ...]) -> str:
    """Return a text or a list of texts as a literal, which is the same in TOML and Python."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_quoted, value))}]"
    return _quoted(value)


def _quoted(value: str) -> str:
    """Return a value in quotes; a number, or a placeholder of a number, without quotes.

    A number with its standard error, ``100+-1``, becomes the pair ``(100, 1)``.
    """
    if value in _NUMBERS:
        return value
    parts = value.split("+-")
    if all(_NUMBER.fullmatch(part) for part in parts):
        return value if len(parts) == 1 else f"({', '.join(parts)})"
    return json.dumps(value, ensure_ascii=False)
