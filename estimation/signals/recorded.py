"""What an axis needs of a record beside its motion: signals that it declares, and the position.

Signals are no part of what is differentiated, so that they stand in the rows as the force does: as
they were recorded. Products of them and the motion are made sample by sample, and both sides of the
rows then take the same decimation filter. What is held changes at a sample: its mean about the
sample belongs to the acceleration there.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy, Setting

from .signals import about_samples
from .without_turns import dependence

_POSITION = 0  # among what the inverse model takes
_OF_DRIVE = 1  # among what the drive takes


def recorded_signals(
    axis: GeneratedAxis, source: str, columns: Mapping[str, Array]
) -> tuple[Array, ...]:
    """The signals that an axis declares, in its order, (N,) each.

    Parameters
    ----------
    axis : GeneratedAxis
    source : str
        Of the record, for messages.
    columns : mapping of str to (N,) array
        By role or name.

    Raises
    ------
    DataError
        The record lacks one.
    """
    names = [signal.name for signal in axis.axis.signals]
    if missing := [name for name in names if name not in columns]:
        raise DataError(
            f"{source} has no column for {', '.join(missing)}, which axis {axis.axis.name!r} has "
            "as recorded signals; ",
            Remedy.of(
                "name it with ",
                Setting("columns", ",".join(f"{name}=NAME" for name in missing)),
                ".",
            ),
            code="no-signal",
        )
    return tuple(columns[name] for name in names)


def beside_motion(
    axis: GeneratedAxis, recorded: Sequence[Array], starts: Sequence[int]
) -> tuple[Array, ...]:
    """The same as they stand in the rows; segments begin at `starts`."""
    return tuple(
        about_samples(values, starts) if signal.is_held else values
        for signal, values in zip(axis.axis.signals, recorded, strict=True)
    )


def check_position(axis: GeneratedAxis, record: Record) -> None:
    """Refuse a record of velocity alone for an axis whose model needs the position.

    Raises
    ------
    DataError
        It does; what depends on the position is named.
    """
    needing = _needing(axis) if record.integrated else []
    if not needing:
        return
    raise DataError(
        f"{record.provenance.source} has no position, on which {' and '.join(needing)} of axis "
        f"{axis.axis.name!r} depend{'s' * (len(needing) == 1)}; the integral of a measured "
        "velocity drifts. ",
        Remedy.of("Name it with ", Setting("columns", "position=NAME"), "."),
        code="no-position",
    )


def _needing(axis: GeneratedAxis) -> list[str]:
    """What of an axis depends on the position, in words."""
    columns = dependence(axis)["position"]
    found = [name for name, needs in zip(axis.names, columns, strict=True) if needs]
    if _depends(axis, "idm_regressor", 1, _POSITION):
        found.append("the known terms")
    if _depends(axis, "drive_force", 0, _OF_DRIVE):
        found.append("the force of the drive")
    return found


def _depends(axis: GeneratedAxis, name: str, output: int, place: int) -> bool:
    return bool(np.any(axis.functions[name].jac_sparsity(output, place).nnz()))
