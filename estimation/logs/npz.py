"""Reading of NumPy archives: vectors, columns of matrices and fields of records."""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import msgspec
import numpy as np

from axisid.estimation.raw_tables import UNITS_ENTRY, Table, TableBuilder
from axisid.support.libraries import refusing
from axisid.support.memory import Room
from axisid.support.settings import setting

from .column_checks import once


def read_npz(file: Path, content: bytes, room: Room) -> Table:
    """Return the table of a NumPy archive.

    Columns are vectors, columns of matrices (``data.1``), and fields of records. An entry
    ``axisid.units``, if there is one, has the units: a JSON object of units by name. Python objects
    are not read, as they could execute code.

    Raises
    ------
    DataError
        The archive is damaged, has no vectors, has units that cannot be read, or needs more memory
        than is available.
    """
    builder = TableBuilder(room=room)
    with (
        refusing(
            f"{file} cannot be read as a NumPy archive. Write the archive with numpy.savez. The "
            "error is"
        ),
        ZipFile(io.BytesIO(content)) as packed,
        np.load(io.BytesIO(content), allow_pickle=False) as archive,
    ):
        with refusing(
            f"the entry {UNITS_ENTRY!r} of {file} is not a JSON object of units by name. Write the "
            'entry as {"position": "mm"}, or omit the entry and give the units with '
            f"{setting('columns', {'ROLE': 'NAME:UNIT'})}. The error is"
        ):
            written = archive[UNITS_ENTRY] if UNITS_ENTRY in archive.files else "{}"
            units = msgspec.convert(
                json.loads(str(written), object_pairs_hook=once), type=dict[str, str]
            )
        for name, entry in zip(archive.files, packed.infolist(), strict=True):
            room.take(entry.file_size)
            _add_entry(builder, name, archive, units)
    return builder.table(str(file), advice="save numeric vectors with numpy.savez")


def _add_entry(builder: TableBuilder, name: str, archive: Any, units: Mapping[str, str]) -> None:
    """Add an array, or the fields of its records, to the table.

    Python objects are added as a column that cannot be used, as they could execute code. `units`
    has the units by name.
    """
    try:
        array = archive[name]
    except ValueError as error:
        if "Object arrays" not in str(error):
            raise
        builder.pass_over(name, "Python objects, which could execute code")
        return
    if array.dtype.names is None:
        builder.add_array(name, array, unit=units.get(name, ""))
    for inner in array.dtype.names or ():
        builder.add_array(f"{name}.{inner}", array[inner])
