"""Output error: a simulated output follows the recorded one, by whatever parameters are free."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.bootstrap import DEFAULT_COUNT, check_count
from axisid.estimation.choices import FIT_STARTS, LOSSES, OPEN_LOOP, RESTS, SQUARES
from axisid.estimation.diagnostic_checks import DEFAULT_LEVELS, Levels
from axisid.estimation.diagnostics.control_law import LawAgreement, first_failing, law_agreement
from axisid.estimation.identification import at_time, bound_records, records_of, shared_records
from axisid.estimation.methods import scale_of
from axisid.estimation.nonlinear_least_squares import (
    LOSSES as LOSS_FUNCTIONS,
    Search,
    SearchResult,
    WeightedLoss,
    best_of,
    cost_of,
)
from axisid.estimation.parameters import (
    End,
    ExtendedForm,
    KnownValue,
    Unknowns,
    check_enough,
    known_of,
    least_sizes,
    perturbed_layouts,
    unknowns_of,
)
from axisid.estimation.prediction_errors import (
    LoopPredictions,
    PredictionErrors,
    WindowPredictions,
    default_horizon,
    jacobian_at,
    record_rows,
)
from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.thresholds import HUBER_TUNING
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array, mask_of
from axisid.support.errors import (
    AxisidError,
    EstimationError,
    UsageError,
    check_among,
    is_whole,
    quoted,
    refuse,
)
from axisid.support.progress import Progress

from .checks_of_fit import judged
from .covariance import sandwich_of, unseen_directions
from .fit_setup import (
    FitStart,
    StartLike,
    check_remembered,
    checked_horizon,
    checked_outputs,
    checked_weights,
    form_with,
    split_free,
    starts_from,
)
from .inference import FitSearch
from .result import OutputFit

_MOST_STARTS, _LARGEST_SEED = 1000, 2**63
# periods from the loop's own drive time, where the output is a straight line of it and the loop
# need not be generated anew
_MAX_TIME_STEP = 0.01
_ROUNDS = 8
_FURTHEST = 2.0  # periods, by which a time of the drive moves in a round
_TIME_STEP = 0.05  # periods, by which a time of the drive is longer for the slope by it
_PASSES, _SETTLED = 4, 0.02  # of weights: how often they are found anew, and their last change


def fit(
    axis: Axis | GeneratedAxis,
    record: Record | Sequence[Record],
    output: str | Sequence[str] = "control",
    *,
    start: StartLike = FIT_STARTS[0],
    local: str | Sequence[str] = (),
    known: Mapping[str, Sequence[KnownValue]] | None = None,
    gain: str = "identified",
    bounds: Mapping[str, tuple[End, End]] | None = None,
    prior: Mapping[str, tuple[float, float]] | None = None,
    fixed: Mapping[str, float] | None = None,
    free: str | Sequence[str] = (),
    loss: str = SQUARES,
    starts: int = 1,
    bootstrap: int = DEFAULT_COUNT,
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
            f"the starts are {quoted(starts)}; give a whole number from 1 to {_MOST_STARTS}",
        ),
        (
            not (is_whole(seed) and 0 <= seed <= _LARGEST_SEED),
            f"the seed is {quoted(seed)}; give a whole number from 0 to {_LARGEST_SEED}",
        ),
        code="fit",
    )
    check_count(bootstrap)
    generated, given = as_generated(axis), records_of(record)
    gains, time = split_free(free, generated, given, outputs)
    search = partial(
        _searched,
        records=tuple(given),
        outputs=outputs,
        weights=checked_weights(weights, outputs),
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
    levels, asked = (
        Levels(level=level, least_share=least_share),
        checked_horizon(horizon, outputs, given),
    )
    if time is None:
        first = last = search(generated, start, None, horizon=asked)
    else:
        of_time = partial(search, horizon=asked)
        first, last = _with_time_found(generated, time, start, of_time, given[0].period)
    best = replace(last, start=first.start, started=first.started, remarks=first.remarks)
    return OutputFit.of(best, judged, levels)


def _with_time_found(
    axis: GeneratedAxis,
    time: Parameter,
    start: StartLike,
    search: Callable[[GeneratedAxis, StartLike, Parameter], FitSearch],
    period: float,
) -> tuple[FitSearch, FitSearch]:
    """The first search, and the one that ends where its loop has the time that it finds.

    The period is that of the records, s: an open loop has no law with one.

    Raises
    ------
    EstimationError
        The time does not settle.
    """
    value = float(getattr(axis.declared.drive, time.name))
    first: FitSearch | None = None
    for _ in range(_ROUNDS):
        last = search(at_time(axis, time.name, value), start, time)
        first = first or last
        step = np.clip(last.best.physical[-1] - value, -_FURTHEST * period, _FURTHEST * period)
        if abs(step) < _MAX_TIME_STEP * period:
            return first, last
        start, value = last.ended, max(value + float(step), 0.0)
    raise EstimationError(
        f"the drive's {time.name} does not settle; it is about {value:.3g} s. See whether the law "
        "and the model are right.",
        code="no-convergence",
    )


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
    bounds: Mapping[str, tuple[End, End]],
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
    """Search from a start with the loop of an axis, and about its time; others as `fit` has them.

    Weights are NaN where they are found.
    """
    shared = shared_records(generated, records, None, local, known, gain, skip_bad=False)
    records, form = shared.records, form_with(free, outputs, shared, shared.own_layout)
    form = form if time is None else replace(form, time=(time,))
    unknowns = unknowns_of(form, bounds, prior, fixed)
    begins, why = starts_from(start, shared, form, gain)
    first_at = begins[0].physical
    predictions = _predictions(form, records, outputs, first_at, horizon)
    horizon = predictions.horizon
    perturbed = [
        form_with(free, outputs, shared, layout)
        for layout in perturbed_layouts(generated, shared.own_layout)
    ]
    doubts = [(f, _predictions(f, records, outputs, first_at, horizon)) for f in perturbed]
    check_enough(predictions.counted, predictions.spans, unknowns)
    check_remembered(generated.axis.states, unknowns, begins)
    if time is not None:
        value = float(getattr(generated.declared.drive, time.name))
        step = _TIME_STEP * records[0].period
        axes = tuple(at_time(axis, time.name, value + step) for axis in form.axes)
        others = _predictions(replace(form, axes=axes), records, outputs, first_at, horizon)
        at = unknowns.inside(first_at, unknowns.scale(first_at, begins[0].size))
        predictions.follow_time(others, at, value, step)
    rests = {} if keeps_rests else _rests(form, records)
    run = _FitRun(form, records, predictions, unknowns, loss, weights, progress, rests)
    first, begun, lost = run.first(begins)
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
        bootstrap=bootstrap,
        seed=seed,
        known=known_of(known, len(records)),
        doubts=tuple(doubts),
        rests_count=any(d.rows_near_turns.any() for d in rests.values() if not d.excluded),
        alone=run.alone,
    )


def _predictions(
    form: ExtendedForm,
    records: Sequence[Record],
    outputs: Sequence[str],
    physical: Array,
    horizon: float | None,
) -> PredictionErrors:
    """What is predicted; windows of an open loop are such that errors do not grow in them.

    At parameters (P,), where a length, s, is not asked for. Where they cannot be simulated, the
    search tells it.
    """
    if OPEN_LOOP not in outputs:
        return LoopPredictions(form, form.axes, records, outputs)
    longest = WindowPredictions(form, form.axes, records, horizon or default_horizon(records))
    if horizon is None:
        with suppress(EstimationError):
            steady = longest.steady_horizon(physical)
            return WindowPredictions(form, form.axes, records, steady)
    return longest


def _rests(form: ExtendedForm, records: Sequence[Record]) -> dict[int, FilteredRecord]:
    """Records of which a fit leaves out what is near a rest or a reversal, by number.

    Of these, or of their simulated loops, as regressions leave out rows, under the default filter,
    which says how near. At rest friction takes any force, so that such samples tell nothing of the
    parameters; under a law with an integral the control is undetermined there. Behind an encoder
    they mislead: it is silent at rest, and record and loop come to rest and leave it at different
    times.

    Nothing is left out of any where they together show too little without it. Friction that
    remembers is shown near reversals alone, and records that are too short for the filter are kept
    whole.
    """
    served = list[int]()
    for i, (axis, record) in enumerate(zip(form.axes, records, strict=True)):
        if not axis.states:
            with suppress(AxisidError):
                FilteredRecord.bind(axis, record, Prefilter(reversals="keep"))
                served.append(i)
    if not served:
        return {}
    data = bound_records(
        [form.axes[i] for i in served],
        [records[i] for i in served],
        Prefilter(),
        [form.of_model.record_jacobian(i) for i in served],
    )
    return dict(zip(served, data, strict=True))


@dataclass
class _FitRun:
    """The searches of one fit."""

    form: ExtendedForm
    records: Sequence[Record]
    predictions: PredictionErrors
    unknowns: Unknowns
    loss: str
    given: tuple[float, ...]  # weights of the outputs, NaN where they are found
    progress: Progress | None
    rests: Mapping[int, FilteredRecord]
    scale: Array = field(init=False)
    counted: Array = field(init=False)
    weighing: WeightedLoss = field(init=False)
    alone: SearchResult | None = None

    def first(self, begins: Sequence[FitStart]) -> tuple[FitStart, Array, list[str]]:
        """The start that leaves least, where it is, and why those before it cannot be simulated."""
        why: list[str] = []
        tried = list[tuple[FitStart, Array, Array, Array, list[str]]]()
        for begin in begins:
            scale = self.unknowns.scale(begin.physical, begin.size)
            at = self.unknowns.inside(begin.physical, scale)
            lanes = self.predictions(at[None, :])
            if lanes.failures:
                why.append(f"from {begin.named} values {lanes.failures[0]}")
            else:
                tried.append((begin, at, lanes.errors[:, 0], scale, [*why]))
        if not tried:
            raise EstimationError(
                f"the fit cannot start: {why[0]}{self._suspects(begins[0])}", code="fit"
            )
        self.counted = self._counted()
        self._weigh(tried[0][2])
        first, at, errors, self.scale, before = min(
            tried, key=lambda each: cost_of(each[1], each[2], self.unknowns, self.weighing)
        )
        self._weigh(errors)
        return first, at, before

    def _counted(self, physical: Array | None = None) -> Array:
        """1 for rows that count, 0 near rests of the records, and of their loops there, (n,).

        Parameters
        ----------
        physical : (P,) array, optional
            Of the loops; without it rests are those of the records. A loop that never moves is none
            of a record that does.
        """
        counted = self.predictions.counted.copy()
        if not any(data.excluded for data in self.rests.values()):
            return counted
        with np.errstate(all="ignore"):
            loops = () if physical is None else self.predictions.velocities(physical)
        for r, data in self.rests.items():
            samples = self.predictions.samples[r]
            near = mask_of(data.excluded, len(data))[samples]
            if data.excluded and loops:
                velocity = np.zeros(len(data))
                velocity[samples] = loops[r]
                turns = data.excluded + data.sampling.turns(velocity, data.fastest)
                either = mask_of(turns, len(data))[samples]
                near = near if either.all() else either
            rows = record_rows(self.predictions.spans[r])
            counted[rows][np.repeat(near, len(self.predictions.units))] = 0.0
        return counted

    def _suspects(self, begin: FitStart) -> str:
        """What may be wrong where no loop can start: what of it is below its bounds, or the law."""
        quantities, low = self.unknowns.quantities, begin.physical < self.unknowns.lower
        below = ", ".join(
            f"{q.name} = {value:.6g} {q.unit}"
            for q, value, is_low in zip(quantities, begin.physical, low, strict=True)
            if is_low
        )
        said = below and (
            f" The {begin.named} estimate itself is {below}, below the bounds: "
            "check the signs of the control, of the positions and of the drive gain."
        )
        law = first_failing([*map(law_agreement, self.form.axes, self.records)])
        if isinstance(law, LawAgreement) and not law.passed:
            said += f" The control law: {law.sentence}."
        return said

    def searches(
        self, first: FitStart, begun: Array, count: int, random: np.random.Generator
    ) -> tuple[SearchResult, ...]:
        """The searches that come to an end: from the start, then from about it."""
        ends, lost, u = list[SearchResult](), list[EstimationError](), self.unknowns
        sizes = self._sizes(begun) if count > 1 else self.scale
        for k in range(count):
            try:
                if k:
                    drawn = u.drawn_about(first.physical, sizes, random)
                    drawn = np.where(least_sizes(self.form) > 0, first.physical, drawn)
                    begun = u.inside(drawn, self.scale)
                ends.append(self._run(begun, u) if ends else self._search(begun))
            except EstimationError as error:
                lost.append(error)
        if not ends:
            raise lost[0]
        # By the last weights, which are the same for all.
        cost = partial(cost_of, unknowns=u, weighing=self.weighing)
        return tuple(replace(e, cost=cost(e.physical, e.errors)) for e in ends)

    def _sizes(self, begun: Array) -> Array:
        """By how much each parameter has to change to change the outputs as much as any does, (P,).

        What changes nothing there has the scale of its steps.
        """
        u = self.unknowns
        try:
            self.predictions.settle(begun)
            _, slopes = jacobian_at(self.predictions, begun, self.scale, u.lower, u.upper, u.free)
        except EstimationError:
            return self.scale
        effect = np.linalg.norm(self.weighing.weights[:, None] * slopes, axis=0)
        most = np.full(len(effect), np.max(effect * np.abs(begun)))
        return np.asarray(np.divide(most, effect, out=self.scale.copy(), where=effect > 0))

    def _run(self, begun: Array, unknowns: Unknowns) -> SearchResult:
        search = Search(self.predictions, unknowns, self.scale, self.weighing, self.progress)
        return search.run(begun)

    def _search(self, begun: Array) -> SearchResult:
        """Until the weights, by what the fit leaves, are those that it was made with.

        What was known before is weighed by what the records leave without it, where they show every
        parameter: by what it makes them leave itself, one that contradicts them would count for all
        the more.
        """
        u, first = self.unknowns, self.weighing
        if not u.has_prior.any():
            return self._settled(begun, u)
        self.alone = None  # of an earlier start
        with suppress(EstimationError):
            alone = self._settled(begun, u.without_prior)
            rows = self.weighing.weights[:, None] * alone.jacobian
            unseen, _ = unseen_directions(rows, self.scale, u.free)
            self.alone = alone if alone.converged and not len(unseen) else None
        if self.alone is None:
            self.weighing = first
            return self._settled(begun, u)
        for _ in range(_PASSES):
            self._weigh(self.alone.errors, self._effects(self.alone, u))
        return self._run(begun, u)

    def _settled(self, begun: Array, unknowns: Unknowns) -> SearchResult:
        found, u = self._run(begun, unknowns), unknowns
        # Of one record by squares alone it does not matter how large the noise is.
        several = len(self.predictions.spans) * int(np.count_nonzero(np.isnan(self.given))) > 1
        needs_weights = several or self.loss != SQUARES or bool(u.has_prior.any())
        for _ in range(_PASSES):
            before, counted = self.weighing.weights, self.counted
            self.counted = self._counted(found.physical)
            self._weigh(found.errors, self._effects(found, u))
            changes = np.abs(self.weighing.weights - before)
            settled = not needs_weights or bool(np.all(changes <= _SETTLED * before))
            if settled and np.array_equal(counted, self.counted):
                return found
            again = self._run(u.inside(found.physical, self.scale * _SETTLED), u)
            found = replace(again, steps=(*found.steps, *again.steps))
        return found

    def _effects(self, found: SearchResult, unknowns: Unknowns) -> Array | None:
        """By how much each record's errors, as they are coloured, tell less of what was known."""
        if not unknowns.has_prior.any():
            return None
        return sandwich_of(
            found, self.weighing, unknowns, self.predictions, self.records, unknowns.free
        ).effects()

    def _weigh(self, errors: Array, effects: Array | None = None) -> None:
        """Weigh the rows of each output of each record by the inverse of what is left of them.

        Outputs are not weighted by how their errors go together: of a control, which the law makes
        of the position, that is nearly everything, and what is then left counts for most.

        Beside what was known before, a record whose errors follow one another counts for less.
        """
        weights, shares = self.counted.copy(), np.ones(len(errors))
        for r, spans in enumerate(self.predictions.spans):
            for place, given in enumerate(self.given):
                of_one = record_rows(spans, place, len(self.given))
                residuals = errors[of_one][weights[of_one] > 0]
                noise = float(np.sqrt(np.mean(residuals**2))) if len(residuals) else 0.0
                if self.loss != SQUARES:
                    noise = scale_of(residuals - float(np.median(residuals))) or noise
                weights[of_one] *= 1 / (noise or 1.0) if np.isnan(given) else given
            shares[record_rows(spans)] = 1.0 if effects is None else 1 / effects[r]
        self.weighing = WeightedLoss(
            weights=weights * np.sqrt(shares),
            loss=LOSS_FUNCTIONS[self.loss],
            tuning=1.0 if self.loss == SQUARES else HUBER_TUNING.value,
            shares=shares,
        )
