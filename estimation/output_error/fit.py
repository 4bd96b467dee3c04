"""Output error: free parameters are searched so that a simulated output follows the record."""

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
from axisid.support.errors import EstimationError, UsageError, check_among, is_whole, quoted, refuse
from axisid.support.one_thread import in_one_thread
from axisid.support.progress import Progress

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
# periods from the loop's own drive time, where the output is a straight line of it and the loop
# need not be generated anew
_MAX_TIME_STEP = 0.01
_ROUNDS = 8
_FURTHEST = 2.0  # periods, by which a time of the drive moves in a round
# of the time's standard deviation: a smaller step is below what the record shows
_SHARE_OF_DEVIATION = 0.05
_TIME_STEP = 0.05  # periods, by which a time of the drive is longer for the slope by it


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
    """Fit the simulated loop's output to that of a record, or of several of them together.

    No filter and no derivative of what was measured is involved, so that neither the encoder's
    noise nor a cut-off biases the parameters; the price is that the control law must be the
    drive's. `OutputFit.checks` say whether it is, and what it moves.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a control law.
    record : Record or sequence of Record
        Each with a reference and the output. A loop starts as its record does, segment by segment.
    output : {"control", "position", "force", "open-loop"}, or sequence of them
        What is followed, several outputs together: ``control`` is little moved by a law that is a
        little wrong, ``position`` much, see `OutputFit.law_moves`; ``open-loop`` is the position
        under the recorded control, without any law, in windows that each start where the record is,
        and stands alone.
    start : str, mapping of str to float, or Estimate
        ``instruments`` (or least squares, where these come to nothing), ``least-squares``, either
        or nominal values, whichever leaves less; ``nominal``, values by name, or an estimate of
        the same records.
    local, known, gain
        As in `identify`.
    bounds : mapping of str to (float or None, float or None)
        Lower and upper, SI, by parameter, within the declared ones, which hold anyway.
    prior : mapping of str to (float, float)
        What was known before of a parameter, with its standard deviation, by which it is weighed
        against the coloured errors.
    fixed : mapping of str to float
        Parameters that are held. What the axis declares as known (`fix`) is held too, or weighed
        where it has a deviation.
    free : str or sequence of str
        Gains of the control law that are searched with the parameters, from the declared ones;
        none changes its sign, or is known. Not of an open loop, which has no law. ``gain``: the
        drive's, which is ``drive_gain`` then; what its ``relative_sd`` says was known before.
        Its ``lag`` or its ``delay``: one of them, as a record shows their sum. ``start``: the first
        position and velocity of each loop, which are else those of the record; ``start_position``
        or ``start_velocity``: one of them.
    loss : {"squares", "soft-l1", "huber"}
        Robust ones let errors count for less that are large beside the median of all.
    starts : int
        Searches, the first from the start, others from about it, also of the other sign where the
        bounds allow; the lowest end is taken.
    bootstrap : int
        How many twins of the records tell bias and deviations: their loops once more, with the
        noise that was measured in them; 0 for none. 32 are enough. Of an open loop bias alone.
    seed : int
        Of further starts.
    horizon : float, optional
        Length of the windows of an open loop, s; 1 s by default, or a half, a quarter and so on of
        it, so that there are 20, and where friction that falls with the velocity, or another force,
        lets errors grow.
    weights : mapping of str to float
        Of an output, by which its errors count: the inverse of their deviation, in its unit. Each
        other output is weighted by what is left of it in each record.
    rests : {"leave-out", "keep"}
        Whether samples count that are near a rest or a reversal of a record or of its simulated
        loop: left out as `identify` leaves out rows, where the others show every parameter. In an
        open loop they count.
    progress : callable, optional
        Told before each step how many are done, of how many at most, and how far it is.

        Ctrl-C ends the searches. The fit returns the best values so far, without twins;
        `OutputFit.interrupted` and the check *convergence* say so.
    level, least_share : float
        As in `identify`.

    Raises
    ------
    UsageError, DataError, ModelError
        An argument does not suit axis and records.
    EstimationError
        No loop can be simulated from where the fit starts; the reason is named.

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
            f"the starts are {quoted(starts)}. Give a whole number from 1 to {_MOST_STARTS}",
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
        _searched,
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
    found = (
        search(generated, start, None)
        if time is None
        else _with_time_found(generated, time, start, search, given[0].period)
    )
    return OutputFit.of(found, judged, levels)


def _with_time_found(
    axis: GeneratedAxis,
    time: Parameter,
    start: StartLike,
    search: Callable[[GeneratedAxis, StartLike, Parameter], FitSearch],
    period: float,
) -> FitSearch:
    """Return the search whose loop has the time that it finds, from the first start.

    The period is that of the records, s: an open loop has no law with one. A time that does not
    settle is reported as a search that has not converged.
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
        step = np.clip(last.best.physical[-1] - value, -_FURTHEST * period, _FURTHEST * period)
        settled = max(_MAX_TIME_STEP * period, _SHARE_OF_DEVIATION * _deviation_of_last(last))
        if abs(step) < settled or last.interrupted:
            break
        start, value = last.ended, max(value + float(step), 0.0)
    else:
        last = replace(last, best=replace(last.best, converged=False))
    first = found[0]
    return replace(last, start=first.start, started=first.started, remarks=first.remarks)


def _deviation_of_last(search: FitSearch) -> float:
    """Return the standard error of the last parameter, as if errors were white."""
    rows = search.weighing.weights[:, None] * search.best.jacobian
    errors = search.weighing.weights * search.best.errors
    counted = int(np.count_nonzero(search.weighing.weights))
    others, own = rows[:, :-1], rows[:, -1]
    fitted = np.linalg.lstsq(others, own, rcond=None)[0]
    left = float(np.linalg.norm(own - others @ fitted))
    noise = float(np.linalg.norm(errors)) / max(counted, 1) ** 0.5
    return noise / left if left > 0 else 0.0


def _searched(
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
    """Search from a start with the loop of an axis; other arguments are those of `fit`.

    Weights are NaN where they are found.
    """
    shared = joint_records(generated, records, None, local, known, gain, skip_bad=False)
    records, form = shared.records, form_with(free, outputs, shared, shared.own_form)
    form = form if time is None else replace(form, time=(time,))
    unknowns = unknowns_of(form, bounds, prior, fixed)
    begins, why = starts_from(start, shared, form, gain)
    first_at = begins[0].physical
    predictions = _predictions(form, records, outputs, first_at, horizon)
    horizon = predictions.horizon
    perturbed = [
        form_with(free, outputs, shared, joint)
        for joint in perturbed_joint_forms(generated, shared.own_form)
    ]
    doubts = [(f, _predictions(f, records, outputs, first_at, horizon)) for f in perturbed]
    check_enough(predictions.counted, predictions.spans, unknowns)
    check_remembered(generated.axis.states, unknowns, begins)
    if time is not None:
        value = float(getattr(generated.declared.drive, time.name))
        step = _TIME_STEP * records[0].period
        axes = tuple(with_drive_time(axis, time.name, value + step) for axis in form.axes)
        others = _predictions(replace(form, axes=axes), records, outputs, first_at, horizon)
    rests = {} if keeps_rests else near_rests(form, records)
    run = FitRun(form, records, predictions, unknowns, loss, weights, progress, rests)
    first, begun, lost = run.first(begins)
    if time is not None:
        predictions.follow_time(others, begun, value, step)
    ends = run.searches(first, begun, starts, np.random.default_rng(seed))
    return FitSearch(
        axis=generated,
        records=records,
        form=form,
        outputs=outputs,
        loss=loss,
        unknowns=unknowns,
        predictions=predictions,
        start=begun,
        started=first.named,
        scale=run.scale,
        weighing=run.weighing,
        remarks=(*why, *lost),
        best=best_of(ends),
        searches=ends,
        bootstrap=0 if run.interrupted else bootstrap,
        seed=seed,
        known=known_of(known, len(records)),
        doubts=tuple(doubts),
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
    """Return the predicted outputs; errors do not grow in windows of an open loop.

    At parameters (P,), where a length, s, is not asked for. Where they cannot be simulated, the
    search tells it.
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
