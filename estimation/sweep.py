"""Estimates over a range of cut-off frequencies: where bias begins, and what to choose.

A low cut-off hides noise and rounds the motion; a high one lets noise through, which biases least
squares and leaves instruments steady. The decimation follows the cut-off, so that force and motion
are always low-passed alike.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from axisid.codegen import GeneratedAxis, as_generated
from axisid.modeling import Axis, UsageError

from .errors import DataError, EstimationError
from .estimate import Estimate
from .identification import METHODS, identify
from .prefilter import Prefilter
from .record import Record
from .results import Identification
from .summary import text_table

_DEFAULT_POINTS = 12
_LOWEST, _HIGHEST = 0.02, 0.4  # of the sampling frequency
_SCHEMA = "axisid.sweep/1"
_COVERED = 3.0  # i.i.d. deviations within which least squares and instruments agree


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """Results by cut-off, ascending.

    Attributes
    ----------
    results : tuple of Identification
        One for each cut-off that gave any estimate.
    failures : dict of float to str
        Cut-offs that gave none, Hz, with the reason.
    recommended : float
        Cut-off, Hz.
    reason : str
        Why that one, in one sentence.
    """

    results: tuple[Identification, ...]
    failures: Mapping[float, str]
    recommended: float
    reason: str

    @property
    def cutoffs(self) -> tuple[float, ...]:
        """Of the results, Hz."""
        return tuple(result.prefilter.cutoff for result in self.results)

    def estimates(self, method: str) -> tuple[Estimate | None, ...]:
        """One method's estimates over the cut-offs; None where it gave none."""
        return tuple(result.estimates.get(method) for result in self.results)

    def summary(self) -> str:
        """Values by cut-off and method as text, and the recommendation."""
        methods = [m for m in METHODS if any(m in r.estimates for r in self.results)]
        blocks = []
        for quantity in self.results[0].axis.parameters:
            header = ["cut-off [Hz]", "1 of"]
            for method in methods:
                header += [f"{method.upper()} {quantity.name} [{quantity.unit}]", "sd"]
            blocks.append(
                text_table(header, [self._row(r, quantity.name, methods) for r in self.results])
            )
        lines = [f"{cutoff:g} Hz gave no estimate: {why}" for cutoff, why in self.failures.items()]
        lines.append(f"recommended: {self.recommended:g} Hz, {self.reason}.")
        return "\n\n".join([*blocks, "\n".join(lines)]) + "\n"

    def _row(self, result: Identification, name: str, methods: Sequence[str]) -> list[str]:
        row = [f"{result.prefilter.cutoff:g}", str(result.prefilter.decimate)]
        for method in methods:
            estimate = result.estimates.get(method)
            value = estimate and estimate.parameters[name]
            row += [f"{value.value:.5g}", f"{value.sd_hac:.2g}"] if value else ["-", "-"]
        return row

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes."""
        return {
            "schema": _SCHEMA,
            "recommended_cutoff": self.recommended,
            "reason": self.reason,
            "failures": {f"{cutoff:g}": why for cutoff, why in self.failures.items()},
            "results": [result.to_dict() for result in self.results],
        }


def sweep(
    axis: Axis | GeneratedAxis,
    record: Record,
    cutoffs: Sequence[float] | None = None,
    prefilter: Prefilter | None = None,
    methods: Sequence[str] | None = None,
) -> Sweep:
    """Identify an axis at many cut-off frequencies.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record
    cutoffs : sequence of float, optional
        Hz; by default 12 from 0.02 to 0.4 of the sampling frequency, in equal ratios.
    prefilter : Prefilter, optional
        The other settings; its cut-off and decimation are not used.
    methods : sequence of str, optional
        As in `identify`.

    Raises
    ------
    UsageError
        A cut-off makes no sense for the record.
    EstimationError
        No cut-off gave an estimate.
    """
    generated, base = as_generated(axis), prefilter or Prefilter()
    rate = 1 / record.period
    if cutoffs is None:
        cutoffs = default_cutoffs(rate)
    results, failures = [], {}
    for cutoff in sorted(set(cutoffs)):
        chosen = replace(base, cutoff=cutoff, decimate=matching_decimation(cutoff, rate))
        try:
            results.append(identify(generated, record, chosen, methods))
        except (EstimationError, DataError) as error:
            failures[cutoff] = str(error)
    if not results:
        raise EstimationError(f"no cut-off gave an estimate: {'; '.join(failures.values())}")
    recommended, reason = _recommend(results)
    return Sweep(results=tuple(results), failures=failures, recommended=recommended, reason=reason)


def default_cutoffs(
    rate: float,
    lowest: float | None = None,
    highest: float | None = None,
    points: int = _DEFAULT_POINTS,
) -> tuple[float, ...]:
    """Cut-offs in equal ratios, rounded to three digits, Hz.

    Parameters
    ----------
    rate : float
        Sampling frequency, Hz.
    lowest, highest : float, optional
        Hz; 0.02 and 0.4 of the sampling frequency by default.
    points : int
        How many.
    """
    first = _LOWEST * rate if lowest is None else lowest
    last = _HIGHEST * rate if highest is None else highest
    if not 0 < first <= last or points < 1:
        raise UsageError(
            f"{points} cut-offs from {first:g} to {last:g} Hz are no range; give 1 or more, from a "
            "lower to a higher frequency."
        )
    return tuple(float(f"{f:.3g}") for f in np.geomspace(first, last, points))


def matching_decimation(cutoff: float, rate: float) -> int:
    """Rows to keep one of, so that the decimation filter's edge is at the cut-off or below."""
    return max(2, math.ceil(0.4 * rate / cutoff - 1e-9))


def _recommend(results: Sequence[Identification]) -> tuple[float, str]:
    """The most precise cut-off at which noise does not yet bias least squares."""
    agreeing = [result for result in results if _agrees(result)]
    if not agreeing:
        lowest = results[0].prefilter.cutoff
        if all("idm-iv" not in result.estimates for result in results):
            return lowest, "the lowest, since there are no instruments to compare with"
        return lowest, "the lowest, since least squares and instruments agree nowhere"
    best = min(agreeing, key=_vagueness)
    return (
        best.prefilter.cutoff,
        "where the deviations are smallest among the cut-offs at which least squares and "
        "instruments agree",
    )


def _agrees(result: Identification) -> bool:
    ls, iv = result.estimates.get("idm-ls"), result.estimates.get("idm-iv")
    if ls is None or iv is None:
        return False
    deviations = np.sqrt(np.diag(iv.covariance))
    return bool(np.all(np.abs(ls.physical - iv.physical) <= _COVERED * deviations))


def _vagueness(result: Identification) -> float:
    """Largest relative deviation of the instrumental estimate."""
    return max(v.relative_sd_hac_percent for v in result["idm-iv"].parameters.values())
