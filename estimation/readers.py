"""Read a record from a file: delimited text with a header row, or MATLAB v4 to v7.2."""

import csv
import hashlib
import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from axisid.codegen import GeneratedAxis
from axisid.modeling import ROLES, Axis, UsageError

from .arrays import Array
from .errors import DataError
from .record import Provenance, Record

_DELIMITERS = ",;\t"
_NEEDED = ("position",)


def read_record(
    path: str | Path,
    axis: Axis | GeneratedAxis | None = None,
    *,
    columns: Mapping[str, str] | None = None,
    sample_period: float | None = None,
) -> Record:
    """Read a record, its columns found by the roles' names.

    Parameters
    ----------
    path : str or Path
        ``.csv``, ``.txt`` or ``.tsv`` with one header row; ``.mat`` up to v7.2.
    axis : Axis or GeneratedAxis, optional
        Its `columns` name the columns of its logs.
    columns : mapping of str to str, optional
        Column names by role, over those of the axis. A role that neither names is looked for
        under its own name (``time``, ``position``, ``reference``, ``control``, ``force``).
    sample_period : float, optional
        s; takes the place of the time column's mean step, and of the column if there is none.

    Returns
    -------
    Record
        Values as in the file, taken to be SI.

    Raises
    ------
    DataError
        The file is missing or malformed, or lacks a column.
    UsageError
        A role does not exist.
    """
    file = Path(path)
    try:
        content = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file} cannot be read: {error.strerror}. Check the path.") from error
    if isinstance(axis, GeneratedAxis):
        axis = axis.axis
    table = _read_mat(file, content) if file.suffix.lower() == ".mat" else _read_text(file, content)
    chosen = _choose(file, table, axis, dict(columns or {}))
    values = {role: table[column] for role, column in chosen.items()}
    if "time" not in values:
        if sample_period is None:
            raise DataError(
                f"{file}: there is no time column among {_listed(table)}; name it with "
                "--columns time=NAME, or give --sample-period."
            )
        values["time"] = sample_period * np.arange(len(values["position"]), dtype=np.float64)
    return Record(
        **values,
        sample_period=sample_period,
        provenance=Provenance(
            source=file.name, sha256=hashlib.sha256(content).hexdigest(), columns=chosen
        ),
    )


def _choose(
    file: Path, table: Mapping[str, Array], axis: Axis | None, asked: dict[str, str]
) -> dict[str, str]:
    for role in asked:
        if role not in ROLES:
            raise UsageError(f"{role!r} is no role of a column; the roles are {', '.join(ROLES)}.")
    declared = dict(axis.columns) if axis is not None else {}
    chosen = {}
    for role in ROLES:
        name = asked.get(role) or declared.get(role) or role
        if name in table:
            chosen[role] = name
        elif role in asked or role in declared or role in _NEEDED:
            raise DataError(
                f"{file}: there is no column {name!r} for the {role}; found {_listed(table)}. "
                f"Name the column with --columns {role}=NAME."
            )
    return chosen


def _listed(table: Mapping[str, Array]) -> str:
    return ", ".join(table) or "no columns"


def _read_text(file: Path, content: bytes) -> dict[str, Array]:
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise DataError(
            f"{file} is not a text file in UTF-8 (byte {error.start}); the formats read are "
            "delimited text (.csv, .tsv, .txt) and MATLAB (.mat)."
        ) from error
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
    if len(rows) < 2:
        raise DataError(
            f"{file}: a header row and samples are expected; it has {len(rows)} filled lines."
        )
    delimiter = max(_DELIMITERS, key=rows[0][1].count)
    header = [name.strip() for name in _cells(file, *rows[0], delimiter)]
    _check_header(file, header)
    try:
        values = np.loadtxt(
            (line for _, line in rows[1:]), delimiter=delimiter, ndmin=2, comments=None
        )
    except ValueError:
        values = _parse_slowly(file, rows[1:], header, delimiter)
    if values.shape[1] != len(header):
        raise DataError(
            f"{file}: the header names {len(header)} columns ({', '.join(header)}), the rows have "
            f"{values.shape[1]}. Correct the header row."
        )
    return dict(zip(header, values.T, strict=True))


def _cells(file: Path, number: int, line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter))
    except csv.Error as error:
        raise DataError(f"{file}, line {number} is no row of a table: {error}.") from error


def _check_header(file: Path, header: list[str]) -> None:
    if all(_is_number(name) for name in header):
        raise DataError(
            f"{file}: the first row holds numbers ({', '.join(header[:4])}); write the names of "
            "the columns above it."
        )
    doubled = sorted({name for name in header if header.count(name) > 1})
    if doubled:
        raise DataError(f"{file}: column {', '.join(doubled)} occurs twice; rename one.")


def _parse_slowly(
    file: Path, rows: list[tuple[int, str]], header: list[str], delimiter: str
) -> Array:
    """Find the cell that the fast parser stumbled over; a quoted number is fine."""
    values = []
    for number, line in rows:
        cells = _cells(file, number, line, delimiter)
        if len(cells) != len(header):
            raise DataError(
                f"{file}, line {number}: {len(cells)} cells where the header names {len(header)} "
                f"columns ({', '.join(header)}). The header is the first filled line; remove lines "
                "above it."
            )
        for name, cell in zip(header, cells, strict=True):
            if not _is_number(cell):
                raise DataError(
                    f"{file}, line {number}: {cell.strip()!r} in column {name!r} is not a number; "
                    "numbers are written with a decimal point."
                )
        values.append([float(cell) for cell in cells])
    return np.array(values)


def _is_number(cell: str) -> bool:
    if "_" in cell or not cell.isascii():  # float() takes 1_000 and other scripts' digits
        return False
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _read_mat(file: Path, raw: bytes) -> dict[str, Array]:
    from scipy.io import loadmat

    try:
        content = loadmat(io.BytesIO(raw))  # type: ignore[arg-type]
    except NotImplementedError as error:
        raise DataError(
            f"{file} is a MATLAB v7.3 file; save it with save(..., '-v7') and try again."
        ) from error
    except Exception as error:
        # The parser meets damaged files with whatever comes: zlib, memory, index and name errors.
        raise DataError(f"{file} cannot be read as a MATLAB file: {error}.") from error
    vectors = {
        name: np.asarray(value, dtype=float).ravel()
        for name, value in content.items()
        if isinstance(value, np.ndarray)
        and value.dtype.kind in "fiu"
        and value.size > 1
        and value.size == max(value.shape)
    }
    if not vectors:
        raise DataError(
            f"{file} holds no numeric vectors; its variables are "
            f"{', '.join(name for name in content if not name.startswith('__')) or 'none'}."
        )
    return vectors
