"""A drive's lag or delay that is declared as known, from a record."""

from collections.abc import Sequence

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.modeling.declaration import Axis

from .drive_time import DriveTiming, check_time, searched_time, with_time
from .identify import identify
from .result import Identification


def estimate_drive_timing(
    axis: Axis | GeneratedAxis,
    record: Record,
    name: str = "lag",
    prefilter: Prefilter | None = None,
) -> DriveTiming:
    """Estimate the lag or the delay of an axis's drive, and its parameters with it.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a sampled control law. What is declared of the other time is taken as known.
    record : Record
        With a control and a reference.
    name : str
        ``lag`` or ``delay``: at most one, since a record shows their sum.
    prefilter : Prefilter, optional
        What suits the record by default.

    Raises
    ------
    UsageError
        There is no such time, or the control was recorded where nothing shows it.
    EstimationError
        The record does not show it, or the force acts before its command.
    """
    declared = axis.declared if isinstance(axis, GeneratedAxis) else axis
    check_time(declared, record, name)
    known = with_time(declared, name, float(getattr(declared.drive, name)))

    def run(tried: GeneratedAxis, methods: Sequence[str] | None) -> Identification:
        return identify(tried, record, prefilter, methods)

    return searched_time(known, record, name, run)
