"""The signals that an axis declares, as a record has them, and as they stand beside the motion.

They are no part of what is differentiated, so that they stand in the rows as the force does: as
they were recorded. Products of them and the motion are made sample by sample, and both sides of the
rows then take the same decimation filter. What is held changes at a sample: its mean about the
sample belongs to the acceleration there.
"""

from collections.abc import Mapping, Sequence

from axisid.codegen.artefacts import GeneratedAxis
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy, Setting

from .signals import about_samples


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
