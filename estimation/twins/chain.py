"""The chain: what stands between a motion and its log, and what acts beside the drive."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import next_fast_len

from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array

#: Of forces that a chain may have, s: first-order autoregressions; 0 is white noise.
CORRELATION_TIMES = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)

_RUN_IN = (
    2.0  # of the longest correlation times: what ends meet by, as noise is drawn by its spectrum
)


@dataclass(frozen=True, slots=True)
class Draws:
    """Random numbers, or their opposite.

    Attributes
    ----------
    rng : numpy.random.Generator
    sign : float
    """

    rng: np.random.Generator
    sign: float = 1.0

    def normal(self, size: int) -> Array:
        """Standard normal, (size,)."""
        return self.sign * self.rng.standard_normal(size)

    def of_a_step(self) -> float:
        """Uniform, where a step begins as a share of one."""
        return self.sign * float(self.rng.uniform(-0.5, 0.5))


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """The noise of one record, SI.

    Attributes
    ----------
    position_step : float
        Of the encoder; 0 for none.
    control_step : float
        Of the logged control, or force where that is logged, beside the loop; 0 for none.
    position : float
        Deviation of white noise of the measured position.
    velocity_step, velocity, acceleration : float
        Steps, and deviations of white noise, of a measured velocity and acceleration, beside the
        loop.
    jitter : float
        Deviation of the instants at which the position is sampled, s: white.
    is_measured_by_law : bool
        Whether the law has the steps, noise and jitter of the position, or the log alone.
    disturbances : tuple of (float, float)
        Correlation time, s, and deviation, in the drive's unit, of what acts beside the control:
        independent first-order autoregressions.
    """

    position_step: float = 0.0
    control_step: float = 0.0
    position: float = 0.0
    velocity_step: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    jitter: float = 0.0
    is_measured_by_law: bool = True
    disturbances: tuple[tuple[float, float], ...] = ()

    @property
    def is_silent(self) -> bool:
        """Whether a twin with it would be the loop without noise."""
        return self == Chain(is_measured_by_law=self.is_measured_by_law)

    @property
    def is_uneven(self) -> bool:
        """Whether noise of the position is of no one colour: steps, or in proportion to speed."""
        return self.position_step > 0 or self.jitter > 0

    def told(self, axis: Axis) -> str:
        """In words, as the noise of an axis's record."""
        unit, of_control = axis.coordinate.unit, axis.drive.unit
        parts = [
            f"{value:.3g} {of} {what}"
            for value, of, what in (
                (self.position_step, unit, "steps of the position"),
                (self.position, unit, "white noise of the position"),
                (self.velocity_step, f"{unit}/s", "steps of the velocity"),
                (self.velocity, f"{unit}/s", "white noise of the velocity"),
                (self.acceleration, f"{unit}/s^2", "white noise of the acceleration"),
                (self.jitter, "s", "jitter of the sampling"),
                (self.control_step, "SI", "steps of the recorded control or force"),
            )
            if value
        ]
        parts += [
            f"{sd:.3g} {of_control} beside the control"
            + (f" over {time:g} s" if time else ", white")
            for time, sd in self.disturbances
        ]
        told = ", ".join(parts) or "no noise"
        return told if self.is_measured_by_law else f"{told}; the law measures another position"

    def drawn_position(self, rng: Draws, samples: int) -> Array:
        """White noise of the position, (N,)."""
        return self.position * rng.normal(samples)

    def drawn_disturbance(self, rng: Draws, samples: int, period: float) -> Array:
        """What acts beside the control, (N,), in the drive's unit."""
        longest = max((time for time, _ in self.disturbances), default=0.0)
        m = next_fast_len(samples + int(np.ceil(_RUN_IN * longest / period)), real=True)
        noise = np.fft.rfft(rng.normal(m))
        return np.fft.irfft(noise * _response(self.disturbances, period, m), m)[:samples]


@lru_cache(maxsize=4)
def _response(disturbances: tuple[tuple[float, float], ...], period: float, samples: int) -> Array:
    """What makes white noise of these disturbances, by frequency."""
    power = np.zeros(samples // 2 + 1)
    for time, deviation in disturbances:
        power += deviation**2 * spectrum(time / period, samples)
    return np.sqrt(power)


def spectrum(time: float, samples: int, apart: float = 1.0) -> Array:
    """Power of a first-order autoregression of variance 1, (samples // 2 + 1,).

    Parameters
    ----------
    time : float
        Its correlation time, in samples.
    samples : int
        Over which frequencies are.
    apart : float
        Of what is looked at each so many samples, up to the frequencies that are left.
    """
    pole = np.exp(-1 / time) if time else 0.0
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(samples) / apart)
    return np.asarray((1 - pole**2) / np.abs(1 - pole * turn) ** 2, dtype=float)
