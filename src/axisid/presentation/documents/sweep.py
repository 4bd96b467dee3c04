"""Estimates over the cut-off as a document."""

from axisid.estimation.studies import Sweep
from axisid.presentation.schema import WrittenSweep
from axisid.support.remedy import as_options

from .identification import written_identification


def written_sweep(sweep: Sweep) -> WrittenSweep:
    """Every identification of a sweep, and which is recommended."""
    return WrittenSweep(
        belief=sweep.belief,
        recommended_cutoff=sweep.recommended,
        reason=sweep.reason,
        failures={f"{cutoff:g}": why.worded(as_options) for cutoff, why in sweep.failures.items()},
        results=tuple(map(written_identification, sweep.results)),
    )
