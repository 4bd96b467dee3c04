"""The twin: a simulated record of an axis whose parameters are known."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.records import Record
from axisid.estimation.tables import Provenance
from axisid.modeling.declaration import Axis, Move
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import ModelError, UsageError
from axisid.support.given import given
from axisid.support.real_numbers import is_real, is_whole

from .closed_loop import checked_signal, simulate

_MOST_SAMPLES = 2e6


def trajectory(moves: tuple[Move, ...], period: float) -> Array:
    """Reference positions of moves with trapezoidal velocity, one after the other.

    Parameters
    ----------
    moves : tuple of Move
    period : float
        Sampling period, s.

    Returns
    -------
    (N,) array
        From 0, in the coordinate's unit.
    """
    if not (is_real(period) and 0 < period < math.inf):
        raise UsageError(f"the period is {given(period)} s; give a positive number.")
    pieces = [np.zeros(1)]
    begin, start, taken = 0.0, 0.0, 0  # time and position where the move begins, samples so far
    for move in moves:
        ramp, cruise, speed = _phases(move)
        end = begin + 2 * ramp + cruise
        count = int(np.floor(end / period + 1e-9))
        time = period * np.arange(taken + 1, count + 1, dtype=np.float64) - begin
        pieces.append(start + np.sign(move.distance) * _travelled(time, ramp, cruise, speed))
        begin, start, taken = end, start + move.distance, count
    return np.concatenate(pieces)


def twin_record(
    axis: Axis | GeneratedAxis,
    *,
    position_noise: float | None = None,
    seed: int | None = None,
    injected: ArrayLike | None = None,
    injected_at: str | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
) -> Record:
    """Simulate the axis's own experiment with its true parameters.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a control law and an experiment.
    position_noise : float, optional
        Standard deviation of the noise on the measured position, inside the loop; the
        experiment's by default.
    seed : int, optional
        Of the noise; the experiment's by default.
    injected : (N,) array_like, optional
        A test signal, one value for each sample of the experiment.
    injected_at : str, optional
        What it is added to, ``"control"`` or ``"reference"``; what the axis says by default.
    signals : mapping of str to (N,) array_like, optional
        The recorded signals that the axis declares, likewise; those of the experiment by default.

    Raises
    ------
    UsageError
        The seed is no whole number.
    ModelError
        The axis has no experiment or no control law.
    """
    generated = as_generated(axis)
    declared = generated.axis
    experiment, law = declared.experiment, declared.control
    if experiment is None or law is None:
        missing = "experiment" if experiment is None else "control law"
        raise ModelError(
            f"axis {declared.name!r} declares no {missing}, so it has no twin. Give a record, or "
            f"declare {'experiment' if experiment is None else 'control'}=...",
            code="no-experiment",
        )
    samples = sum(move.duration for move in experiment.moves) / law.period
    if not samples <= _MOST_SAMPLES:
        raise ModelError(
            f"axis {declared.name!r}: its experiment would take {samples:.3g} samples of "
            f"{law.period:g} s; declare at most {_MOST_SAMPLES:g} (shorter moves, or the period of "
            "the drive in seconds).",
            code="long-experiment",
        )
    reference = trajectory(experiment.moves, law.period)
    truth = [_true(declared, p) for p in declared.parameters]
    deviation = experiment.position_noise if position_noise is None else position_noise
    chosen = experiment.seed if seed is None else seed
    if not is_whole(chosen) or chosen < 0:
        raise UsageError(
            f"the seed is {given(chosen)}; give a whole number of 0 or more.", code="twin-seed"
        )
    noise = np.random.default_rng(chosen).normal(0.0, deviation, len(reference))
    place = injected_at or declared.injected_at or None
    added = None if injected is None else checked_signal(injected, reference, "the injected signal")
    of_time = generated.experiment_signals(law.period * np.arange(float(len(reference))))
    recorded = {**of_time, **(signals or {})}
    if untold := [s.name for s in declared.signals if s.name not in recorded]:
        raise UsageError(
            f"axis {declared.name!r} has the recorded signals {', '.join(untold)}, and nothing "
            "says what they are in its twin; give a record, signals=..., or declare them in the "
            "experiment.",
            code="twin-signals",
        )
    loop = simulate(
        generated,
        np.array(truth),
        reference if added is None or place != "reference" else reference + added,
        law.period,
        start=float(reference[0]),
        position_noise=noise,
        injected=added if place == "control" else None,
        signals=recorded,
    )
    return Record(
        time=law.period * np.arange(len(reference), dtype=np.float64),
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
        injected=added,
        injected_at=place,
        signals=dict(zip((s.name for s in declared.signals), loop.recorded, strict=True)),
        sample_period=law.period,
        provenance=Provenance(
            source=f"twin of {declared.name}, seed {chosen}, position noise {deviation:g} "
            f"{declared.coordinate.unit}",
            truth={
                **{p.name: _true(generated.declared, p) for p in generated.declared.parameters},
                **dict(zip(generated.names, truth, strict=True)),
            },
        ),
    )


def _true(axis: Axis, parameter: Parameter) -> float:
    truth = axis.experiment.truth if axis.experiment else {}
    return truth.get(parameter.name, parameter.nominal)


def _phases(move: Move) -> tuple[float, float, float]:
    """Duration of a ramp and of the cruise, s, and the cruise speed; short moves never cruise."""
    distance = abs(move.distance)
    speed = min(move.speed, float(np.sqrt(distance * move.acceleration)))
    ramp = speed / move.acceleration
    return ramp, (distance / speed - ramp if speed else 0.0), speed


def _travelled(time: Array, ramp: float, cruise: float, speed: float) -> Array:
    """Distance after `time` of a move with trapezoidal velocity."""
    if speed == 0:
        return np.zeros_like(time)
    acceleration, end = speed / ramp, 2 * ramp + cruise
    distance = speed * (ramp + cruise)
    return np.select(
        [time < ramp, time < ramp + cruise],
        [acceleration * time**2 / 2, speed * (time - ramp / 2)],
        distance - acceleration * np.maximum(end - time, 0) ** 2 / 2,
    )
