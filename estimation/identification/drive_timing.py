"""A drive's lag or delay that is declared as known, from a record."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.modeling.declaration import Axis

from .drive_time import check_time, searched_time, with_time
from .identify import identify
from .result import Identification


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveTiming:
    """A lag or a delay as a record shows it.

    Attributes
    ----------
    name : str
        ``lag`` or ``delay``.
    value, deviation : float
        s; the deviation is HAC, that of the delay between force and motion.
    axis : Axis
        As it was declared, with the estimate.
    identification : Identification
        Of that axis, whose deviations hold for a lag or a delay that is known.
    deviations : mapping of str to float
        Of the parameters, with what the estimate's own deviation adds.
    """

    name: str
    value: float
    deviation: float
    axis: Axis
    identification: Identification
    deviations: Mapping[str, float]

    def __str__(self) -> str:
        return f"{self.name} = {1e3 * self.value:.4g} +- {1e3 * self.deviation:.2g} ms"


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

    found = searched_time(known, record, name, run)
    own = found.identification.preferred.parameters
    return DriveTiming(
        name=name,
        value=found.value,
        deviation=found.deviation,
        axis=found.axis,
        identification=found.identification,
        deviations={n: float(np.hypot(own[n].deviation, by)) for n, by in found.moved.items()},
    )
