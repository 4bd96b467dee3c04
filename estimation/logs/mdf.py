"""Reading of MDF files of measurement systems with asammdf."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.raw_tables import Table, TableBuilder, numbered
from axisid.support.libraries import library, one_line, refusing
from axisid.support.memory import Room


def read_mdf(file: Path, room: Room) -> Table:
    """Return the table of an MDF file; the times of a channel are the master time of its group.

    Channels whose names occur several times are named ``GROUP.NAME``, with groups numbered from 0
    as in MDF tools; if that name occurs twice too, ``GROUP.INDEX.NAME``. Samples that are marked as
    invalid are NaN.

    Raises
    ------
    DataError
        The file is damaged, needs more memory than is available, or asammdf is not installed.
    """
    asammdf, builder = library("asammdf", "mdf", file), TableBuilder(room=room)
    with (
        refusing(f"{file} cannot be read as an MDF file. Write the file again. The error is"),
        asammdf.MDF(file) as mdf,
    ):
        for name, group, index in _mdf_names(mdf):
            # Memory of the samples and times of the channel, before they are read.
            room.take(2 * 8 * mdf.groups[group].channel_group.cycles_nr)
            try:
                signal = mdf.get(group=group, index=index, ignore_invalidation_bits=True)
            except Exception as error:
                builder.pass_over(name, f"data that asammdf cannot read ({one_line(error)})")
                continue
            values, invalid = np.asarray(signal.samples), signal.invalidation_bits
            if invalid is not None and values.dtype.kind in "fiub":
                values = np.where(np.asarray(invalid, dtype=bool), np.nan, values)
            count = 0 if invalid is None else np.count_nonzero(invalid)
            builder.add(
                name,
                values,
                unit=signal.unit or "",
                clock=np.asarray(signal.timestamps, dtype=np.float64),
                note=f"{name}: {count} samples are marked as invalid" if count else "",
            )
    return builder.table(str(file), advice="record channels of numbers")


def _mdf_names(mdf: Any) -> list[tuple[str, int, int]]:
    """Return unique name, group and index of each channel, without the master channels."""
    places = [
        (name, group, index)
        for name, where in mdf.channels_db.items()
        for group, index in where
        if mdf.masters_db.get(group) != index
    ]
    # Names that occur several times get their group, and if necessary their index.
    names = [name for name, _, _ in places]
    for longer in ("{1}.{0}", "{1}.{2}.{0}"):
        often = Counter(names)
        names = [
            longer.format(*place) if often[name] > 1 else name
            for name, place in zip(names, places, strict=True)
        ]
    return [(name, *place[1:]) for name, place in zip(numbered(names), places, strict=True)]
