"""How filter and noise bias least squares of records without a reference, by loops that follow."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from axisid.estimation.records import Record
from axisid.estimation.regression import (
    Equations,
    FollowingLoops,
    Form,
    sensor_steps,
    simulated_right,
)
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR
from axisid.support.arrays import Array, relative_error_percent

from .filter_bias import NoiseFree, loop_record, noise_free
from .problem import Problem
from .solver import by_least_squares

_DRAWS = 4  # of noise, each once with either sign: what is odd in the noise cancels


def noise_free_following(
    form: Form, problem: Problem, left: Array, physical: Array
) -> NoiseFree | None:
    """The same of least squares of records without a reference, by loops that follow them.

    What the records' position is beside that of the loops is its noise. Noise in the regressor, and
    in a control that answers to it, biases least squares. How much is told by least squares of the
    same loops with that noise in another order: the simulation step of Cook and Stefanski's SIMEX.

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    problem : Problem
        Of records without a reference.
    left : (n,) array
        Left side of the measured rows.
    physical : (p,) array

    Returns
    -------
    NoiseFree or None
        None if the loops do not follow the records.

    Raises
    ------
    ModelError, DataError, EstimationError
        The loops are not known, or cannot be simulated.
    """
    following = [FollowingLoops.of(data) for data in problem.data]
    every = [each.simulated(physical) for each in following]
    if not _follow(form, problem, every, left, physical):
        return None
    flat = tuple(loop for of_one in every for loop in of_one)
    quiet = noise_free(form, problem, flat, physical, by_least_squares)
    noises = [
        _noises(each.data, loops, np.random.default_rng(i))
        for i, (each, loops) in enumerate(zip(following, every, strict=True))
    ]
    biases = [
        _bias_with_noise(form, following, drawn, physical) for drawn in zip(*noises, strict=True)
    ]
    return replace(quiet, bias=np.mean(biases, axis=0), has_noise=True)


def followed_as_measured(data: FilteredRecord, physical: Array) -> Iterator[FilteredRecord]:
    """The loops that follow a record, as it would be with its noise, or its steps, once more.

    Raises
    ------
    ModelError, DataError, EstimationError
        The loops are not known, or cannot be simulated.
    """
    following = FollowingLoops.of(data)
    quiet = following.simulated(physical)
    for noise in _noises(data, quiet, np.random.default_rng(0)):
        yield _measured_again(following, noise, physical)


def _measured_again(
    following: FollowingLoops, noise: Mapping[str, Array], physical: Array
) -> FilteredRecord:
    """A record as its loops have it with noise of what is measured, by role."""
    loops = following.simulated(physical, noise["position"])
    noisy = loop_record(following.data, loops, measured=True)
    beside: dict[str, Any] = {
        role: getattr(noisy.record, role) + values
        for role, values in noise.items()
        if role != "position"
    }
    return replace(noisy, record=replace(noisy.record, **beside))


def _noises(
    data: FilteredRecord, loops: tuple[Simulation, ...], rng: np.random.Generator
) -> Iterator[dict[str, Array]]:
    """Noise of what was measured of the motion, by role, (N,), as often as it is drawn.

    That of an encoder is no white noise: it follows from the motion, and from where its steps are,
    unless noise is more than a step.
    """
    position = np.concatenate([loop.position for loop in loops])
    step = sensor_steps(data.axis, data.record).position
    white = {role: white_noise(data.record, loops, role) for role in data.record.motion}
    by_steps = bool(step) and float(np.std(white["position"])) <= step
    for draw in range(_DRAWS):
        order = {role: rng.permutation(noise) for role, noise in white.items()}
        for k, sign in enumerate((1.0, -1.0)):
            found = {role: sign * noise for role, noise in order.items()}
            if by_steps:
                away = (draw + k / 2) / _DRAWS * step
                found["position"] = step * np.round((position + away) / step) - away - position
            yield found


def white_noise(record: Record, loops: tuple[Simulation, ...], role: str) -> Array:
    """Noise of a measured role, (N,), as large as its second differences.

    Its slow part is the loops': they follow it, or do not quite move as the axis did.
    """
    return white_part(getattr(record, role) - np.concatenate([getattr(s, role) for s in loops]))


def white_part(apart: Array) -> Array:
    """What of a difference, (N,), is as large as its second differences say that white noise is."""
    apart = apart - apart.mean()
    size, white = float(np.std(apart)), float(np.std(np.diff(apart, 2))) / 6**0.5
    return np.asarray(apart * min(1.0, white / size) if size else apart)


def _follow(
    form: Form,
    problem: Problem,
    every: Sequence[tuple[Simulation, ...]],
    left: Array,
    physical: Array,
) -> bool:
    rights = [
        simulated_right(form, loops, physical, data)
        for loops, data in zip(every, problem.data, strict=True)
    ]
    theta = form.regressed(physical)
    made = np.concatenate([intercept + right @ theta for intercept, right in rights])
    return relative_error_percent(left - made, left) < MAX_SIMULATION_ERROR.value


def _bias_with_noise(
    form: Form,
    following: Sequence[FollowingLoops],
    noise: Sequence[Mapping[str, Array]],
    physical: Array,
) -> Array:
    """What least squares makes of the loops with noise of what was measured."""
    pieces = []
    for each, of_one in zip(following, noise, strict=True):
        noisy = _measured_again(each, of_one, physical)
        if noisy.prefilter.reversals == "leave-out":  # they are those of what is measured
            noisy = noisy.turning_as(noisy.record.position, noisy.record.velocity)
        pieces.append(form.equations(noisy.signals).reduced(noisy))
    solution = by_least_squares(form, Equations.stacked(pieces))
    return np.asarray(form.physical(solution.theta)[0] - physical, dtype=float)
