"""What is done in every run: which twin is made, its record or its lane, and by which methods."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.batched import RecordLanes, is_served
from axisid.estimation.bootstrap import Autoregressions, Chain, Draws
from axisid.estimation.choices import INSTRUMENT_STARTS, ROW_LOSSES, fitted_output
from axisid.estimation.diagnostic_checks import DEFAULT_LEVELS, Levels
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import TwinPlan, simulate_batch, twin_plan
from axisid.modeling.declaration import Experiment
from axisid.support.arrays import Array
from axisid.support.errors import (
    AxisidError,
    EstimationError,
    ModelError,
    UsageError,
    by_name,
    is_whole,
    quoted,
    refuse,
)
from axisid.support.mappings import FrozenMapping

#: What the intervals of a fit are of: errors that follow an autoregression.
COLOURED, IID = "coloured", "iid"
_MOST_RUNS = 10_000_000  # whose numbers a study holds together


@dataclass(frozen=True, slots=True, kw_only=True)
class MonteCarloPlan:
    """What is done in every run.

    Attributes
    ----------
    axis : GeneratedAxis
        That is identified.
    twin : GeneratedAxis
        That is simulated; the same, unless the model is to be wrong.
    runs : int
    seed : int
    methods : tuple of str
        Of `METHODS`, and fits such as ``fit:control``.
    noise : Chain
    prefilter : Prefilter
        What it leaves open is chosen for the twins' rate.
    checks : int
        How many runs are judged, from the first on.
    settings : mapping of str to object
        What else `identify` takes: ``covariance``, ``lags``, ``start``, ``loss``, which are nothing
        to fits.
    bootstrap : int
        How many twins tell the bias and HAC deviations of an estimate; 0 for none.
    levels : Levels
        By which runs are judged.
    """

    axis: GeneratedAxis
    twin: GeneratedAxis
    runs: int
    seed: int
    methods: tuple[str, ...]
    noise: Chain
    prefilter: Prefilter
    checks: int
    settings: Mapping[str, Any]
    bootstrap: int = 0
    levels: Levels = DEFAULT_LEVELS

    def __post_init__(self) -> None:
        refuse(
            UsageError,
            *(
                (
                    not (is_whole(value) and least <= value <= most),
                    f"the {what} {quoted(value)}; give a study a whole number of {least} or "
                    f"more, and of runs {_MOST_RUNS:,} at most, whose numbers are in memory "
                    "together",
                )
                for what, value, least, most in (
                    ("runs are", self.runs, 1, _MOST_RUNS),
                    ("seed is", self.seed, 0, math.inf),
                    ("checks are", self.checks, 0, math.inf),
                )
            ),
            code="study",
        )
        object.__setattr__(self, "settings", FrozenMapping(self.settings))

    @property
    def is_right(self) -> bool:
        """Whether what is identified is what is simulated, what is known exactly included."""
        if self.axis.signature != self.twin.signature:
            return False
        true = twin_plan(self.twin).true_values
        return all(
            math.isclose(p.known, true.get(p.name, p.known))
            for p in self.axis.base.known
            if p.known is not None and not p.known_sd
        )

    @property
    def regressions(self) -> tuple[str, ...]:
        """The methods of `identify`."""
        return tuple(method for method in self.methods if not fitted_output(method))

    @property
    def fits(self) -> tuple[str, ...]:
        """The methods that are fits of the output error."""
        return tuple(filter(fitted_output, self.methods))


def stated_by(method: str, chosen: str) -> str:
    """What the printed intervals of a method are of: those of identifications are chosen."""
    return COLOURED if fitted_output(method) else chosen


def noise_of(given: object, twin: GeneratedAxis, runs: object = 1) -> Chain:
    """The noise of an axis's twins, so many of them; the experiment's where none is given.

    Raises
    ------
    UsageError
        It is none, it begins anywhere in a count and the encoder has none, it makes several twins
        that are all the same, or it is beside the law or not sampled evenly, which no twin of an
        experiment is.
    ModelError
        It disturbs what is logged.
    """
    noise = Chain.of_experiment(twin.axis) if given is None else given
    if not isinstance(noise, Chain):
        raise UsageError(
            f"the noise is {quoted(noise)}; give a Chain, or leave it out.",
            code="noise",
        )
    for is_wrong, kind, said in (
        (
            noise.jitter or not noise.is_measured_by_law,
            UsageError,
            "are sampled evenly and their law measures the logged position; give noise without "
            "jitter, with is_measured_by_law=True",
        ),
        (
            noise.disturbances and twin.axis.drive.logs_what_acts,
            ModelError,
            "log what acts, which a disturbance is part of; leave it out, or declare a drive that "
            "logs its command",
        ),
        (
            noise.anywhere and not noise.position_step,
            UsageError,
            "are to begin anywhere in a count, and their encoder has none; give its resolution, or "
            "leave it out",
        ),
        (
            runs != 1 and not noise.is_random,
            UsageError,
            "would all be the same, since nothing of their noise is drawn; give one run, noise, or "
            "an encoder with motions that begin anywhere in a count",
        ),
    ):
        if is_wrong:
            raise kind(f"the twins of {twin.axis.name!r} {said}.", code="study")
    return noise.likeliest


def declared_chain(
    chain: Chain,
    *,
    position: float | None = None,
    resolution: float | None = None,
    anywhere: bool = False,
    velocity: float | None = None,
    acceleration: float | None = None,
    control: float | None = None,
    disturbance: float | None = None,
    correlation_time: float | None = None,
) -> Chain:
    """A chain with what is given.

    Parameters
    ----------
    chain : Chain
        The experiment's, as `Chain.of_experiment` has it.
    position, resolution : float, optional
        Of the encoder, in the coordinate's unit; the chain's by default.
    anywhere, velocity, acceleration
        As of a `Chain`.
    control, disturbance : float, optional
        In the drive's unit; none by default.
    correlation_time : float, optional
        Of both, s; white by default.
    """

    def coloured(deviation: float | None) -> Autoregressions:
        return ((correlation_time or 0.0, deviation),) if deviation else ()

    return replace(
        chain,
        position=chain.position if position is None else position,
        position_step=chain.position_step if resolution is None else resolution,
        anywhere=anywhere,
        velocity=velocity,
        acceleration=acceleration,
        control=coloured(control),
        disturbances=coloured(disturbance),
    )


def declared_figures(chain: Chain) -> dict[str, float | bool | None]:
    """The figures of a chain by these names: of several autoregressions their sum's deviation."""
    control, disturbance = (
        math.hypot(*(sd for _, sd in parts)) for parts in (chain.control, chain.disturbances)
    )
    return {
        "position": chain.position,
        "resolution": chain.position_step,
        "anywhere": chain.anywhere,
        "velocity": chain.velocity,
        "acceleration": chain.acceleration,
        "control": control,
        "disturbance": disturbance,
        "correlation_time": max(
            (time for time, _ in (*chain.control, *chain.disturbances)), default=0.0
        ),
    }


def twin_of(axis: GeneratedAxis, truth: object, moves: object) -> GeneratedAxis:
    """The axis with other true values, or another experiment; itself where neither is given.

    Parameters
    ----------
    axis : GeneratedAxis
    truth : mapping of str to float
        Over the experiment's.
    moves : sequence of Move or None
        In place of the experiment's.

    Raises
    ------
    UsageError
        These are none, or a value is of no parameter.
    """
    declared = axis.declared
    before = declared.experiment
    if moves is None and (before is None or not truth):
        return axis  # which without an experiment is refused as a twin
    known = {} if before is None else before.truth
    changed: dict[str, Any] = {"truth": {**known, **by_name(truth, "true values")}}
    changed |= {} if moves is None else {"moves": moves}
    try:
        given = Experiment(**changed) if before is None else replace(before, **changed)
        declared = replace(declared, experiment=given)
    except ModelError as error:
        raise UsageError(str(error), code=error.code) from error
    return build(declared, native=axis.native.enabled)


_POSITION, _SENSORS, _CONTROL, _DISTURBANCE, _OFFSET = range(5)  # each a stream of its own


def _draws(seed: int, run: int, stream: int) -> Draws:
    """The random numbers of a stream: a child of the seed for each run, whoever runs it."""
    child = np.random.SeedSequence(seed, spawn_key=(run, stream))
    return Draws(np.random.default_rng(child))


def twins(plan: MonteCarloPlan, runs: Sequence[int]) -> Iterator[tuple[int, Record | str]]:
    """The record of each run, or why there is none; made when it is asked for."""
    made = twin_plan(plan.twin)
    for run in runs:
        try:
            yield run, drawn_twin(made, plan.noise, plan.seed, run)
        except AxisidError as error:
            yield run, str(error)


def drawn_twin(plan: TwinPlan, noise: Chain, seed: int, run: int) -> Record:
    """The record of one run alone.

    Parameters
    ----------
    plan : TwinPlan
    noise : Chain
    seed, run : int
        As of a study, whose run has the same noise.

    Raises
    ------
    AxisidError
        The loop runs away, or the axis stands still while its reference moves.
    """
    draws, step = partial(_draws, seed, run), noise.position_step
    begin = noise.anywhere * step / 2 + noise.drawn_offset(draws(_OFFSET))
    experiment = replace(plan.experiment, resolution=step)
    own = disturbed = replace(plan, reference=plan.reference + begin, experiment=experiment)
    if noise.disturbances:
        samples = len(plan.reference)
        disturbance = noise.drawn_disturbance(draws(_DISTURBANCE), samples, plan.period)
        disturbed = replace(own, injected=disturbance, injected_at="control")
    loop = disturbed.loop(lambda count: noise.position * draws(_POSITION).normal(count))
    if still := _at_rest(own, loop.position):
        raise EstimationError(still, code="twin")
    if noise.disturbances:  # which are not logged
        loop = replace(loop, control=loop.control - disturbance)
    record = own.record(
        loop,
        f"twin {run + 1} of {plan.axis.axis.name}, seed {seed}",
        None if noise.velocity is None else loop.velocity,
        None if noise.acceleration is None else own.acceleration(loop),
    )
    return record.with_values(**noise.logged(record, draws(_SENSORS), draws(_CONTROL)))


def _at_rest(plan: TwinPlan, position: Array) -> str:
    """Why a twin's record shows nothing; empty if it does, by its position without noise, (N,)."""
    if np.ptp(position) or not np.ptp(plan.reference):
        return ""
    return (
        f"axis {plan.axis.axis.name!r} does not move with {plan.axis.describe(plan.truth)}: its "
        "friction holds whatever the drive gives. Give true values with which it moves."
    )


def are_lanes(plan: MonteCarloPlan) -> bool:
    """Whether runs that are not judged go side by side, whatever their company."""
    made, settings = twin_plan(plan.twin), plan.settings
    declared = plan.axis.declared.parameters
    return (
        len(plan.methods) == len(plan.regressions) == 1
        and (settings["start"], settings["loss"]) == (INSTRUMENT_STARTS[0], ROW_LOSSES[0])
        and plan.axis.names == tuple(p.name for p in declared)
        and made.clocks is None
        and not (made.signals or made.axis.axis.signals)
        and made.axis.axis.response is None
        and not made.axis.axis.drive.logs_what_acts
        # Twins differ by the noise of their position, and of their recorded control, alone.
        and replace(plan.noise, position=0.0, control=()) == Chain()
        and is_served(plan.axis, made.period, plan.methods[0])
    )


def twin_lanes(
    twin: GeneratedAxis, chain: Chain, seed: int, runs: Sequence[int], threads: int | None
) -> tuple[RecordLanes, Mapping[int, str]]:
    """The records of runs side by side, and why there is none of some, by lane."""
    plan = twin_plan(twin)
    samples = len(plan.reference)
    drawn = (_draws(seed, run, _POSITION).normal(samples) for run in runs)
    noise = chain.position * np.column_stack([*drawn])
    batch = simulate_batch(
        plan.axis,
        np.tile(plan.truth, (len(runs), 1)),
        plan.reference,
        plan.period,
        position_noise=noise,
        wanted=("position", "control"),
        threads=threads,
    )
    unsimulated = dict(batch.failures)
    for lane, position in enumerate(batch["position"].T):
        if lane not in unsimulated and (still := _at_rest(plan, position)):
            unsimulated[lane] = still
    noise += batch["position"]
    control = batch["control"]
    for lane, run in enumerate(runs if chain.control else ()):
        drawn_control = _draws(seed, run, _CONTROL)
        control[:, lane] = chain.logged_control(drawn_control, control[:, lane], plan.period)
    lanes = RecordLanes(
        reference=plan.reference, position=noise, control=control, period=plan.period
    )
    return lanes, unsimulated
