"""Estimates over a range of cut-off frequencies: where bias begins, and which to take, and why.

A low cut-off hides noise and rounds the motion; a high one lets noise through, which biases least
squares and leaves instruments steady. The decimation follows the cut-off, so that force and motion
are always low-passed alike.

An estimate by a simulated loop, by instruments or by output error, has no noise in its regressor:
the judged one is taken where it is surest; without a loop, least squares. What a cut-off does shows
in its neighbours: what rounding or noise moves at one, it moves otherwise at the next. An
estimate's error is taken to be its deviation, the bias that is known of it (of the filter, and of
noise where loops follow the record) and the step to its neighbours together. Of many such the least
is too small by chance, so that each counts with those of its neighbours; a cut-off at an end has
but one, and is not recommended. Without a loop nothing tells where noise begins to bias, and
cut-offs whose parameters predict the motion worse than elsewhere are left out.

An equation's error says nothing between cut-offs, each of which filters what it is held against:
noise that biases the parameters makes the rows no harder to explain. The position is the same for
all, and no row is fitted to it. So the parameters move the axis under the recorded control, in
windows that each start where the record is. What is known of the bias of filter and noise is taken
off them.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.choices import INSTRUMENT_STARTS, same_estimates
from axisid.estimation.diagnostics.control_law import LawAgreement, first_failing, law_check
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification, identify, records_of
from axisid.estimation.methods import METHODS
from axisid.estimation.output_residuals import MultipleShootingResiduals
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter, matching_decimation
from axisid.estimation.thresholds import (
    MAX_RELATIVE_DEVIATION,
    MIN_ROWS_PER_PARAMETER,
    MIN_SWEPT_CUTOFFS,
)
from axisid.estimation.unknowns import KnownValue
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Checked, made
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import (
    DataError,
    EstimationError,
    Missing,
    ModelError,
    UsageError,
    is_real,
    quoted,
)
from axisid.support.one_thread import in_one_thread
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress

# of a known parameter's value, to the neighbouring cut-off; beyond, none is recommended without
# instruments
_MAX_SWEEP_STEP = 0.1
# of a sweep's least error of the predicted position: measured, right twins lose no better cut-off
# by it; beside white noise of the position one is left out that is biased eight times as much
# (`benchmarks/sweeps.py`)
_MAX_MOTION_ERROR = 2.0

_HORIZON = 0.5  # s, of a window
_LEAST = 1e-8  # relative error: one parameter that is about exact must not decide for all

_WHERE = "where deviations, known bias and the steps to neighbouring cut-offs are smallest together"


def recommend(results: Sequence[Identification]) -> tuple[float | None, str]:
    """A cut-off, Hz, and why that one; None where none can be named.

    Parameters
    ----------
    results : sequence of Identification
        By cut-off, ascending.
    """
    free = [each for each in results if _is_free_of_noise(each)]
    # A bias that is not known may be large.
    free = [each for each in free if each.preferred.filter_bias is not None] or free
    if not free:
        return _steadiest(results)
    chosen = int(np.argmin(_vagueness([each.preferred for each in free])))
    return free[chosen].prefilter.cutoff, (
        f"{_WHERE}, of the method that is judged ({free[chosen].case.method})"
        f"{_further(chosen, len(free))}"
    )


def _steadiest(results: Sequence[Identification]) -> tuple[float | None, str]:
    """Without instruments: the cut-off beside which least squares hardly moves."""
    why = (
        "the instruments are weak"
        if any("idm-iv" in result.estimates for result in results)
        else "there are no instruments to compare with"
    )
    judged = [
        (result, estimate)
        for result in results
        for estimate in [result.estimates.get("idm-ls") or result.preferred]
        if _has_rows(estimate)
    ]
    if len(judged) < MIN_SWEPT_CUTOFFS.value:
        return None, (
            f"none: {why}, and {len(judged)} cut-off{'s' * (len(judged) != 1)} cannot show where "
            f"noise or rounding begins; give {MIN_SWEPT_CUTOFFS.value:g} or more"
        )
    motion = np.array(motion_errors(judged))
    strays = motion > _MAX_MOTION_ERROR * np.min(motion[1:-1])
    estimates = [estimate for _, estimate in judged]
    chosen = int(np.argmin(np.where(strays, np.inf, _vagueness(estimates))))
    result, estimate = judged[chosen]
    cutoff = result.prefilter.cutoff
    moving = ", ".join(
        f"{name} by {100 * share:.2g} %"
        for name, share in _steps(estimates)[chosen].items()
        if estimate.parameters[name].relative_deviation_percent < MAX_RELATIVE_DEVIATION.value
        and share > _MAX_SWEEP_STEP
    )
    if moving:
        return None, (
            f"none: {why}, and least squares stands still nowhere; even at {cutoff:g} Hz, where it "
            f"moves least, a neighbouring cut-off moves {moving}. Record the reference, or take a "
            "finer encoder"
        )
    predicted = ""
    if math.isfinite(motion[chosen]):
        left = f"{strays.sum()} of {len(strays)} cut-offs are left out, where it is twice the least"
        predicted = (
            f" (half a second ahead they predict the position to {motion[chosen]:.2g} "
            f"{result.axis.coordinate.unit}{f'; {left}' * bool(strays.any())})"
        )
    return cutoff, f"{_WHERE}{predicted}, since {why}{_further(chosen, len(judged))}"


def _further(chosen: int, count: int) -> str:
    """What to do where the cut-off beside the chosen one is the last: it may be as good."""
    return "; sweep further, as the range ends beside it" * (chosen in {0, 1, count - 2, count - 1})


def _steps(estimates: Sequence[Estimate]) -> list[dict[str, float]]:
    """Of each estimate, how far the farther one of its neighbours is from it, by its size.

    Of the parameters that all have: a short record is set aside at low cut-offs.
    """
    names = [n for n in estimates[0].parameters if all(n in e.parameters for e in estimates)]
    values = np.array([[each.parameters[name].corrected for name in names] for each in estimates])
    apart = np.pad(np.abs(np.diff(values, axis=0)), ((1, 1), (0, 0)))
    steps = np.maximum(apart[:-1], apart[1:]) / np.abs(values)
    return [dict(zip(names, each.tolist(), strict=True)) for each in steps]


def _has_rows(estimate: Estimate) -> bool:
    """Whether its rows are enough to judge it by."""
    return len(estimate.y) >= MIN_ROWS_PER_PARAMETER.value * len(estimate.theta)


def _is_free_of_noise(result: Identification) -> bool:
    """Whether a loop that has no noise tells the judged estimate, and enough of it, in rows enough.

    Weak instruments matter to no estimate by output error, which rests on the loop's own rows.
    """
    judged, strength = result.preferred, result.case.strength
    strong = isinstance(strength, Check) and strength.status == "pass"
    return judged.Z is not None and (strong or judged.by_output_error) and _has_rows(judged)


def _vagueness(estimates: Sequence[Estimate]) -> Array:
    """Of each estimate, log of the geometric mean of its parameters' relative errors, (n,).

    Of deviation, known bias and step to the farther neighbour, in the mean over an estimate and its
    neighbours; infinite at the ends, which have but one, of more than two. A geometric mean, since
    a parameter about zero must not decide for all.
    """
    steps = _steps(estimates)
    errors = [
        [
            math.hypot(value.deviation, value.filter_bias or 0.0) / (abs(value.value) or _LEAST)
            for value in (each.parameters[name] for name in steps[0])
        ]
        for each in estimates
    ]
    both = np.hypot(errors, [[*each.values()] for each in steps])
    own = np.pad(np.log(np.maximum(both, _LEAST)).mean(axis=1), 1, "edge")
    around = (own[:-2] + own[1:-1] + own[2:]) / 3
    if len(estimates) > 2:
        around[[0, -1]] = np.inf
    return np.where(np.isnan(around), np.inf, around)


def motion_errors(results: Sequence[tuple[Identification, Estimate]]) -> list[float]:
    """Errors of the position that estimates predict, in the coordinate's unit, root mean square.

    Parameters
    ----------
    results : sequence of (Identification, Estimate)
        Of the same records.

    Returns
    -------
    list of float
        Infinite where an axis does not get through a window, NaN where it cannot be told: there is
        no control or no position.
    """
    (first, estimate), *_ = results
    data, errors = first.problem.data, list[float]()
    try:
        predictions = MultipleShootingResiduals(
            estimate.form, [d.axis for d in data], [d.record for d in data], _HORIZON
        )
    except (DataError, EstimationError, ModelError):
        return [math.nan] * len(results)
    for _, each in results:
        try:
            predictions.settle(each.corrected)
            squares = predictions(each.corrected[None]).errors[predictions.counted > 0] ** 2
            errors.append(float(np.sqrt(np.mean(squares))))
        except (EstimationError, ModelError):
            errors.append(math.inf)
    return [math.inf if math.isnan(each) else each for each in errors]


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
    law : LawAgreement or Missing
        The declared control law against the record, whatever the cut-off.
    """

    results: tuple[Identification, ...]
    failures: Mapping[float, str]
    recommended: float | None
    reason: str
    law: LawAgreement | Missing

    def with_result(self, result: Identification) -> "Sweep":
        """The sweep with a result of the same record among its own, by the sweep's methods."""
        methods = {method for swept in self.results for method in swept.estimates}
        own = replace(result, estimates={m: e for m, e in result.estimates.items() if m in methods})
        by_cutoff = dict(zip(self.cutoffs, self.results, strict=True)) | {own.prefilter.cutoff: own}
        return replace(self, results=tuple(result for _, result in sorted(by_cutoff.items())))

    @property
    def recommendation(self) -> str:
        """The recommended cut-off with why that one, or why there is none."""
        at = "" if self.recommended is None else f"{self.recommended:g} Hz, "
        return f"{at}{self.reason}"

    @property
    def checks(self) -> tuple[Check, ...]:
        """Of the result at the recommended cut-off; else of the law, and why there is none."""
        if self.recommended is None:
            law = made("control law", partial(law_check, self.law))
            return tuple(filter(None, (law, Check.unless("recommendation", self.reason))))
        return self.results[self.cutoffs.index(self.recommended)].checks

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


@in_one_thread
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
    records, generated, base = records_of(record), as_generated(axis), Prefilter.given(prefilter)
    period = records[0].period
    tried = default_cutoffs(1 / period) if cutoffs is None else cutoffs
    several = isinstance(tried, Iterable) and not isinstance(tried, str) and len(tried)
    if not several or not all(is_real(f) and 0 < f < math.inf for f in tried):
        raise UsageError(
            f"the cut-offs are {quoted(tried)}; give positive numbers, one or more, in Hz.",
            code="sweep",
        )
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
            # Without the filtered signals, of which many results would keep many.
            data = tuple(replace(each) for each in result.problem.data)
            results.append(replace(result, problem=replace(result.problem, data=data)))
        except (EstimationError, DataError) as error:
            failures[cutoff] = str(error)
    if not results:
        raise EstimationError(
            f"no cut-off gave an estimate: {'; '.join(dict.fromkeys(failures.values()))}",
            code="sweep",
        )
    recommended, reason = recommend(results)
    return Sweep(
        results=tuple(results),
        failures=failures,
        recommended=recommended,
        reason=reason,
        law=first_failing(results[0].case.laws),
    )


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
