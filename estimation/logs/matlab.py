"""MATLAB files: v4 to v7.2 by SciPy, v7.3 (HDF5) by h5py; structures become dotted names."""

import io
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

import numpy as np

from axisid.estimation.tables import Table, TableBuilder, library, refusing
from axisid.support.errors import DataError
from axisid.support.memory import Room

_HDF5 = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # MATLAB's own header stands before the HDF5 part
_HEAD, _TAG = 128, 8  # bytes of the head of a version 5 file, and of the tag of an element
_NUMERIC = {
    "double",
    "single",
    "logical",
    *(f"{u}int{b}" for u in ("", "u") for b in (8, 16, 32, 64)),
}


def read_matlab(file: Path, content: bytes, room: Room) -> Table:
    """Read a MATLAB file.

    Numeric vectors are columns, the columns of a matrix are numbered from 1 (``data.1``), fields
    of structures are named as in MATLAB (``log.position``, ``log.signals.2.values``), elements of
    cells and of arrays of structures are numbered as MATLAB's linear index does.

    Raises
    ------
    DataError
        The file is damaged, unfolds to more than there is room for, or holds nothing but objects;
        what to run in MATLAB is said.
    """
    hdf5 = _HDF5 in (content[: len(_HDF5)], content[_USER_BLOCK : _USER_BLOCK + len(_HDF5)])
    found, objects, names = (_read_hdf5 if hdf5 else _read_mat)(file, content, room)
    how = _how_to_save(objects)
    return found.table(
        str(file),
        notes=("MATLAB v7.3",) if hdf5 else (),
        missing=how,
        advice=f"its variables are {', '.join(names) or 'none'}. {how}".rstrip(". "),
    )


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


def _read_mat(file: Path, raw: bytes, room: Room) -> tuple[TableBuilder, list[str], list[str]]:
    from scipy.io import loadmat

    _take_elements(raw, room)
    with refusing(DataError(f"{file} cannot be read as a MATLAB file", code="log-file")):
        content = loadmat(io.BytesIO(raw), simplify_cells=True)  # type: ignore[arg-type]
    found, objects = TableBuilder(room=room), []
    variables = {name: v for name, v in content.items() if not str(name).startswith("__")}
    for name, value in variables.items():
        if type(value).__name__ == "MatlabOpaque":
            objects += [_text(entry) for entry in np.asarray(value)["s0"].ravel()]
        else:
            for path, leaf in _leaves(str(name), value):
                found.add_array(path, leaf)
    names = [name for name in variables if isinstance(name, str) and name != "None"]
    return found, objects, [*names, *(o for o in objects if o not in names)]


def _take_elements(raw: bytes, room: Room) -> None:
    """Count what the elements of a file hold, packed ones unpacked, before any is held.

    What is damaged is left to the parser, which says so.
    """
    if 1032 * len(raw) <= room.left:  # the most that zlib's bytes unfold to
        return
    order: Literal["little", "big"] = "big" if raw[_HEAD - 2 : _HEAD] == b"MI" else "little"
    place = _HEAD
    while place + _TAG <= len(raw):
        kind, size = (int.from_bytes(raw[start : start + 4], order) for start in (place, place + 4))
        place += _TAG
        if kind == 15:  # packed by zlib
            stream, packed = zlib.decompressobj(), raw[place : place + size]
            with suppress(zlib.error):
                while packed and not stream.eof:
                    room.take(len(stream.decompress(packed, 1 << 24)))
                    packed = stream.unconsumed_tail
        else:
            room.take(size if place + size <= len(raw) else 0)
        place += size


def _text(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """What lies in structures and cells, by dotted names; elements are numbered from 1."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}.{name}", inner)
    elif hasattr(value, "_fieldnames"):  # SciPy's structure, as one of a matrix of them
        for name in value._fieldnames:
            yield from _leaves(f"{path}.{name}", getattr(value, name))
    elif isinstance(value, (list, tuple)):
        for k, inner in enumerate(value, 1):
            yield from _leaves(f"{path}.{k}", inner)
    elif isinstance(value, np.ndarray) and value.dtype == object:
        yield from _leaves(path, value.ravel(order="F").tolist())
    else:
        yield path, value


def _read_hdf5(file: Path, raw: bytes, room: Room) -> tuple[TableBuilder, list[str], list[str]]:
    h5py = library("h5py", "h5py", file)
    damaged = DataError(f"{file} cannot be read as a MATLAB v7.3 file", code="log-file")
    with refusing(damaged), h5py.File(io.BytesIO(raw), "r") as content:
        names = [name for name in content if not name.startswith("#")]
        visit = _Hdf5(h5py, content, room)
        for name in names:
            visit.node(content[name], name)
    return visit.found, visit.objects, names


class _Hdf5:
    """Collects the numeric arrays of an HDF5 file; MATLAB stores them transposed."""

    def __init__(self, h5py: Any, content: Any, room: Room) -> None:
        self.h5py, self.content, self.room = h5py, content, room
        self.found, self.objects = TableBuilder(room=room), list[str]()

    def node(self, node: Any, path: str) -> None:
        """Take a group or a data set, and what it refers to."""
        kind = _text(node.attrs.get("MATLAB_class", b"double"))
        if isinstance(node, self.h5py.Group):
            for name, inner in node.items():
                if self._refers(inner) and "MATLAB_class" not in inner.attrs:
                    # A field of an array of structures: a reference for each of them.
                    self._elements(inner, path, f".{name}")
                else:
                    self.node(inner, f"{path}.{name}")
        elif self._refers(node):
            self._elements(node, path)
        elif "MATLAB_object_decode" in node.attrs or kind not in {*_NUMERIC, "cell", "char"}:
            self.objects.append(path)
        elif kind == "char":
            self.found.pass_over(path, "text")
        elif kind in _NUMERIC and not (node.shape is None or "MATLAB_empty" in node.attrs):
            self.room.take(node.nbytes)
            self.found.add_array(path, np.asarray(node[()]).T)

    def _refers(self, node: Any) -> bool:
        dataset = isinstance(node, self.h5py.Dataset)
        return dataset and self.h5py.check_ref_dtype(node.dtype) is self.h5py.Reference

    def _elements(self, references: Any, path: str, field: str = "") -> None:
        """Cells or structures, in the order of MATLAB's linear index."""
        for k, reference in enumerate(np.ravel(references[()]), 1):
            if reference:
                self.node(self.content[reference], f"{path}.{k}{field}")
