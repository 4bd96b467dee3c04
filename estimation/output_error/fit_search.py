"""The searches of one fit: their starts, the weights of the outputs, and their ends."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import SQUARES
from axisid.estimation.diagnostics.control_law import LawAgreement, first_failing, law_agreement
from axisid.estimation.identification import filtered_records
from axisid.estimation.methods import robust_scale
from axisid.estimation.nonlinear_least_squares import (
    LOSSES as LOSS_FUNCTIONS,
    MOST_IN_ALL,
    RESOLUTION,
    Search,
    SearchResult,
    WeightedLoss,
    cost_of,
)
from axisid.estimation.output_residuals import OutputResiduals, jacobian_at, record_rows
from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.thresholds import HUBER_TUNING
from axisid.estimation.unknowns import ExtendedForm, KnownValues, Unknowns, least_sizes
from axisid.support.arrays import Array, BoolArray, mask_of
from axisid.support.errors import AxisidError, EstimationError
from axisid.support.progress import Progress

from .covariance import Sandwich, sandwich_of, unseen_directions
from .fit_setup import FitStart

# Largest number of updates of the weights, and relative change up to which they have converged.
_PASSES, _SETTLED = 4, 0.02
# standard errors: resolution of a search after which weights and kept rows are updated
_COARSE = 0.1


@dataclass(frozen=True, kw_only=True, eq=False)
class FitSearch:
    """The arguments of a fit, and the ends of its searches.

    Attributes
    ----------
    axis, records, outputs, loss, known, bootstrap, seed
        As in `fit`.
    form : ExtendedForm
        Map of the parameters of the fit to those of each record's axis.
    unknowns : Unknowns
        Bounds, prior values and fixed values of the parameters.
    predictions : OutputResiduals
        Residuals of the outputs as a function of the parameters.
    start, scale : (P,) array
        Start of the first search, and scales of the parameters' steps.
    started : str
        Kind of the start: ``instruments``, ``least-squares``, ``nominal`` or ``given``.
    weighing : WeightedLoss
    remarks : tuple of str
        Reasons why other starts were not used.
    best : SearchResult
        The search with the lowest cost, which is reported.
    searches : tuple of SearchResult
        All finished searches.
    predictions_with_changed_known : tuple of (ExtendedForm, OutputResiduals)
        For each known value with a standard error: the form and the predictions with this value
        changed by its standard error.
    rests_count : bool
        True if samples near standstill are kept, as the other samples hardly show a parameter.
    alone : SearchResult or None
        The search without prior values; None without prior values, or if the records do not show
        every parameter.
    interrupted : bool
        True if Ctrl-C ended the searches. The best end so far is reported, without replicas.
    """

    axis: GeneratedAxis
    records: tuple[Record, ...]
    form: ExtendedForm = field(repr=False, compare=False)
    outputs: tuple[str, ...]
    loss: str
    unknowns: Unknowns = field(repr=False, compare=False)
    predictions: OutputResiduals = field(repr=False, compare=False)
    start: Array
    started: str
    scale: Array
    weighing: WeightedLoss = field(repr=False, compare=False)
    remarks: tuple[str, ...]
    best: SearchResult
    searches: tuple[SearchResult, ...]
    bootstrap: int
    seed: int
    known: KnownValues
    predictions_with_changed_known: tuple[tuple[ExtendedForm, OutputResiduals], ...] = field(
        repr=False, compare=False
    )
    rests_count: bool = field(repr=False, compare=False)
    alone: SearchResult | None = field(repr=False, compare=False)
    interrupted: bool = False

    @property
    def horizon(self) -> float | None:
        """Length of the windows of an open loop, s; None for closed loops."""
        return self.predictions.horizon

    @property
    def of_start(self) -> BoolArray:
        """True for parameters that are initial positions and velocities of loops, (P,)."""
        return least_sizes(self.form) > 0

    @property
    def ended(self) -> dict[str, float]:
        """Parameters at the end of the best search, SI, by name."""
        return dict(zip(self.unknowns.names, map(float, self.best.physical), strict=True))

    def sandwich(self, chosen: BoolArray) -> Sandwich:
        """Return the parts of the sandwich covariance at the end of the best search.

        `chosen`, (P,), is True for the parameters of the covariance.
        """
        return sandwich_of(
            self.best, self.weighing, self.unknowns, self.predictions, self.records, chosen
        )


def near_rests(form: ExtendedForm, records: Sequence[Record]) -> dict[int, FilteredRecord]:
    """Return the filtered records that show which samples are near standstill and reversals.

    The keys are the numbers of the records, from 0. The excluded stretches of a filtered record are
    the samples that the fit leaves out; a record may also keep all its samples.

    Samples are left out around standstill and reversals of the record and of its simulated loop, as
    regressions leave out rows, at the distance that the default filter gives. There are two
    reasons. At standstill friction takes any force, so that such samples do not show the
    parameters; under a law with an integral the control is undetermined there. With an encoder such
    samples bias the estimate: the encoder has no noise at standstill, and record and loop come to
    standstill and leave it at different times.

    No sample of any record is left out if the records together show too little without these
    samples. Two kinds of records are kept whole: records of friction with internal state, which is
    shown near reversals only, and records that are too short for the filter.
    """
    filterable = list[int]()
    for i, (axis, record) in enumerate(zip(form.axes, records, strict=True)):
        if not axis.states:
            with suppress(AxisidError):
                FilteredRecord.bind(axis, record, Prefilter(reversals="keep"))
                filterable.append(i)
    if not filterable:
        return {}
    data = filtered_records(
        [form.axes[i] for i in filterable],
        [records[i] for i in filterable],
        Prefilter(),
        [form.of_model.record_jacobian(i) for i in filterable],
    )
    return dict(zip(filterable, data, strict=True))


@dataclass
class FitRun:
    """The searches of one fit, and the weights of the outputs that they estimate.

    Attributes
    ----------
    form, records, predictions, unknowns, loss, progress, alone, interrupted
        As in `FitSearch` and `fit`.
    given : tuple of float
        Weights of the outputs; NaN for those that are estimated.
    rests : mapping of int to FilteredRecord
        Records whose samples near standstill are left out, see `near_rests`.
    scale : (P,) array
        Scales of the parameters' steps.
    counted : (n,) array
        1 for rows of the outputs with weight, 0 for others.
    weighing : WeightedLoss
        Present weights and loss of the rows.
    """

    form: ExtendedForm
    records: Sequence[Record]
    predictions: OutputResiduals
    unknowns: Unknowns
    loss: str
    given: tuple[float, ...]  # weights of the outputs, NaN if they are to be estimated
    progress: Progress | None
    rests: Mapping[int, FilteredRecord]
    scale: Array = field(init=False)
    counted: Array = field(init=False)
    weighing: WeightedLoss = field(init=False)
    alone: SearchResult | None = None
    interrupted: bool = False

    def first(self, start_points: Sequence[FitStart]) -> tuple[FitStart, Array, list[str]]:
        """Return the start with the lowest cost, its parameters (P,), and reasons of failed starts.

        The parameters are those of the start, moved inside the bounds. The weights of the rows are
        estimated from the residual at the first start that can be simulated, so that the costs of
        the starts can be compared, and then again at the best start.

        Raises
        ------
        EstimationError
            No start can be simulated.
        """
        # Simulate all starts, and keep those that can be simulated.
        failed: list[str] = []
        tried = list[tuple[FitStart, Array, Array, Array, list[str]]]()
        for point in start_points:
            scale = self.unknowns.scale(point.physical, point.size)
            at = self.unknowns.inside(point.physical, scale)
            lanes = self.predictions(at[None, :])
            if lanes.failures:
                failed.append(
                    f"the fit cannot start from {point.named} values: {lanes.failures[0]}"
                )
            else:
                tried.append((point, at, lanes.errors[:, 0], scale, [*failed]))
        if not tried:
            raise EstimationError(f"{failed[0]}{self._suspects(start_points[0])}", code="fit")
        # Compare their costs with the weights of the first, then estimate the weights at the best.
        self.counted = self._counted()
        self._weigh(tried[0][2])
        costs = [cost_of(at, errors, self.unknowns, self.weighing) for _, at, errors, _, _ in tried]
        first, at, errors, self.scale, failed_before = tried[costs.index(min(costs))]
        self._weigh(errors)
        return first, at, failed_before

    def _counted(self, physical: Array | None = None) -> Array:
        """Return 1 for rows with weight, 0 near standstill of records and simulated loops, (n,).

        A loop that never moves would leave no rows, and is not considered.

        Parameters
        ----------
        physical : (P,) array, optional
            Parameters of the simulated loops; without parameters, only the standstill of the
            records is considered.
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
                # Samples near the standstill of the record, or of its simulated loop.
                velocity = np.zeros(len(data))
                velocity[samples] = loops[r]
                turns = data.excluded + data.sampling.turns(velocity, data.fastest)
                either = mask_of(turns, len(data))[samples]
                if not either.all():
                    near = either
            rows = record_rows(self.predictions.spans[r])
            counted[rows][np.repeat(near, len(self.predictions.units))] = 0.0
        return counted

    def _suspects(self, start: FitStart) -> str:
        """Return sentences on possible causes why no loop can start; empty if there are none.

        Causes are parameters of the start below their bounds, and a wrong control law.
        """
        quantities, low = self.unknowns.quantities, start.physical < self.unknowns.lower
        below = ", ".join(
            f"{q.name} = {value:.6g} {q.unit}"
            for q, value, is_low in zip(quantities, start.physical, low, strict=True)
            if is_low
        )
        sentences = ""
        if below:
            sentences = (
                f" The {start.named} estimate is below the bounds: {below}. "
                "Check the signs of the control, of the positions and of the drive gain."
            )
        law = first_failing([*map(law_agreement, self.form.axes, self.records)])
        if isinstance(law, LawAgreement) and not law.passed:
            sentences += f" The control law: {law.sentence}."
        return sentences

    def searches(
        self, first: FitStart, start_values: Array, count: int, random: np.random.Generator
    ) -> tuple[SearchResult, ...]:
        """Return the finished searches: from the start, then from random values near it.

        An interrupt ends all searches as soon as there are values to report.

        Parameters
        ----------
        first : FitStart
            The start.
        start_values : (P,) array
            Its parameters, inside the bounds.
        count : int
            Number of searches.
        random : numpy.random.Generator
            Generator of the further starts.

        Raises
        ------
        EstimationError
            No search can be finished.
        """
        ends, failures, u = list[SearchResult](), list[EstimationError](), self.unknowns
        sizes = self._sizes(start_values) if count > 1 else self.scale
        for k in range(count):
            try:
                if k:  # a random start; initial states of loops keep their values
                    drawn = u.drawn_about(first.physical, sizes, random)
                    drawn = np.where(least_sizes(self.form) > 0, first.physical, drawn)
                    start_values = u.inside(drawn, self.scale)
                # The first search estimates the weights, with which the others run.
                ends.append(self._run(start_values, u) if ends else self._search(start_values))
            except EstimationError as error:
                failures.append(error)
            except KeyboardInterrupt:
                if not ends:
                    raise
                self.interrupted = True
            if self.interrupted:
                break
        if not ends:
            raise failures[0]
        # Costs with the last weights, so that they can be compared.
        return tuple(replace(e, cost=cost_of(e.physical, e.errors, u, self.weighing)) for e in ends)

    def _sizes(self, start_values: Array) -> Array:
        """Return sizes of the parameters for random starts, (P,).

        A change of a parameter by its size has the same effect on the outputs for every parameter,
        to first order at the start `start_values`, (P,). A parameter without effect has the scale
        of its steps.
        """
        u = self.unknowns
        try:
            self.predictions.settle(start_values)
            _, slopes = jacobian_at(
                self.predictions, start_values, self.scale, u.lower, u.upper, u.free
            )
        except EstimationError:
            return self.scale
        effect = np.linalg.norm(self.weighing.weights[:, None] * slopes, axis=0)
        most = np.full(len(effect), np.max(effect * np.abs(start_values)))
        return np.asarray(np.divide(most, effect, out=self.scale.copy(), where=effect > 0))

    def _run(
        self, start_values: Array, unknowns: Unknowns, resolution: float = RESOLUTION
    ) -> SearchResult:
        """Return the end of one search from parameters `start_values`, (P,).

        The weights of the outputs are the present ones. `resolution` is the length of a step, in
        standard errors, at which the search ends.
        """
        # Discard the simulation settings of earlier searches; they are chosen again.
        self.predictions.begin(start_values)
        search = Search(
            self.predictions,
            unknowns,
            self.scale,
            self.weighing,
            self.progress,
            resolution=resolution,
        )
        found = search.run(start_values)
        self.interrupted = self.interrupted or found.interrupted
        return found

    def _search(self, start_values: Array) -> SearchResult:
        """Return the end of a search from parameters (P,), with weights that fit its residual.

        With prior values, the weights of the rows are estimated by a search without prior values,
        if the records show every parameter. The reason is that a prior value that contradicts the
        records increases the residual, and would get more weight by that.
        """
        u, first = self.unknowns, self.weighing
        if not u.has_prior.any():
            return self._settled(start_values, u)
        # Search without prior values; the end counts if it converged and shows every parameter.
        self.alone = None  # of an earlier start
        with suppress(EstimationError):
            alone = self._settled(start_values, u.without_prior)
            if self.interrupted:
                return alone
            rows = self.weighing.weights[:, None] * alone.jacobian
            unseen, _ = unseen_directions(rows, self.scale, u.free)
            self.alone = alone if alone.converged and not len(unseen) else None
        # Without such an end, the weights follow the residual of the search with prior values.
        if self.alone is None:
            self.weighing = first
            return self._settled(start_values, u)
        # Otherwise fix the weights by its residual, and search once with the prior values.
        for _ in range(_PASSES):
            self._weigh(self.alone.errors, self._effects(self.alone, u))
        return self._run(start_values, u)

    def _settled(self, start_values: Array, unknowns: Unknowns) -> SearchResult:
        """Return the end of a search from parameters (P,), repeated until the weights converge."""
        found = self._run(start_values, unknowns)
        try:
            return self._reweighed(found, unknowns)
        except KeyboardInterrupt:
            self.interrupted = True
            return replace(found, converged=False, interrupted=True)

    def _reweighed(self, found: SearchResult, unknowns: Unknowns) -> SearchResult:
        """Return the end of a search that is repeated until the weights are those of its residual.

        Each pass leaves out samples near standstill of the loops found last, estimates the weights
        from the residual, and searches again from the last end. Searches before the last one need
        an accuracy of a part of a standard error only. The search has not converged if it needs too
        many steps.
        """
        u, resolution = unknowns, RESOLUTION
        # The size of the noise does not matter for squares of a single output and record.
        several = len(self.predictions.spans) * int(np.count_nonzero(np.isnan(self.given))) > 1
        needs_weights = several or self.loss != SQUARES or bool(u.has_prior.any())
        for left in reversed(range(_PASSES)):
            if self.interrupted:
                break
            if len(found.steps) >= MOST_IN_ALL:
                return replace(found, converged=False)
            # New weights from the last end; finished if they hardly change and it is exact.
            before, counted = self.weighing.weights, self.counted
            self.counted = self._counted(found.physical)
            self._weigh(found.errors, self._effects(found, u))
            changes = np.abs(self.weighing.weights - before)
            settled = not needs_weights or bool(np.all(changes <= _SETTLED * before))
            settled = settled and np.array_equal(counted, self.counted)
            exact = found.converged and found.step_left <= RESOLUTION
            if settled and (exact or resolution == RESOLUTION):
                return found
            resolution = RESOLUTION if settled or not left else _COARSE
            again = self._run(u.inside(found.physical, self.scale * _SETTLED), u, resolution)
            found = replace(again, steps=(*found.steps, *again.steps))
        return found

    def _effects(self, found: SearchResult, unknowns: Unknowns) -> Array | None:
        """Return the ratio of coloured to independent variance by record, (r,).

        None without prior values, as weights relative to them are then not needed.
        """
        if not unknowns.has_prior.any():
            return None
        return sandwich_of(
            found, self.weighing, unknowns, self.predictions, self.records, unknowns.free
        ).effects()

    def _weigh(self, errors: Array, effects: Array | None = None) -> None:
        """Set the weights of the rows by residuals (n,): the inverse of their rms or robust scale.

        Each output of each record has its own weight, unless the user gave it.

        The correlation between outputs is not used for weights: the law makes the control from the
        position, so that their errors are nearly proportional, and the small remainder would have
        most of the weight.

        Relative to prior values, a record with autocorrelated errors has less weight: its squared
        weights are divided by `effects`, (r,), the ratio of coloured to independent variance.
        """
        weights, shares = self.counted.copy(), np.ones(len(errors))
        for r, spans in enumerate(self.predictions.spans):
            for place, given in enumerate(self.given):
                of_one = record_rows(spans, place, len(self.given))
                residuals = errors[of_one][weights[of_one] > 0]
                noise = float(np.sqrt(np.mean(residuals**2))) if len(residuals) else 0.0
                if self.loss != SQUARES:
                    noise = robust_scale(residuals - float(np.median(residuals))) or noise
                weights[of_one] *= 1 / (noise or 1.0) if np.isnan(given) else given
            shares[record_rows(spans)] = 1.0 if effects is None else 1 / effects[r]
        self.weighing = WeightedLoss(
            weights=weights * np.sqrt(shares),
            loss=LOSS_FUNCTIONS[self.loss],
            tuning=1.0 if self.loss == SQUARES else HUBER_TUNING.value,
            shares=shares,
        )
