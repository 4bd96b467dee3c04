"""The twin of an axis: a simulated record with known true parameters."""

from __future__ import annotations  # as they are written, in what help() prints

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.codegen.lowering import LoopStart
from axisid.estimation.raw_tables import Provenance
from axisid.estimation.records import Record, check_sample_period
from axisid.estimation.signals import hold_mean
from axisid.estimation.thresholds import MIN_RECORD_SAMPLES
from axisid.modeling.declaration import Axis, ControlLaw, Experiment, Move
from axisid.support.arrays import Array
from axisid.support.checks import is_real, is_whole, refuse
from axisid.support.errors import ModelError, UsageError
from axisid.support.wording import quoted

from .closed_loop import simulate_loop
from .loop_inputs import TwoClocks, clocks_of, law_of
from .refusals import checked_loop, optional_array
from .simulated_signals import Simulation, logged_control, signals_about

_MOST_SAMPLES = 2e6


def trajectory(moves: tuple[Move, ...], period: float) -> Array:
    """Return the reference positions of consecutive moves with trapezoidal velocity, and dwells.

    Parameters
    ----------
    moves : tuple of Move
        Consecutive moves of the axis.
    period : float
        Sampling period, s.

    Returns
    -------
    (N,) array
        Positions, starting at 0, in the coordinate's unit.
    """
    check_sample_period(period)
    pieces = [np.zeros(1)]
    begin, start, taken = 0.0, 0.0, 0  # time and position where the move begins, samples so far
    for move in moves:
        distance = abs(move.distance)
        # The top speed; a short move does not reach its declared speed.
        speed = min(move.speed, math.sqrt(distance * move.acceleration))
        ramp = speed / move.acceleration
        cruise = distance / speed - ramp if speed else 0.0
        end = begin + 2 * ramp + cruise + move.dwell
        # Times of the samples in this move and its dwell, from the beginning of the move.
        count = int(np.floor(end / period + 1e-9))
        time = period * np.arange(taken + 1, count + 1, dtype=np.float64) - begin
        travelled = np.zeros_like(time)
        if speed:
            # Distance while the axis accelerates, while it cruises, and from then to the end.
            remaining = np.maximum(2 * ramp + cruise - time, 0)
            travelled = np.select(
                [time < ramp, time < ramp + cruise],
                [speed / ramp * time**2 / 2, speed * (time - ramp / 2)],
                speed * (ramp + cruise) - speed / ramp * remaining**2 / 2,
            )
        pieces.append(start + np.sign(move.distance) * travelled)
        begin, start, taken = end, start + move.distance, count
    return np.concatenate(pieces)


def twin_record(
    axis: Axis | GeneratedAxis,
    *,
    position_noise: float | None = None,
    velocity_noise: float | None = None,
    acceleration_noise: float | None = None,
    seed: int | None = None,
    injected: ArrayLike | None = None,
    injected_at: str | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    sample_period: float | None = None,
) -> Record:
    """Return the record of a twin: the declared experiment, simulated with true parameters.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Axis with a control law and an experiment.
    position_noise : float, optional
        Standard deviation of the noise on the measured position, inside the loop; the
        experiment's by default.
    velocity_noise, acceleration_noise : float, optional
        Standard deviations of the noise of a velocity and an acceleration that are measured outside
        the loop; not measured by default.
    seed : int, optional
        Seed of the noise; the experiment's by default.
    injected : (N,) array_like, optional
        A test signal, one value for each sample of the experiment.
    injected_at : str, optional
        Signal that the test signal is added to, ``"control"`` or ``"reference"``; as the axis
        declares by default.
    signals : mapping of str to (N,) array_like, optional
        The recorded signals that the axis declares, one value for each sample; those of the
        experiment by default.
    sample_period : float, optional
        Sampling period of the log, s; the law's by default. A sampled law always runs at its own
        period, with a set point that is computed at each evaluation, unless the law declares the
        interpolation of its reference between samples of the log. The noise of the position is
        drawn for each evaluation, or for each sample if there are more samples than evaluations.

    Raises
    ------
    UsageError
        The seed is no whole number, the position noise is negative, the moves are too short for a
        record, a declared signal has no values, or the sample period is far from the law's.
    ModelError
        The axis has no experiment or no control law, the experiment takes too many samples, or the
        drive cannot hold its load.
    """
    plan = twin_plan(
        axis,
        injected=injected,
        injected_at=injected_at,
        signals=signals,
        sample_period=sample_period,
    )
    experiment = plan.experiment
    deviation = experiment.position_noise if position_noise is None else position_noise
    chosen = experiment.seed if seed is None else seed
    refuse(
        UsageError,
        (
            not (is_whole(chosen) and 0 <= chosen < math.inf),
            f"the seed is {quoted(chosen)}. Give a whole number of 0 or more",
        ),
        (
            not (is_real(deviation) and 0 <= deviation < math.inf),
            f"the position noise is {quoted(deviation)}. Give its standard deviation, 0 or more",
        ),
        code="twin",
    )
    # Simulate the loop with position noise.
    generator = np.random.default_rng(chosen)
    loop = plan.loop(lambda count: generator.normal(0.0, deviation, count))
    # A separate stream, so that the position noise is the same without these sensors.
    rng = np.random.default_rng([chosen, 1])
    noise = rng.normal(size=(2, len(loop.velocity)))
    declared, counts = plan.axis, experiment.resolution
    counted = f", counts of {counts:g} {declared.coordinate.unit}" if counts else ""
    source = (
        f"twin of {declared.name}, seed {chosen}, position noise {deviation:g} "
        f"{declared.coordinate.unit}{counted}"
    )
    velocity = acceleration = None
    if velocity_noise is not None:
        velocity = loop.velocity + velocity_noise * noise[0]
    if acceleration_noise is not None:
        acceleration = plan.acceleration(loop) + acceleration_noise * noise[1]
    return plan.record(loop, source, velocity, acceleration)


def twin_plan(
    axis: Axis | GeneratedAxis,
    *,
    injected: ArrayLike | None = None,
    injected_at: str | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    sample_period: float | None = None,
) -> TwinPlan:
    """Return the inputs that all twins of an axis have in common; twins differ in noise only.

    A twin is the declared experiment, simulated with the true parameters. The arguments are those
    of `twin_record`.

    Raises
    ------
    UsageError, ModelError
        As in `twin_record`.
    """
    generated = as_generated(axis)
    declared = generated.axis
    experiment, law, period = _planned(declared, sample_period)
    reference = trajectory(experiment.moves, period)
    if len(reference) < MIN_RECORD_SAMPLES.value:
        raise UsageError(
            f"the moves of axis {declared.name!r} end after {len(reference)} samples of "
            f"{period:g} s, but a record needs {MIN_RECORD_SAMPLES.value} samples or more. Declare "
            "longer moves.",
            code="too-short",
        )
    clocks = clocks_of(law, len(reference), period)
    of_time = generated.experiment_signals(period * np.arange(float(len(reference))))
    recorded = {**of_time, **(signals or {})}
    if missing := [s.name for s in declared.signals if s.name not in recorded]:
        raise UsageError(
            f"axis {declared.name!r} declares the recorded signals {', '.join(missing)}, but its "
            "twin has no values for them. Give a record, give signals=..., or declare the signals "
            "in the experiment.",
            code="twin",
        )
    truth = np.array([*_truth(declared).values()])
    _check_held(generated, truth, float(reference[0]))
    return TwinPlan(
        axis=generated,
        experiment=experiment,
        truth=truth,
        reference=reference,
        period=period,
        clocks=clocks,
        signals=recorded,
        injected=optional_array(injected, "the injected signal", reference.shape),
        injected_at=injected_at or declared.injected_at or None,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinPlan:
    """Inputs of the simulated loop of a twin, at the samples of its log.

    Attributes
    ----------
    axis : GeneratedAxis
    experiment : Experiment
        Declared experiment: noise, encoder resolution, seed and moves.
    truth : (p,) array
        True values of the axis's parameters.
    reference : (N,) array
        Reference at the samples of the log.
    period : float
        Sampling period of the log, s.
    clocks : TwoClocks or None
        Times of the law's evaluations; None if the law has the period of the log.
    signals : mapping of str to array_like
        The recorded signals that the axis declares.
    injected : (N,) array or None
        Test signal; None for none.
    injected_at : str or None
        Signal that the test signal is added to, ``control`` or ``reference``; None if none is
        declared.
    """

    axis: GeneratedAxis
    experiment: Experiment
    truth: Array
    reference: Array
    period: float
    clocks: TwoClocks | None
    signals: Mapping[str, ArrayLike]
    injected: Array | None
    injected_at: str | None

    @property
    def true_values(self) -> dict[str, float]:
        """True values of the declared and of the identified parameters, SI, by name."""
        identified = dict(zip(self.axis.names, self.truth.tolist(), strict=True))
        return {**_truth(self.axis.declared), **identified}

    def loop(self, noise: Callable[[int], Array]) -> Simulation:
        """Return the simulated closed loop with position noise.

        Parameters
        ----------
        noise : callable
            Returns noise of a given length. If the law is faster than the log, the length is the
            number of the law's evaluations, otherwise the number of samples.
        """
        # Noise for each evaluation of the law, and for each sample.
        clocks, commanded = self.clocks, self.reference
        if clocks is not None and clocks.law_period < clocks.log_period:
            drawn = noise(len(clocks.times))
            logged = drawn[clocks.elapsed[0]]
        else:
            drawn = logged = noise(len(commanded))
        # Inputs at the samples, interpolated to the evaluations of the law.
        added = self.injected if self.injected_at == "reference" else None
        truth, inputs = checked_loop(
            self.axis,
            self.truth,
            commanded if added is None else commanded + added,
            self.period,
            start=float(commanded[0]),
            position_noise=logged,
            injected=self.injected if self.injected_at == "control" else None,
            signals=self.signals,
            resolution=self.experiment.resolution,
        )
        # A reference and noise that are made for each evaluation replace the interpolated ones.
        if clocks is not None:
            if law_of(self.axis).reference_between:
                reference = clocks.reference(commanded)
            else:  # the set point is computed at each evaluation
                moves = trajectory(self.experiment.moves, clocks.law_period)
                reference = moves[np.minimum(np.arange(len(clocks.times)), len(moves) - 1)]
            if added is not None:
                reference = reference + clocks.held(added)
            inputs = replace(
                inputs,
                reference=reference,
                start=LoopStart(position=float(reference[0])),
                noise=inputs.noise if drawn is logged else drawn,
            )
        return simulate_loop(self.axis, truth, inputs, bounded=True)

    def record(
        self,
        loop: Simulation,
        source: str,
        velocity: Array | None = None,
        acceleration: Array | None = None,
    ) -> Record:
        """Return the record of a simulated loop.

        Parameters
        ----------
        loop : Simulation
        source : str
            Name of the record.
        velocity, acceleration : (N,) array, optional
            Measured velocity and acceleration; not measured by default.
        """
        names = (s.name for s in self.axis.signals)
        return Record(
            time=self.period * np.arange(len(self.reference), dtype=np.float64),
            position=loop.measured_position,
            velocity=velocity,
            acceleration=acceleration,
            reference=self.reference,
            control=logged_control(self.axis, loop),
            injected=self.injected,
            injected_at=self.injected_at,
            signals=dict(zip(names, loop.recorded, strict=True)),
            sample_period=self.period,
            provenance=Provenance(source=source, truth=self.true_values),
        )

    def acceleration(self, loop: Simulation) -> Array:
        """Return the acceleration of an ideal sensor, (N,).

        At a jump it is the mean of the accelerations just before and just after the jump.
        """
        axis = self.axis
        if loop.held is not None or (axis.jumps and not axis.holds_force):
            before = signals_about(self.axis, self.truth, loop)[1].acceleration
            return (loop.acceleration + before) / 2
        return hold_mean(loop.acceleration, [0]) if axis.jumps else loop.acceleration


def _planned(axis: Axis, sample_period: float | None) -> tuple[Experiment, ControlLaw, float]:
    """Return the experiment and the control law of an axis, and the sampling period of the log, s.

    Raises
    ------
    ModelError
        The axis has no experiment or no control law, or the experiment takes too many samples.
    """
    experiment, law = axis.experiment, axis.control
    if experiment is None or law is None:
        missing, argument = "control law", "control"
        if experiment is None:
            missing = argument = "experiment"
        raise ModelError(
            f"axis {axis.name!r} declares no {missing}, so it has no twin. Give a record, or "
            f"declare {argument}=...",
            code="twin",
        )
    logged = law.period if sample_period is None else sample_period
    check_sample_period(logged)
    period = min(law.period, logged)
    samples = sum(move.duration for move in experiment.moves) / period
    if not samples <= _MOST_SAMPLES:
        raise ModelError(
            f"the experiment of axis {axis.name!r} would take {samples:.3g} samples of "
            f"{period:g} s, but at most {_MOST_SAMPLES:g} are allowed. Declare shorter moves, or "
            "the period of the drive in seconds.",
            code="twin",
        )
    return experiment, law, logged


def _check_held(axis: GeneratedAxis, truth: Array, start: float) -> None:
    """Refuse a twin whose drive cannot hold its load at the start.

    Raises
    ------
    ModelError
        The force at the drive's limit plus all friction is less than the load.
    """
    drive, coordinate = axis.drive, axis.coordinate
    if not math.isfinite(drive.limit) or axis.states or axis.signals:
        return  # the holding force of internal states or signals is not known here
    # Forces that hold the axis with friction in either direction, and forces at the drive's limit.
    load, given = axis.functions["inverse_dynamics"], axis.functions["drive_force"]
    needed = sorted(float(load(start, 0.0, 0.0, side, truth)) for side in (-1.0, 1.0))
    force = sorted(float(given(side * drive.limit, start, 0.0)) for side in (-1.0, 1.0))
    if needed[0] > force[1] or needed[1] < force[0]:
        off = needed[0] if needed[0] > force[1] else needed[1]
        unit = coordinate.force_unit
        raise ModelError(
            f"the drive of axis {axis.name!r} cannot hold its load. At its limit of "
            f"{drive.limit:g} {drive.unit} the drive gives {force[0]:.4g} to {force[1]:.4g} "
            f"{unit}. At rest at {start:g} {coordinate.unit} the load needs {off:.4g} "
            f"{unit} with {axis.describe(truth)}, so that the axis of the twin would fall. "
            "Raise the limit of the drive, or lower the load.",
            code="twin",
        )


def _truth(axis: Axis) -> dict[str, float]:
    """Return the true values of the declared parameters, nominal values where none is given."""
    truth = axis.experiment.truth if axis.experiment else {}
    return {p.name: truth.get(p.name, p.nominal) for p in axis.parameters}
