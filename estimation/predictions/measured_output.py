"""What of a record a simulated output is held against."""

from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices import CONTROL, FORCE
from axisid.estimation.records import Record
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy, Setting


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredOutput:
    """An output as a record has it.

    Attributes
    ----------
    signal : str
        What it is of a simulation, as `Simulation` names it.
    unit : str
    values : (N,) array
    """

    signal: str
    unit: str
    values: Array


def measured_output(output: str, axis: GeneratedAxis, record: Record) -> MeasuredOutput:
    """The recorded output that a fit follows.

    Parameters
    ----------
    output : str
        Of `axisid.estimation.choices.OUTPUTS`.
    axis : GeneratedAxis
    record : Record

    Raises
    ------
    DataError
        The record has no such column.
    """
    q, drive = axis.axis.coordinate, axis.axis.drive
    if output == CONTROL:
        return MeasuredOutput(
            signal=CONTROL, unit=drive.unit, values=_column(record, "control", record.control)
        )
    if output == FORCE:
        return MeasuredOutput(
            signal=FORCE, unit=str(q.force_unit), values=_column(record, "force", record.force)
        )
    position = None if record.integrated else record.position
    return MeasuredOutput(
        signal="position", unit=str(q.unit), values=_column(record, "position", position)
    )


def _column(record: Record, role: str, values: Array | None) -> Array:
    if values is not None:
        return np.asarray(values)
    raise DataError(
        f"{record.provenance.source} has no {role} column, which the fit is to follow; ",
        Remedy.of(
            "name it with ", Setting("columns", f"{role}=NAME"), ", or choose another output."
        ),
        code="no-output",
    )
