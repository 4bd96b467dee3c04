"""Estimates over a range of cut-off frequencies, with a recommended cut-off and its reason.

A low cut-off removes noise but rounds the motion; a high one passes noise, which biases least
squares but not instrumental variables. The decimation follows the cut-off, so that force and motion
always pass the same low-pass.

An estimate by a simulated loop (instruments, output error) has no noise in its regressor. The
cut-off at which the error of this estimate is smallest is recommended. Without a loop, the
least-squares estimate is used. An unsuitable cut-off shows in the neighbouring cut-offs, as
rounding of the motion and noise change the estimate from one cut-off to the next. The error of an
estimate is therefore the root of the sum of three squares: the standard error, the known bias (by
the filter, and by noise if loops follow the record) and the difference to the neighbouring
cut-offs. As the smallest of many errors is too small by chance, the errors of three neighbouring
cut-offs are averaged; a cut-off at an end of the range has only one neighbour and is not
recommended. Without a loop, the onset of bias by noise is not known from the estimates, and
cut-offs whose parameters predict the motion worse than others are excluded.

Equation errors of different cut-offs cannot be compared, as each cut-off filters its own left side:
noise that biases the parameters does not increase the equation error. The position is the same for
all cut-offs, and no row is fitted to the position. Therefore the axis is simulated with the
parameters under the recorded control, in windows that start on the record. The known bias of filter
and noise is subtracted from the parameters.
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
from axisid.support.checks import is_real
from axisid.support.errors import DataError, EstimationError, ModelError, UsageError
from axisid.support.missing import Missing
from axisid.support.one_thread import in_one_thread
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress
from axisid.support.settings import setting
from axisid.support.wording import quoted

# relative difference of a well-known parameter to the neighbouring cut-off, above which no cut-off
# is recommended without instruments
_MAX_SWEEP_STEP = 0.1
# error of the predicted position relative to the smallest of a sweep: measured, it excludes no
# better cut-off on twins of correct models; with white position noise it excludes a cut-off with
# an eight times larger bias (`benchmarks/sweeps.py`)
_MAX_MOTION_ERROR = 2.0

_HORIZON = 0.5  # s, of a window
_LEAST = 1e-8  # smallest relative error, so that one exact parameter does not dominate the mean

_SMALLEST = (
    "because this estimate has the smallest combined error (standard error, known bias and "
    "difference to the neighbouring cut-offs)"
)


def recommend(results: Sequence[Identification]) -> tuple[float | None, str]:
    """Return the recommended cut-off in Hz, or None, and the reason.

    Parameters
    ----------
    results : sequence of Identification
        One result for each cut-off, ascending.
    """
    noise_free = [each for each in results if _is_free_of_noise(each)]
    # Results with a known bias, if there are any: an unknown bias may be large.
    with_bias = [each for each in noise_free if each.preferred.filter_bias is not None]
    used = with_bias or noise_free
    if not used:
        return _recommend_by_least_squares(results)
    chosen = int(np.argmin(_log_errors([each.preferred for each in used])))
    return used[chosen].prefilter.cutoff, (
        f"by {used[chosen].case.method.upper()}, {_SMALLEST}{_advice(chosen, len(used))}"
    )


def _recommend_by_least_squares(
    results: Sequence[Identification],
) -> tuple[float | None, str]:
    """Return the cut-off in Hz at which the error of least squares is smallest, and the reason.

    Cut-offs with too few rows, and cut-offs whose parameters predict the motion poorly, are
    excluded. The cut-off is None if there are too few results, or if the estimate differs much
    between neighbouring cut-offs everywhere.

    Parameters
    ----------
    results : sequence of Identification
        Results without strong instruments, ascending by cut-off.
    """
    why = "there are no instruments to compare with"
    if any("idm-iv" in result.estimates for result in results):
        why = "the instruments are weak"
    judged = []
    for result in results:
        estimate = result.estimates.get("idm-ls") or result.preferred
        if _has_rows(estimate):
            judged.append((result, estimate))
    if len(judged) < MIN_SWEPT_CUTOFFS.value:
        return None, (
            f"none: {why}, and {len(judged)} cut-off{'s' * (len(judged) != 1)} cannot show where "
            "noise, or rounding of the motion by the filter, begins to change the estimate. Give "
            f"{MIN_SWEPT_CUTOFFS.value:g} or more cut-offs"
        )
    motion = np.array(motion_errors(judged))
    is_excluded = motion > _MAX_MOTION_ERROR * np.min(motion[1:-1])
    estimates = [estimate for _, estimate in judged]
    chosen = int(np.argmin(np.where(is_excluded, np.inf, _log_errors(estimates))))
    result, estimate = judged[chosen]
    cutoff = result.prefilter.cutoff
    # Well-known parameters that change much to a neighbouring cut-off.
    changes = ", ".join(
        f"{name} by {100 * share:.2g} %"
        for name, share in _steps(estimates)[chosen].items()
        if estimate.parameters[name].relative_deviation_percent < MAX_RELATIVE_DEVIATION.value
        and share > _MAX_SWEEP_STEP
    )
    if changes:
        return None, (
            f"none: {why}, and the least-squares estimate depends on the cut-off everywhere. Even "
            f"at {cutoff:g} Hz, where the estimate changes least, a neighbouring cut-off changes "
            f"{changes}. Record the reference, or use a finer encoder"
        )
    predicted = ""
    if math.isfinite(motion[chosen]):
        excluded = ""
        if is_excluded.any():
            excluded = (
                f"; {is_excluded.sum()} of {len(is_excluded)} cut-offs are not considered, because "
                "their error is more than twice the smallest"
            )
        predicted = (
            " (over half a second, the parameters predict the position with an error of "
            f"{motion[chosen]:.2g} {result.axis.coordinate.unit} rms{excluded})"
        )
    return cutoff, (
        f"by {estimate.method.upper()} ({why}), {_SMALLEST}{predicted}"
        f"{_advice(chosen, len(judged))}"
    )


def _advice(chosen: int, count: int) -> str:
    """Return the advice to sweep further if the chosen cut-off is next to an end of the range.

    Otherwise the text is empty. `chosen` is the index of the cut-off among `count` cut-offs.
    """
    ends = []
    if chosen in {0, 1}:
        ends.append(("lowest", "lower"))
    if chosen in {count - 2, count - 1}:
        ends.append(("highest", "upper"))
    if not ends:
        return ""
    settings = " and ".join(setting(name, "HZ") for name, _ in ends)
    which = " and the ".join(f"{end} end" for _, end in ends)
    return (
        f". Sweep further with {settings}, because this cut-off is at or next to the {which} of "
        "the range"
    )


def _steps(estimates: Sequence[Estimate]) -> list[dict[str, float]]:
    """Return the largest relative difference of each parameter to a neighbouring estimate.

    There is one mapping by parameter for each estimate, ascending by cut-off. It has the parameters
    that all estimates have in common: a short record, with its local parameters, is not used at low
    cut-offs.
    """
    names = [n for n in estimates[0].parameters if all(n in e.parameters for e in estimates)]
    values = np.array([[each.parameters[name].corrected for name in names] for each in estimates])
    differences = np.pad(np.abs(np.diff(values, axis=0)), ((1, 1), (0, 0)))
    steps = np.maximum(differences[:-1], differences[1:]) / np.abs(values)
    return [dict(zip(names, each.tolist(), strict=True)) for each in steps]


def _has_rows(estimate: Estimate) -> bool:
    """Return True if an estimate has enough rows per parameter."""
    return len(estimate.y) >= MIN_ROWS_PER_PARAMETER.value * len(estimate.theta)


def _is_free_of_noise(result: Identification) -> bool:
    """Return True if the preferred estimate uses a noise-free loop, with enough rows.

    Instruments must be strong. An output-error estimate uses the rows of the loop themselves, so
    that it needs no strong instruments.
    """
    judged, strength = result.preferred, result.case.strength
    is_strong = isinstance(strength, Check) and strength.status == "pass"
    return judged.Z is not None and (is_strong or judged.by_output_error) and _has_rows(judged)


def _log_errors(estimates: Sequence[Estimate]) -> Array:
    """Return the log of the geometric mean of the parameters' relative errors by estimate, (n,).

    The squared error is the sum of the squares of standard error, known bias and larger difference
    to a neighbour. The log is averaged over an estimate and its two neighbours; with more than two
    estimates, it is infinite for the first and the last. A geometric mean limits the weight of
    parameters near zero.
    """
    steps = _steps(estimates)
    errors = [
        [
            math.hypot(value.deviation, value.filter_bias or 0.0) / (abs(value.value) or _LEAST)
            for value in (each.parameters[name] for name in steps[0])
        ]
        for each in estimates
    ]
    total = np.hypot(errors, [[*each.values()] for each in steps])
    logs = np.pad(np.log(np.maximum(total, _LEAST)).mean(axis=1), 1, "edge")
    averaged = (logs[:-2] + logs[1:-1] + logs[2:]) / 3
    if len(estimates) > 2:
        averaged[[0, -1]] = np.inf
    return np.where(np.isnan(averaged), np.inf, averaged)


def motion_errors(results: Sequence[tuple[Identification, Estimate]]) -> list[float]:
    """Return the root mean square error of the predicted position of each result.

    The position is predicted in windows under the recorded control, in the coordinate's unit.

    Parameters
    ----------
    results : sequence of (Identification, Estimate)
        Results for the same records.

    Returns
    -------
    list of float
        Infinite if the simulation of a window fails, NaN without a control or a position.
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
    """Results by cut-off, ascending, with a recommended cut-off.

    Attributes
    ----------
    results : tuple of Identification
        One for each cut-off with an estimate.
    failures : dict of float to str
        Cut-offs without an estimate, Hz, with the reason.
    recommended : float or None
        Recommended cut-off, Hz; None without a recommendation.
    reason : str
        Reason of the recommendation, or of a missing recommendation, as text.
    law : LawAgreement or Missing
        Comparison of the declared control law with the record, which does not depend on the
        cut-off.
    """

    results: tuple[Identification, ...]
    failures: Mapping[float, str]
    recommended: float | None
    reason: str
    law: LawAgreement | Missing

    def with_result(self, result: Identification) -> "Sweep":
        """Return the sweep with a result of the same record added, or replaced, at its cut-off.

        Estimates by methods that the sweep does not have are removed from the result.
        """
        methods = {method for swept in self.results for method in swept.estimates}
        own = replace(result, estimates={m: e for m, e in result.estimates.items() if m in methods})
        by_cutoff = dict(zip(self.cutoffs, self.results, strict=True)) | {own.prefilter.cutoff: own}
        return replace(self, results=tuple(result for _, result in sorted(by_cutoff.items())))

    @property
    def recommendation(self) -> str:
        """Recommended cut-off with its reason, or the reason of a missing recommendation."""
        if self.recommended is None:
            return self.reason
        return f"{self.recommended:g} Hz, {self.reason}"

    @property
    def checks(self) -> tuple[Check, ...]:
        """Checks of the result at the recommended cut-off.

        Without a recommendation, they are the check of the control law, and a failed check with the
        reason.
        """
        if self.recommended is None:
            law = made("control law", partial(law_check, self.law))
            return tuple(filter(None, (law, Check.unless("recommendation", self.reason))))
        return self.results[self.cutoffs.index(self.recommended)].checks

    @property
    def cutoffs(self) -> tuple[float, ...]:
        """Cut-offs of the results, Hz."""
        return tuple(result.prefilter.cutoff for result in self.results)

    def with_set_aside(self, unread: Mapping[str, str]) -> "Sweep":
        """Return the sweep with the reason for each record that could not be read, by its name."""
        return replace(self, results=tuple(each.with_set_aside(unread) for each in self.results))

    @property
    def methods(self) -> tuple[str, ...]:
        """Methods of the results, without methods that give the same estimate as another method."""
        found = [m for m in METHODS if any(m in result.estimates for result in self.results)]
        return tuple(m for m in found if m not in same_estimates(found))

    def estimates(self, method: str) -> tuple[Estimate | None, ...]:
        """Return the estimate of a method at each cut-off; None where it is missing."""
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
    """Return the identifications of an axis at many cut-off frequencies, and a recommended one.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record or sequence of Record
    cutoffs : sequence of float, optional
        Cut-off frequencies, Hz; by default 12 from 0.02 to 0.4 of the sampling frequency, in equal
        ratios.
    prefilter : Prefilter, optional
        Other settings of the filter; cut-off and decimation are not used.
    methods : sequence of str, optional
        As in `identify`.
    progress : callable, optional
        Called before each cut-off with the number of finished ones, their total, and a text.
    local, known, gain, skip_bad
        As in `identify` of several records.
    start, level, least_share
        As in `identify`.

    Raises
    ------
    UsageError
        A cut-off is not valid for the record.
    EstimationError
        No cut-off gave an estimate.
    """
    records, generated, base = records_of(record), as_generated(axis), Prefilter.given(prefilter)
    period = records[0].period
    tried = default_cutoffs(1 / period) if cutoffs is None else cutoffs
    is_list = isinstance(tried, Iterable) and not isinstance(tried, str) and len(tried) > 0
    if not is_list or not all(is_real(f) and 0 < f < math.inf for f in tried):
        raise UsageError(
            f"the cut-offs are {quoted(tried)}. Give one or more positive numbers, in Hz.",
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
                judge=False,
            )
            # Without the cached filtered signals, which would need much memory for many results.
            data = tuple(replace(each) for each in result.problem.data)
            laws = result.case.record_laws
            if results and results[0].case.record_laws.records == laws.records:
                laws = results[0].case.record_laws  # the law has no cut-off
            problem = replace(result.problem, data=data)
            results.append(replace(result, problem=problem, compared_laws=laws))
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
    """Return cut-offs in equal ratios, rounded to three digits, Hz.

    Parameters
    ----------
    rate : float
        Sampling frequency, Hz.
    lowest, highest : float, optional
        Lowest and highest cut-off, Hz; 0.02 and 0.4 of the sampling frequency by default.
    points : int
        Number of cut-offs.
    """
    first = _LOWEST * rate if lowest is None else lowest
    last = _HIGHEST * rate if highest is None else highest
    if not 0 < first <= last or not 1 <= points <= _MOST_POINTS:
        raise UsageError(
            f"{points} cut-offs from {first:g} to {last:g} Hz are not valid. Give 1 to "
            f"{_MOST_POINTS} cut-offs, from a lower to a higher frequency.",
            code="sweep",
        )
    return tuple(float(f"{f:.3g}") for f in np.geomspace(first, last, points))
