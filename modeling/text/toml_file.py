"""A TOML file that a user wrote: its tables, columns of logs in it, and all that is wrong."""

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from axisid.modeling.declaration import Column
from axisid.support.errors import FileError
from axisid.support.files import opened_regular

from .toml_table import Table

_LARGEST_FILE = 50_000

T = TypeVar("T")


def read_toml(file: Path, read: Callable[[Table], T | None], error: type[FileError]) -> T:
    """What is made of the table of a file.

    Parameters
    ----------
    file : Path
    read : callable
        Makes it, or says what is wrong as mistakes of the table.
    error : type of FileError

    Raises
    ------
    FileError
        Of that type: the file cannot be read, or with all that is wrong in it.
    """
    mistakes: list[str] = []
    made = read(Table("", toml_document(file, error), mistakes))
    if made is None or mistakes:
        count = "a mistake" if len(mistakes) == 1 else f"{len(mistakes)} mistakes"
        raise error(f"{file} has {count}:", mistakes)
    return made


def read_columns(table: Table, roles: Iterable[str]) -> dict[str, str]:
    """Columns by role, each a text or a table of what it means."""
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


def toml_document(file: Path, error: type[FileError]) -> dict[str, Any]:
    """The table of a file, as TOML has it.

    Raises
    ------
    FileError
        Of that type: the file cannot be read, or is not TOML.
    """
    text = _text(file, error)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as wrong:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(wrong))
        lines = text.splitlines()
        pointer = []
        if place and int(place[1]) <= len(lines):
            line, column = lines[int(place[1]) - 1], int(place[2]) - 1
            start = max(0, column - 40)
            shown = "".join(c if c.isprintable() else " " for c in line[start : start + 80])
            pointer = [f"{shown}\n{' ' * (column - start)}^"]
        what = "it is nested too deeply" if isinstance(wrong, RecursionError) else str(wrong)
        hint = " (text and expressions stand in quotes)" if "Invalid value" in what else ""
        raise error(f"{file} is not valid TOML: {what}{hint}.", pointer) from wrong


def _text(file: Path, error: type[FileError]) -> str:
    try:
        with opened_regular(file) as stream:
            content = stream.read(_LARGEST_FILE + 1)
    except (OSError, ValueError) as wrong:  # a null in the name
        why = getattr(wrong, "strerror", None) or str(wrong)
        raise error(f"{str(file)!r} cannot be read: {why}. Check the path.") from wrong
    if len(content) > _LARGEST_FILE:
        raise error(
            f"{file} is larger than such a file may be, {_LARGEST_FILE} bytes.", code="toml"
        )
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as wrong:
        line = content.count(b"\n", 0, wrong.start) + 1
        raise error(
            f"{file} is not UTF-8 text: see byte 0x{content[wrong.start]:02x} in line {line}. Save "
            "it as UTF-8.",
            code="toml",
        ) from wrong
