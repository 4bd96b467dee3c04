"""What the steps of an encoder add to the covariance of an estimate.

The error of an encoder that rounds the position is no noise: it follows from the motion, comes
again where that does, and the control answers to it. So it biases an estimate, by instruments too,
and neighbouring rows do not show how far it makes one scatter. The simulated loop with such an
encoder has the same error: estimates from several loops, whose steps begin elsewhere, tell both.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import KeptByRecord
from axisid.estimation.records import Record
from axisid.estimation.records.faults import quantum_of
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds.regression import (
    MAX_DITHERED_SHARE,
    MIN_STEP_DIFFERENCES,
    MIN_STEPS_SHIFT,
)
from axisid.support.arrays import Array, in_few_digits

from .covariance import Hac
from .linear import Solution
from .simulated_rows import simulated_loops

_LOOPS = 10
#: Where the steps begin, as a share of one.
STEP_SHARES = tuple((i + 0.5) / _LOOPS for i in range(_LOOPS))


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorSteps:
    """What the recorded motion is rounded to, SI; 0 where nothing is known of it.

    Attributes
    ----------
    position : float
        In the loop too.
    velocity : float
        Of a measured one whose noise does not average its steps.
    """

    position: float = 0.0
    velocity: float = 0.0

    def __bool__(self) -> bool:
        return bool(self.position or self.velocity)

    def told(self, unit: str) -> str:
        """Both in words, positions in a unit."""
        of = (
            ("an encoder's", self.position, unit),
            ("a measured velocity's", self.velocity, f"{unit}/s"),
        )
        return " and ".join(f"{whose} steps of {size:.3g} {u}" for whose, size, u in of if size)


_KNOWN: KeptByRecord[int, SensorSteps] = KeptByRecord()


def sensor_steps(axis: GeneratedAxis, record: Record) -> SensorSteps:
    """The steps of a record's sensors."""
    law = axis.axis.control
    if law is None or law.continuous:
        return SensorSteps()
    known, fewest = _KNOWN.of(record), int(MIN_STEP_DIFFERENCES.value)
    if fewest not in known:
        known[fewest] = _steps_of(record, fewest)
    return known[fewest]


def _steps_of(record: Record, fewest: int) -> SensorSteps:
    return SensorSteps(
        position=0.0 if record.integrated else quantum_of(record.position, fewest),
        velocity=0.0 if record.velocity is None else undithered_step(record.velocity, fewest),
    )


def undithered_step(values: Array, fewest: int) -> float:
    """What values are rounded to, unless their noise is of that size: then that averages out."""
    step = quantum_of(values, fewest)
    changing = np.abs(np.diff(values)) > step / 2
    return 0.0 if np.mean(changing) > MAX_DITHERED_SHARE.value else step


def stepped_loops(
    axis: GeneratedAxis, record: Record, physical: Array, steps: SensorSteps, share: float
) -> tuple[Simulation, ...]:
    """`simulated_loops` of such sensors, whose steps are `share` of one away from whole ones."""
    step, away = steps.position, share * steps.position
    loops = simulated_loops(axis, record, in_few_digits(physical), resolution=step, away=away)
    if step:
        loops = tuple(loop.as_measured(-away) for loop in loops)
    if not steps.velocity:
        return loops
    return tuple(replace(loop, velocity=_rounded(loop, steps.velocity, share)) for loop in loops)


def _rounded(loop: Simulation, step: float, share: float) -> Array:
    """Velocity of a loop as a sensor has it whose steps are `share` of one away."""
    return np.asarray((np.round(loop.velocity / step + share) - share) * step, dtype=float)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsError:
    """What an encoder's steps do to an estimate beside what neighbouring rows show.

    Attributes
    ----------
    bias : (k,) array
        Of the regression's own parameters.
    missing : (k, k) array
        Covariance of their scatter that the HAC covariance does not show.
    loops : int
        From which they are.
    """

    bias: Array
    missing: Array
    loops: int

    @property
    def covariance(self) -> Array:
        """Of both, (k, k): a bias that is not taken off counts as a deviation."""
        return np.outer(self.bias, self.bias) + self.missing


def steps_error(
    solved: Callable[[float], Solution], quiet: Array, deviations: Array
) -> StepsError | None:
    """Bias and scatter by the encoder's steps; None where they are no matter.

    Parameters
    ----------
    solved : callable
        What the estimator makes of the loops with an encoder whose steps are such a share of one
        away from whole ones.
    quiet : (k,) array
        What it makes of the loops without steps.
    deviations : (k,) array
        Of the estimate.
    """
    first, *others = STEP_SHARES
    found = [solved(first)]
    if np.all(np.abs(found[0].theta - quiet) <= MIN_STEPS_SHIFT.value * deviations):
        return None
    found += [solved(share) for share in others]
    mean = np.mean([solution.theta for solution in found], axis=0)
    return StepsError(bias=mean - quiet, missing=hidden_scatter(found), loops=_LOOPS)


def hidden_scatter(found: Sequence[Solution]) -> Array:
    """Covariance, (k, k), of what estimates of like loops scatter by beside what HAC shows of each.

    Parameters
    ----------
    found : sequence of Solution
        Of loops that are simulated with the same parameters and other errors.
    """
    # As the covariance that this is added to has it, of few scores too.
    shown = np.mean([Hac().matrix(solution) for solution in found], axis=0)
    return beyond_shown(np.array([solution.theta for solution in found]), shown)


def beyond_shown(thetas: Array, shown: Array) -> Array:
    """What estimates (B, k) scatter by beyond a covariance (k, k) that neighbours show of each."""
    scatter, seen = np.var(thetas, axis=0, ddof=1), np.diag(shown)
    ratio = np.divide(scatter, seen, out=np.ones_like(seen), where=seen > 0)
    beyond = np.sqrt(np.maximum(ratio - 1, 0.0))
    return np.asarray(np.outer(beyond, beyond) * shown, dtype=float)
