"""What noise the twins have: in the loop, beside it, and in what the record has of the control."""

import math
from dataclasses import dataclass

import numpy as np

from axisid.estimation.simulation import TwinPlan
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_real
from axisid.support.user_values import quoted

_POSITION, _SENSORS, _CONTROL, _DISTURBANCE, _PHASE = range(5)  # each a stream of its own


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinNoise:
    """The noise of twins, drawn anew for each.

    Attributes
    ----------
    position : float or None
        Deviation of the white noise of the measured position, which the law sees, in the
        coordinate's unit; the experiment's by default.
    resolution : float or None
        Of the encoder, in the coordinate's unit, 0 for none; the experiment's by default.
    anywhere : bool
        Whether the motion begins anywhere in a count of the encoder, which decides how the loop
        hunts; else where the experiment has it.
    velocity, acceleration : float or None
        Deviation of a velocity and of an acceleration that are measured beside the loop; None for
        no such sensor.
    control : float
        Deviation of what the record adds to the control, in the drive's unit.
    disturbance : float
        Deviation of what acts beside the control and is not in the record, in the drive's unit.
    correlation_time : float
        Of the last two, s, first-order autoregressive; 0 for white noise.
    """

    position: float | None = None
    resolution: float | None = None
    anywhere: bool = False
    velocity: float | None = None
    acceleration: float | None = None
    control: float = 0.0
    disturbance: float = 0.0
    correlation_time: float = 0.0

    def __post_init__(self) -> None:
        for name in _FIGURES:
            value = getattr(self, name)
            if value is None and name in _MAY_BE_NONE:
                continue
            if not (is_real(value) and 0 <= value < math.inf):
                raise UsageError(
                    f"the {name.replace('_', ' ')} of the twins' noise is {quoted(value)}; give a "
                    "number of 0 or more.",
                    code="twin-noise",
                )
        if self.correlation_time and not (self.control or self.disturbance):
            raise UsageError(
                "the twins' noise has a correlation time, and neither control nor disturbance that "
                "it is of; give one of them, or leave it out.",
                code="twin-noise-of-nothing",
            )


_MAY_BE_NONE = ("position", "resolution", "velocity", "acceleration")
_FIGURES = (*_MAY_BE_NONE, "control", "disturbance", "correlation_time")


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnNoise:
    """The noise of one twin, whatever others there are.

    Attributes
    ----------
    noise : TwinNoise
    plan : TwinPlan
    seed : int
    run : int
        The number of the twin.
    """

    noise: TwinNoise
    plan: TwinPlan
    seed: int
    run: int

    def generator(self, stream: int) -> np.random.Generator:
        """The random numbers of a stream: a child of the seed for each run, whoever runs it."""
        child = np.random.SeedSequence(self.seed, spawn_key=(self.run, stream))
        return np.random.default_rng(child)

    def position(self, samples: int) -> Array:
        """Of the measured position, (samples,)."""
        own = self.noise.position
        deviation = self.plan.experiment.position_noise if own is None else own
        return self.generator(_POSITION).normal(0.0, deviation, samples)

    @property
    def sensors(self) -> np.random.Generator:
        """Of velocity and acceleration."""
        return self.generator(_SENSORS)

    @property
    def control(self) -> Array | None:
        """What the record adds to the control, (N,)."""
        return self._correlated(_CONTROL, self.noise.control)

    @property
    def disturbance(self) -> Array | None:
        """What acts beside the control, (N,)."""
        return self._correlated(_DISTURBANCE, self.noise.disturbance)

    @property
    def phase(self) -> float:
        """Where in a count the motion begins, in the coordinate's unit."""
        if not self.noise.anywhere:
            return 0.0
        return float(self.generator(_PHASE).uniform(0.0, resolution_of(self.noise, self.plan)))

    def _correlated(self, stream: int, deviation: float) -> Array | None:
        if not deviation:
            return None
        rng, samples = self.generator(stream), len(self.plan.reference)
        time = self.noise.correlation_time
        if not time:
            return rng.normal(0.0, deviation, samples)
        from scipy.signal import lfilter

        log_pole = -self.plan.period / time
        pole = math.exp(log_pole)
        driven = rng.normal(0.0, deviation * math.sqrt(-math.expm1(2 * log_pole)), samples)
        before = rng.normal(0.0, deviation)  # the sample before the first, of the stationary law
        noise, _ = lfilter([1.0], [1.0, -pole], driven, zi=[pole * before])
        return np.asarray(noise, dtype=float)


def resolution_of(noise: TwinNoise, plan: TwinPlan) -> float:
    """Of the twins' encoder, in the coordinate's unit; 0 for none."""
    return plan.experiment.resolution if noise.resolution is None else noise.resolution
