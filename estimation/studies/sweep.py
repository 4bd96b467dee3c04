"""Estimates over a range of cut-off frequencies: where bias begins, and what to choose.

A low cut-off hides noise and rounds the motion; a high one lets noise through, which biases least
squares and leaves instruments steady. The decimation follows the cut-off, so that force and motion
are always low-passed alike.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.checks import DEFAULT_LEVELS, Check
from axisid.estimation.choices import INSTRUMENT_STARTS, same_estimates
from axisid.estimation.diagnostics import Checked
from axisid.estimation.diagnostics.law import LawCheck, first_failing
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification, identify, records_of
from axisid.estimation.methods import METHODS
from axisid.estimation.parameters import KnownValue
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter, matching_decimation
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Exact
from axisid.support.errors import DataError, EstimationError, Missing, UsageError, is_real, quoted
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress

from .recommendation import checks_of, recommend

_DEFAULT_POINTS, _MOST_POINTS = 12, 500
_LOWEST, _HIGHEST = 0.02, 0.4  # of the sampling frequency


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep(Checked, Presentable, Exact):
    """Results by cut-off, ascending.

    Attributes
    ----------
    results : tuple of Identification
        One for each cut-off that gave any estimate.
    failures : dict of float to str
        Cut-offs that gave none, Hz, with the reason.
    recommended : float or None
        Cut-off, Hz; None where none can be named.
    reason : str
        Why that one, or none, in one sentence.
    law : LawCheck or Missing
        The declared control law against the record, whatever the cut-off.
    """

    results: tuple[Identification, ...]
    failures: Mapping[float, str]
    recommended: float | None
    reason: str
    law: LawCheck | Missing

    def with_result(self, result: Identification) -> "Sweep":
        """The sweep with a result of the same record among its own, by the sweep's methods."""
        methods = {method for swept in self.results for method in swept.estimates}
        own = replace(result, estimates={m: e for m, e in result.estimates.items() if m in methods})
        others = (r for r in self.results if r.prefilter.cutoff != own.prefilter.cutoff)
        ordered = sorted((*others, own), key=lambda r: r.prefilter.cutoff)
        return replace(self, results=tuple(ordered))

    @property
    def recommendation(self) -> str:
        """The recommended cut-off with why that one, or why there is none."""
        if self.recommended is None:
            return self.reason
        return f"{self.recommended:g} Hz, {self.reason}"

    @property
    def checks(self) -> tuple[Check, ...]:
        """Of the result at the recommended cut-off; without one, why none can be named."""
        of_it = (each for each in self.results if each.prefilter.cutoff == self.recommended)
        return checks_of(next(of_it, None), self.reason)

    @property
    def cutoffs(self) -> tuple[float, ...]:
        """Of the results, Hz."""
        return tuple(result.prefilter.cutoff for result in self.results)

    def with_set_aside(self, unread: Mapping[str, str]) -> "Sweep":
        """The same with records that could not even be read."""
        return replace(self, results=tuple(each.with_set_aside(unread) for each in self.results))

    @property
    def methods(self) -> tuple[str, ...]:
        """Of the results, without one that gives the same estimate as another of them."""
        found = [m for m in METHODS if any(m in result.estimates for result in self.results)]
        return tuple(m for m in found if m not in same_estimates(found))

    def estimates(self, method: str) -> tuple[Estimate | None, ...]:
        """One method's estimates over the cut-offs; None where it gave none."""
        return tuple(result.estimates.get(method) for result in self.results)


def sweep(
    axis: Axis | GeneratedAxis,
    record: Record | Sequence[Record],
    cutoffs: Sequence[float] | None = None,
    prefilter: Prefilter | None = None,
    methods: Sequence[str] | None = None,
    *,
    progress: Progress | None = None,
    local: str | Sequence[str] = (),
    known: Mapping[str, Sequence[KnownValue]] | None = None,
    gain: str = "identified",
    skip_bad: bool = False,
    start: str = INSTRUMENT_STARTS[0],
    level: float = DEFAULT_LEVELS.level,
    least_share: float = DEFAULT_LEVELS.least_share,
) -> Sweep:
    """Identify an axis at many cut-off frequencies.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record or sequence of Record
    cutoffs : sequence of float, optional
        Hz; by default 12 from 0.02 to 0.4 of the sampling frequency, in equal ratios.
    prefilter : Prefilter, optional
        The other settings; its cut-off and decimation are not used.
    methods : sequence of str, optional
        As in `identify`.
    progress : callable, optional
        Told before each cut-off how many are done, of how many, and which it is.
    local, known, gain, skip_bad
        As in `identify`, of several records.
    start, level, least_share
        As in `identify`.

    Raises
    ------
    UsageError
        A cut-off makes no sense for the record.
    EstimationError
        No cut-off gave an estimate.
    """
    records = records_of(record)
    base = Prefilter.given(prefilter)
    generated = as_generated(axis)
    period = records[0].period
    tried = default_cutoffs(1 / period) if cutoffs is None else _checked(cutoffs)
    results: list[Identification] = []
    failures: dict[float, str] = {}
    for cutoff in with_progress(sorted(set(tried)), progress, lambda f: f"cut-off {f:g} Hz"):
        chosen = replace(base, cutoff=cutoff, decimate=matching_decimation(cutoff, period))
        try:
            result = identify(
                generated,
                records,
                chosen,
                methods,
                local=local,
                known=known,
                gain=gain,
                skip_bad=skip_bad,
                start=start,
                level=level,
                least_share=least_share,
            )
            # Without the signals, of which many cut-offs of a long record would keep many.
            results.append(result.without_signals())
        except (EstimationError, DataError) as error:
            failures[cutoff] = str(error)
    if not results:
        why = "; ".join(dict.fromkeys(failures.values()))
        raise EstimationError(f"no cut-off gave an estimate: {why}", code="sweep")
    recommended, reason = recommend(results)
    return Sweep(
        results=tuple(results),
        failures=failures,
        recommended=recommended,
        reason=reason,
        law=first_failing(results[0].case.laws),
    )


def _checked(cutoffs: Sequence[float]) -> Sequence[float]:
    """Cut-offs that a user gave."""
    several = isinstance(cutoffs, Iterable) and not isinstance(cutoffs, str)
    if not several or not all(is_real(f) and 0 < f < math.inf for f in cutoffs):
        raise UsageError(f"the cut-offs are {quoted(cutoffs)}; give positive numbers, in Hz.")
    if not len(cutoffs):
        raise UsageError("no cut-off is given; give one or more, in Hz.", code="sweep")
    return cutoffs


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
    if not 0 < first <= last or not 1 <= points <= _MOST_POINTS:
        raise UsageError(
            f"{points} cut-offs from {first:g} to {last:g} Hz are no range; give 1 to "
            f"{_MOST_POINTS}, from a lower to a higher frequency.",
            code="sweep",
        )
    return tuple(float(f"{f:.3g}") for f in np.geomspace(first, last, points))
