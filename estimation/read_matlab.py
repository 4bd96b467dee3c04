"""MATLAB files: v4 to v7.2 by SciPy, v7.3 (HDF5) by h5py; structures become dotted names."""

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .errors import DataError
from .table import Column, Table, library, told, vector_columns

_HDF5 = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # MATLAB's own header stands before the HDF5 part
_NUMERIC = {
    "double",
    "single",
    "logical",
    *(f"{u}int{b}" for u in ("", "u") for b in (8, 16, 32, 64)),
}


def read_matlab(file: Path, content: bytes) -> Table:
    """Read a MATLAB file.

    Numeric vectors are columns, the columns of a matrix are numbered from 1 (``data.1``), fields
    of structures are named as in MATLAB (``log.position``, ``log.signals.2.values``).

    Raises
    ------
    DataError
        The file is damaged, or holds nothing but objects; what to run in MATLAB is said.
    """
    if _HDF5 in (content[: len(_HDF5)], content[_USER_BLOCK : _USER_BLOCK + len(_HDF5)]):
        columns, objects, names = _read_hdf5(file, content)
        notes: tuple[str, ...] = ("MATLAB v7.3",)
    else:
        columns, objects, names = _read_mat(file, content)
        notes = ()
    how = _how_to_save(objects)
    if not columns:
        raise DataError(
            f"{file} holds no numeric vectors; its variables are {', '.join(names) or 'none'}."
            + (f" {how}" if how else "")
        )
    return Table(source=str(file), columns=columns, notes=notes, missing=how)


def _how_to_save(objects: list[str]) -> str:
    """What to run in MATLAB for variables that only MATLAB can open."""
    if not objects:
        return ""
    name = objects[0]
    return (
        f"{', '.join(objects)} {'is an object' if len(objects) == 1 else 'are objects'} that only "
        f"MATLAB can open; of a timeseries, for instance, save the numbers there: t = {name}.Time; "
        f"x = squeeze({name}.Data); save('log.mat', 't', 'x', '-v7')."
    )


def _read_mat(file: Path, raw: bytes) -> tuple[dict[str, Column], list[str], list[str]]:
    from scipy.io import loadmat

    try:
        content = loadmat(io.BytesIO(raw), simplify_cells=True)  # type: ignore[arg-type]
    except Exception as error:
        # The parser meets damaged files with whatever comes: zlib, memory, index and name errors.
        raise DataError(f"{file} cannot be read as a MATLAB file: {told(error)}.") from error
    columns: dict[str, Column] = {}
    objects = []
    variables = {name: v for name, v in content.items() if not str(name).startswith("__")}
    for name, value in variables.items():
        if type(value).__name__ == "MatlabOpaque":
            objects += [_text(entry) for entry in np.asarray(value)["s0"].ravel()]
        else:
            for path, found in _leaves(str(name), value):
                columns |= vector_columns(path, found)
    names = [name for name in variables if isinstance(name, str) and name != "None"]
    return columns, objects, [*names, *(o for o in objects if o not in names)]


def _text(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """What lies in structures and cells, by dotted names; elements are numbered from 1."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}.{name}", inner)
    elif isinstance(value, (list, tuple)) or (
        isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1
    ):
        for k, inner in enumerate(value, 1):
            yield from _leaves(f"{path}.{k}", inner)
    else:
        yield path, value


def _read_hdf5(file: Path, raw: bytes) -> tuple[dict[str, Column], list[str], list[str]]:
    h5py = library("h5py", "h5py", file)
    columns: dict[str, Column] = {}
    objects: list[str] = []
    try:
        with h5py.File(io.BytesIO(raw), "r") as content:
            names = [name for name in content if not name.startswith("#")]
            for name in names:
                _visit(h5py, content[name], name, columns, objects)
    except Exception as error:
        # Damaged files lead h5py to missing nodes, wrong types and failures of its own.
        raise DataError(f"{file} cannot be read as a MATLAB v7.3 file: {told(error)}.") from error
    return columns, objects, names


def _visit(h5py: Any, node: Any, path: str, columns: dict[str, Column], objects: list[str]) -> None:
    """Collect the numeric arrays of a group or data set; MATLAB stores them transposed."""
    kind = _text(node.attrs.get("MATLAB_class", b"double"))
    if isinstance(node, h5py.Group):
        for name, inner in node.items():
            _visit(h5py, inner, f"{path}.{name}", columns, objects)
    elif "MATLAB_object_decode" in node.attrs or kind not in {*_NUMERIC, "cell", "char", "struct"}:
        objects.append(path)
    elif kind in _NUMERIC and "MATLAB_empty" not in node.attrs:
        columns.update(vector_columns(path, node[()].T))
