"""Reading of MATLAB files: v4 to v7.2 by SciPy, v7.3 (HDF5) by h5py.

Fields of structures become columns with dotted names.
"""

import io
import warnings
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from axisid.estimation.raw_tables import Table, TableBuilder, twice
from axisid.support.libraries import library, refusing
from axisid.support.memory import Room

T = TypeVar("T")

_HDF5 = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # bytes of MATLAB's own header before the HDF5 part
_OBJECT = object()  # stands for an object that only MATLAB can open
#: MATLAB's numeric classes.
_NUMERIC = {
    "double",
    "single",
    "logical",
    *(f"{u}int{b}" for u in ("", "u") for b in (8, 16, 32, 64)),
}


def read_matlab(file: Path, content: bytes, room: Room) -> Table:
    """Return the table of a MATLAB file.

    Numeric vectors are columns, the columns of a matrix are numbered from 1 (``data.1``), fields
    of structures are named as in MATLAB (``log.position``, ``log.signals.2.values``), elements of
    cells and of arrays of structures are numbered as MATLAB's linear index does.

    Raises
    ------
    DataError
        The file is damaged, needs more memory than is available, or has only objects; the message
        gives the MATLAB commands that save their numbers.
    """
    # An HDF5 file has its signature at its beginning, or after MATLAB's header.
    hdf5 = _HDF5 in (content[: len(_HDF5)], content[_USER_BLOCK : _USER_BLOCK + len(_HDF5)])
    variables = (_of_hdf5 if hdf5 else _of_scipy)(file, content, room)
    builder, objects = TableBuilder(room=room), []
    for path, leaf in _leaves("", variables):
        if leaf is _OBJECT:
            objects.append(path)
        elif leaf is not None:
            builder.add_array(path, leaf)
    # The remedy for objects, such as a timeseries.
    remedy = ""
    if objects:
        are_objects = "is an object" if len(objects) == 1 else "are objects"
        remedy = (
            f"{', '.join(objects)} {are_objects} that only MATLAB can open. Save the numbers of a "
            f"timeseries in MATLAB: t = {objects[0]}.Time; x = squeeze({objects[0]}.Data); "
            "save('log.mat', 't', 'x', '-v7')."
        )
    named = f"the file has the variables {', '.join(variables)}" if variables else "it is empty"
    otherwise = "Save each column of the log as a numeric vector"
    return builder.table(
        str(file),
        notes=("MATLAB v7.3",) if hdf5 else (),
        missing=remedy,
        advice=f"{named}. {remedy or otherwise}".rstrip(". "),
    )


def _of_scipy(file: Path, raw: bytes, room: Room) -> dict[str, Any]:
    """Return the variables of a MATLAB file up to version 7.2 by name; `_OBJECT` for objects."""
    from scipy.io import loadmat

    _take_elements(raw, room)
    with refusing(f"{file} cannot be read as a MATLAB file. Write the file again. The error is"):
        _check_names(raw)
        content = _with_unique_names(
            lambda: loadmat(io.BytesIO(raw), simplify_cells=True)  # type: ignore[arg-type]
        )
    variables = {str(name): v for name, v in content.items() if not str(name).startswith("__")}
    # An object is replaced by the names under which it is stored.
    for name, value in [*variables.items()]:
        if type(value).__name__ == "MatlabOpaque":
            del variables[name]
            variables |= dict.fromkeys(
                [_text(entry) for entry in np.asarray(value)["s0"].ravel()], _OBJECT
            )
    return variables


def _check_names(raw: bytes) -> None:
    """Refuse a file of version 4 with two variables of one name, of which SciPy keeps only one.

    Raises
    ------
    DataError
    """
    from scipy.io import matlab, whosmat

    if matlab.matfile_version(io.BytesIO(raw))[0] == 0:  # type: ignore[arg-type]
        names = [name for name, *_ in whosmat(io.BytesIO(raw))]  # type: ignore[arg-type]
        for name in set(names):
            if names.count(name) > 1:
                raise twice(name)


def _with_unique_names(load: Callable[[], T]) -> T:
    """Return the result of a load by SciPy; refuse two variables of the same name.

    SciPy keeps only one of the variables and warns.

    Raises
    ------
    DataError
    """
    from scipy.io.matlab import MatReadWarning

    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Duplicate variable name", MatReadWarning)
        try:
            return load()
        except MatReadWarning as warning:
            raise twice(str(warning).split('"')[1]) from warning


def _take_elements(raw: bytes, room: Room) -> None:
    """Count the memory of the decompressed elements of a file in `room`, before they are loaded.

    Damaged elements are ignored here; the parser refuses them.

    Raises
    ------
    DataError
        The elements need more memory than is available.
    """
    if 1032 * len(raw) <= room.left:  # a byte that zlib compressed becomes 1032 bytes at most
        return
    # A header of 128 bytes, then elements, each after a tag of 8 bytes: its kind and its size.
    order: Literal["little", "big"] = "big" if raw[126:128] == b"MI" else "little"
    place = 136
    while place <= len(raw):
        kind, size = (int.from_bytes(raw[at : at + 4], order) for at in (place - 8, place - 4))
        if kind == 15:  # compressed by zlib
            stream, packed = zlib.decompressobj(), raw[place : place + size]
            with suppress(zlib.error):
                while packed and not stream.eof:
                    room.take(len(stream.decompress(packed, 1 << 24)))
                    packed = stream.unconsumed_tail
        else:
            room.take(size if place + size <= len(raw) else 0)
        place += size + 8


def _text(value: object) -> str:
    """Return a name or attribute as text; bytes are decoded as UTF-8."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield name and value of each leaf of a value: of what is in structures and cells.

    Names have a dot between fields, and elements are numbered from 1. `path` is the name of the
    value; empty for all variables of a file.
    """
    if isinstance(value, np.ndarray) and value.dtype == object:
        value = value.ravel(order="F").tolist()
    if hasattr(value, "_fieldnames"):  # SciPy's structure, an element of an array of structures
        value = {name: getattr(value, name) for name in value._fieldnames}
    if isinstance(value, (list, tuple)):
        value = dict(enumerate(value, 1))
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}.{name}" if path else name, inner)
    else:
        yield path, value


def _of_hdf5(file: Path, raw: bytes, room: Room) -> dict[str, Any]:
    """Return the variables of a MATLAB file of version 7.3 by name; `_OBJECT` for objects."""
    h5py = library("h5py", "h5py", file)

    def is_reference(node: Any) -> bool:
        """Return True for a data set of references to other nodes."""
        return isinstance(node, h5py.Dataset) and h5py.check_ref_dtype(node.dtype) is h5py.Reference

    def value(node: Any) -> Any:
        """Return the value of a group or a data set in the form that SciPy gives.

        Numbers are arrays, which MATLAB stores transposed; structures are mappings; cells and
        arrays of structures are lists; a text is ``"text"``; an empty array is None.
        """
        kind = _text(node.attrs.get("MATLAB_class", b"double"))
        if isinstance(node, h5py.Group):
            fields = {name: value(inner) for name, inner in node.items()}
            # An array of structures has data sets of references, without a class, as its fields.
            are_elements = [
                is_reference(n) and "MATLAB_class" not in n.attrs for n in node.values()
            ]
            if not are_elements or not all(are_elements):
                return fields
            return [
                dict(zip(fields, each, strict=True)) for each in zip(*fields.values(), strict=True)
            ]
        if is_reference(node):
            return [value(content[each]) if each else None for each in np.ravel(node[()])]
        if "MATLAB_object_decode" in node.attrs or kind not in {*_NUMERIC, "cell", "char"}:
            return _OBJECT
        if kind in _NUMERIC and not (node.shape is None or "MATLAB_empty" in node.attrs):
            room.take(node.nbytes)
            return np.asarray(node[()]).T
        return "text" if kind == "char" else None

    with (
        refusing(
            f"{file} cannot be read as a MATLAB v7.3 file. Write the file again. The error is"
        ),
        h5py.File(io.BytesIO(raw), "r") as content,
    ):
        return {name: value(content[name]) for name in content if not name.startswith("#")}
