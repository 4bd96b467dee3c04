"""Output-error estimation: parameters whose simulated output follows the record."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.choices import FIT_STARTS, LOSSES, OPEN_LOOP, RESTS, SQUARES
from axisid.estimation.identification import joint_records, records_of, with_drive_time
from axisid.estimation.noise_models import DEFAULT_TWIN_COUNT, check_twin_count
from axisid.estimation.nonlinear_least_squares import best_of
from axisid.estimation.output_residuals import (
    ClosedLoopResiduals,
    MultipleShootingResiduals,
    OutputResiduals,
    default_horizon,
)
from axisid.estimation.records import Record
from axisid.estimation.unknowns import (
    BoundOrNone,
    ExtendedForm,
    KnownValue,
    check_enough,
    known_of,
    perturbed_joint_forms,
    unknowns_of,
)
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Levels
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.checks import check_among, is_whole, refuse
from axisid.support.errors import EstimationError, UsageError
from axisid.support.one_thread import in_one_thread
from axisid.support.progress import Progress
from axisid.support.wording import quoted

from .checks_of_fit import judged
from .fit_search import FitRun, FitSearch, near_rests
from .fit_setup import (
    StartLike,
    check_remembered,
    checked_horizon,
    checked_outputs,
    checked_weights,
    form_with,
    split_free,
    starts_from,
)
from .result import OutputFit

_MOST_STARTS, _LARGEST_SEED = 1000, 2**63
# periods: change of a time of the drive up to which the output is linear in it, so that the loop
# need not be generated again
_MAX_TIME_STEP = 0.01
_ROUNDS = 8  # largest number of loops that are generated for other times of the drive
_FURTHEST = 2.0  # periods: largest change of a time of the drive in one round
# share of the standard error of the time: the record does not show smaller steps
_SHARE_OF_STANDARD_ERROR = 0.05
_TIME_STEP = 0.05  # periods: step of a time of the drive for the derivative by it


@in_one_thread
def fit(
    axis: Axis | GeneratedAxis,
    record: Record | Sequence[Record],
    output: str | Sequence[str] = "control",
    *,
    start: StartLike = FIT_STARTS[0],
    local: str | Sequence[str] = (),
    known: Mapping[str, Sequence[KnownValue]] | None = None,
    gain: str = "identified",
    bounds: Mapping[str, tuple[BoundOrNone, BoundOrNone]] | None = None,
    prior: Mapping[str, tuple[float, float]] | None = None,
    fixed: Mapping[str, float] | None = None,
    free: str | Sequence[str] = (),
    loss: str = SQUARES,
    starts: int = 1,
    bootstrap: int = DEFAULT_TWIN_COUNT,
    seed: int = 0,
    horizon: float | None = None,
    weights: Mapping[str, float] | None = None,
    rests: str = RESTS[0],
    progress: Progress | None = None,
    level: float = DEFAULT_LEVELS.level,
    least_share: float = DEFAULT_LEVELS.least_share,
) -> OutputFit:
    """Fit the simulated output of an axis to that of a record, or of several records together.

    The fit uses no filter and no derivative of measured signals, so that neither the noise of the
    encoder nor a cut-off frequency biases the parameters. In return, the declared control law must
    be that of the drive. `OutputFit.checks` report differences, and the parameters that they bias.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Axis with a control law.
    record : Record or sequence of Record
        One or several records, each with a reference and the output. A loop starts in the state of
        its record, segment by segment.
    output : {"control", "position", "force", "open-loop"}, or sequence of them
        Output to fit, or several outputs together. An error of the control law changes the
        estimates of a fit of the ``control`` little, of a fit of the ``position`` much, see
        `OutputFit.law_moves`. ``open-loop`` is the position simulated with the recorded control,
        without any law, in windows that start in the state of the record; it cannot be combined
        with other outputs.
    start : str, mapping of str to float, or Estimate
        Start of the search: ``instruments`` (least squares if instruments give no estimate) or
        ``least-squares``, each replaced by the nominal values if their residual is smaller;
        ``nominal``; values by name; or an estimate of the same records.
    local, known, gain
        As in `identify`.
    bounds : mapping of str to (float or None, float or None)
        Lower and upper bound, SI, by parameter. The declared bounds hold as well.
    prior : mapping of str to (float, float)
        Prior value of a parameter with its standard error; its weight relative to the record
        accounts for the coloured errors.
    fixed : mapping of str to float
        Values of fixed parameters. A value that the axis declares as known (`fix`) is fixed as
        well, or a prior value if it has a standard error.
    free : str or sequence of str
        Gains of the control law to estimate with the parameters, from their declared values; a
        gain keeps its sign, and cannot be a known value. An open loop has no law and no gains.
        ``gain``: the gain of the drive, as ``drive_gain``; its ``relative_sd`` gives the prior.
        ``lag`` or ``delay`` of the drive: one of them, as a record shows only their sum.
        ``start``: the initial position and velocity of each loop, which are otherwise those of the
        record; ``start_position`` or ``start_velocity``: one of them.
    loss : {"squares", "soft-l1", "huber"}
        Loss function of the errors. With a robust loss, errors that are large relative to the
        median have less weight.
    starts : int
        Number of searches. The first begins at the start, the others at random values near it, also
        of the opposite sign if the bounds allow; the search with the lowest loss counts.
    bootstrap : int
        Number of simulated replicas of the records, with the noise that was measured in them, for
        the bias and the standard errors; 0 for none. 32 are enough. For an open loop, they give the
        bias only.
    seed : int
        Seed of the further starts.
    horizon : float, optional
        Length of the windows of an open loop, s. The default is 1 s, halved until there are 20
        windows, and until errors do not grow in them, such as by friction that falls with velocity.
    weights : mapping of str to float
        Weight of the errors by output: the inverse of their standard deviation, in 1/unit of the
        output. By default it is the inverse of the residual of the output in each record.
    rests : {"leave-out", "keep"}
        Treatment of samples near a standstill or velocity reversal of a record or of its simulated
        loop. By default these samples are left out, as `identify` leaves out rows, if the other
        samples show every parameter. An open loop keeps them.
    progress : callable, optional
        Called before each step with the number of finished steps, the largest number of steps, and
        the state of the search.

        Ctrl-C ends the searches. The fit returns the best values so far, without simulated
        replicas, as `OutputFit.interrupted` and the check *convergence* report.
    level, least_share : float
        As in `identify`.

    Raises
    ------
    UsageError, DataError, ModelError
        An argument does not suit axis and records.
    EstimationError
        No loop can be simulated at the start; the message names the reason.

    References
    ----------
    [Ljung1999]_, [Gautier2013]_, [Whittle1963]_.
    """
    outputs = checked_outputs(output)
    check_among(("loss", loss, LOSSES), ("choice of rests", rests, RESTS))
    refuse(
        UsageError,
        (
            not (is_whole(starts) and 1 <= starts <= _MOST_STARTS),
            f"the number of starts is {quoted(starts)}. Give a whole number from 1 to "
            f"{_MOST_STARTS}",
        ),
        (
            not (is_whole(seed) and 0 <= seed <= _LARGEST_SEED),
            f"the seed is {quoted(seed)}. Give a whole number from 0 to {_LARGEST_SEED}",
        ),
        code="fit",
    )
    check_twin_count(bootstrap)
    generated, given = as_generated(axis), records_of(record)
    gains, time = split_free(free, generated, given, outputs)
    search = partial(
        _run_searches,
        records=tuple(given),
        outputs=outputs,
        weights=checked_weights(weights, outputs),
        horizon=checked_horizon(horizon, outputs, given),
        local=local,
        known=known or {},
        gain=gain,
        bounds=bounds or {},
        prior=prior or {},
        fixed=fixed or {},
        free=gains,
        loss=loss,
        starts=starts,
        bootstrap=bootstrap,
        seed=seed,
        keeps_rests=rests == RESTS[1] or OPEN_LOOP in outputs,
        progress=progress,
    )
    levels = Levels(level=level, least_share=least_share)
    if time is None:
        found = search(generated, start, None)
    else:
        found = _search_with_drive_time(generated, time, start, search, given[0].period)
    return OutputFit.of(found, judged, levels)


def _search_with_drive_time(
    axis: GeneratedAxis,
    time: Parameter,
    start: StartLike,
    search: Callable[[GeneratedAxis, StartLike, Parameter], FitSearch],
    period: float,
) -> FitSearch:
    """Return the search that also estimates a time of the drive, which is its lag or its delay.

    A loop is generated for one value of the time, and the output is linear in the time near that
    value only. So each round generates the loop for the last estimate of the time, and searches
    again from the end of the last search. If the time does not converge in a number of rounds, the
    search has not converged.

    Parameters
    ----------
    axis : GeneratedAxis
    time : Parameter
        The lag or delay.
    start : str, mapping of str to float, or Estimate
        Start of the first round, as in `fit`.
    search : callable
        Returns the finished searches for an axis, a start and the time, see `_run_searches`.
    period : float
        Sampling period of the records, s; not that of the law, as an open loop has no law.
    """
    value = float(getattr(axis.declared.drive, time.name))
    found: list[FitSearch] = []
    for _ in range(_ROUNDS):
        try:
            last = search(with_drive_time(axis, time.name, value), start, time)
        except KeyboardInterrupt:
            if not found:
                raise
            last = replace(found[-1], interrupted=True, bootstrap=0)
        found.append(last)
        # The next value of the time is the estimate, at most a limited number of periods away.
        step = np.clip(last.best.physical[-1] - value, -_FURTHEST * period, _FURTHEST * period)
        standard_error = _standard_error_of_last(last)
        settled = max(_MAX_TIME_STEP * period, _SHARE_OF_STANDARD_ERROR * standard_error)
        if abs(step) < settled or last.interrupted:
            break
        start, value = last.ended, max(value + float(step), 0.0)
    else:
        last = replace(last, best=replace(last.best, converged=False))
    first = found[0]
    return replace(last, start=first.start, started=first.started, remarks=first.remarks)


def _standard_error_of_last(search: FitSearch) -> float:
    """Return the standard error of the last parameter for white errors, SI.

    It is the noise, divided by the norm of the part of the parameter's column that the columns of
    the other parameters do not explain; 0 if there is no such part.
    """
    rows = search.weighing.weights[:, None] * search.best.jacobian
    errors = search.weighing.weights * search.best.errors
    counted = int(np.count_nonzero(search.weighing.weights))
    others, own = rows[:, :-1], rows[:, -1]
    fitted = np.linalg.lstsq(others, own, rcond=None)[0]
    unexplained = float(np.linalg.norm(own - others @ fitted))
    noise = float(np.linalg.norm(errors)) / max(counted, 1) ** 0.5
    return noise / unexplained if unexplained > 0 else 0.0


def _run_searches(
    generated: GeneratedAxis,
    start: StartLike,
    time: Parameter | None,
    *,
    horizon: float | None,
    records: tuple[Record, ...],
    outputs: tuple[str, ...],
    weights: tuple[float, ...],
    local: str | Sequence[str],
    known: Mapping[str, Sequence[KnownValue]],
    gain: str,
    bounds: Mapping[str, tuple[BoundOrNone, BoundOrNone]],
    prior: Mapping[str, tuple[float, float]],
    fixed: Mapping[str, float],
    free: Sequence[str],
    loss: str,
    starts: int,
    bootstrap: int,
    seed: int,
    keeps_rests: bool,
    progress: Progress | None,
) -> FitSearch:
    """Return the finished searches of a fit with the simulated loop of one axis.

    First the parameters, their start points and the predictions are set up. A *form* is the map
    from the parameters of the fit to the parameters of each record's axis. The *predictions*
    simulate the outputs with a form, and give the residuals (recorded minus simulated outputs) as a
    function of the parameters. Then the start point with the lowest cost is chosen, and the
    searches run.

    Parameters
    ----------
    generated : GeneratedAxis
        Axis; with the present value of a lag or delay that is estimated.
    start : str, mapping of str to float, or Estimate
        Start of the search, as in `fit`.
    time : Parameter or None
        Lag or delay of the drive, if it is estimated.
    horizon : float or None
        Length of the windows of an open loop, s; None if it is chosen, or for closed loops.
    weights : tuple of float
        Weights of the outputs; NaN for weights that are estimated.
    free : sequence of str
        Free gains of law and drive, and initial states.
    keeps_rests : bool
        True if samples near standstill are kept.

    Other arguments are those of `fit`.
    """
    # The parameters of all records, their bounds and prior values, and their start points.
    shared = joint_records(generated, records, None, local, known, gain, skip_bad=False)
    records, form = shared.records, form_with(free, outputs, shared, shared.own_form)
    if time is not None:
        form = replace(form, time=(time,))
    unknowns = unknowns_of(form, bounds, prior, fixed)
    start_points, unavailable = starts_from(start, shared, form, gain)
    first_at = start_points[0].physical
    predictions = _predictions(form, records, outputs, first_at, horizon)
    horizon = predictions.horizon
    # For each known value with a standard error: the form and the predictions with this value
    # changed by its standard error.
    changed_forms = [
        form_with(free, outputs, shared, joint)
        for joint in perturbed_joint_forms(generated, shared.own_form)
    ]
    predictions_with_changed_known = [
        (changed, _predictions(changed, records, outputs, first_at, horizon))
        for changed in changed_forms
    ]
    check_enough(predictions.counted, predictions.spans, unknowns)
    check_remembered(generated.axis.states, unknowns, start_points)
    # Predictions with a longer time of the drive, for the derivative by the time.
    if time is not None:
        value = float(getattr(generated.declared.drive, time.name))
        step = _TIME_STEP * records[0].period
        axes = tuple(with_drive_time(axis, time.name, value + step) for axis in form.axes)
        others = _predictions(replace(form, axes=axes), records, outputs, first_at, horizon)
    # The searches.
    rests = {} if keeps_rests else near_rests(form, records)
    run = FitRun(form, records, predictions, unknowns, loss, weights, progress, rests)
    first, start_values, failed = run.first(start_points)
    if time is not None:
        predictions.follow_time(others, start_values, value, step)
    ends = run.searches(first, start_values, starts, np.random.default_rng(seed))
    return FitSearch(
        axis=generated,
        records=records,
        form=form,
        outputs=outputs,
        loss=loss,
        unknowns=unknowns,
        predictions=predictions,
        start=start_values,
        started=first.named,
        scale=run.scale,
        weighing=run.weighing,
        remarks=(*unavailable, *failed),
        best=best_of(ends),
        searches=ends,
        bootstrap=0 if run.interrupted else bootstrap,
        seed=seed,
        known=known_of(known, len(records)),
        predictions_with_changed_known=tuple(predictions_with_changed_known),
        rests_count=any(d.rows_near_turns.any() for d in rests.values() if not d.excluded),
        alone=run.alone,
        interrupted=run.interrupted,
    )


def _predictions(
    form: ExtendedForm,
    records: Sequence[Record],
    outputs: Sequence[str],
    physical: Array,
    horizon: float | None,
) -> OutputResiduals:
    """Return the residuals of the outputs as a function of the parameters.

    A closed loop is simulated over whole segments, an open loop in windows of the length `horizon`,
    s. Without a given length, the windows have the longest length in which errors do not grow at
    the parameters `physical`, (P,). If the windows cannot be simulated with these parameters, the
    default length is kept, and the search reports the failure.
    """
    if OPEN_LOOP not in outputs:
        return ClosedLoopResiduals(form, form.axes, records, outputs)
    longest = MultipleShootingResiduals(
        form, form.axes, records, horizon or default_horizon(records)
    )
    if horizon is None:
        with suppress(EstimationError):
            return MultipleShootingResiduals(
                form, form.axes, records, longest.steady_horizon(physical)
            )
    return longest
