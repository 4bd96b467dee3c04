"""The noise model of a record, a `Chain`: sensor noise, quantisation and disturbance forces."""

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from scipy.fft import next_fast_len

from axisid.estimation.records import Record
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.checks import is_real
from axisid.support.errors import UsageError
from axisid.support.wording import quoted

#: Candidate correlation times of disturbances, s: first-order autoregressions; 0 is white noise.
CORRELATION_TIMES = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)

#: Additional length in longest correlation times, as noise drawn by its spectrum is periodic.
_RUN_IN = 2.0
_FORGOTTEN = 9.0  # correlation times per period, beyond which wrap-around is negligible

#: Correlation time, s, and standard deviation of each of independent first-order autoregressions,
#: which are added.
Autoregressions = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class AntitheticDraws:
    """Random numbers of a generator, or the same numbers with the opposite sign.

    Attributes
    ----------
    rng : numpy.random.Generator
        Generator of the numbers.
    sign : float
        1, or -1 for numbers with the opposite sign.
    """

    rng: np.random.Generator
    sign: float = 1.0

    def normal(self, size: int) -> Array:
        """Return standard normal numbers, (size,)."""
        return self.sign * self.rng.standard_normal(size)

    def of_a_step(self) -> float:
        """Return a uniform offset between -0.5 and 0.5 of a quantisation step."""
        return self.sign * float(self.rng.uniform(-0.5, 0.5))


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """The noise of a record, estimated from the record or declared for twins, SI.

    Attributes
    ----------
    position_step : float
        Quantisation step of the encoder; 0 for none.
    anywhere : bool
        True if a motion begins at a random place within an encoder step, drawn for each replica,
        which determines the limit cycle of the loop; False if it begins as in the experiment.
    control_step : float
        Quantisation step of the logged control, or of the force where that is logged, outside the
        loop; 0 for none.
    position : float
        Standard deviation of white noise of the measured position.
    velocity_step : float
        Quantisation step of a measured velocity, outside the loop; 0 for none.
    velocity, acceleration : float or None
        Standard deviations of white noise of a measured velocity and acceleration, outside the
        loop; None where they are not measured.
    jitter : float
        Standard deviation of the sampling instants of the position, s; white.
    is_measured_by_law : bool
        True if the control law reads the position with its steps, noise and jitter; False if only
        the log has them.
    control : tuple of (float, float)
        Correlation time, s, and standard deviation, in the drive's unit, of noise of the logged
        control, outside the loop: independent first-order autoregressions; 0 s for white noise.
    disturbances : tuple of (float, float)
        Correlation time, s, and standard deviation, in the drive's unit, of disturbances that add
        to the control and are not logged.

    Raises
    ------
    UsageError
        A value is negative, not finite or no number.
    """

    position_step: float = 0.0
    anywhere: bool = False
    control_step: float = 0.0
    position: float = 0.0
    velocity_step: float = 0.0
    velocity: float | None = None
    acceleration: float | None = None
    jitter: float = 0.0
    is_measured_by_law: bool = True
    control: Autoregressions = ()
    disturbances: Autoregressions = ()

    def __post_init__(self) -> None:
        for name in [each.name for each in fields(Chain)]:
            value = getattr(self, name)
            allowed, expected = _is_size(value), "a number of 0 or more"
            if name in _AUTOREGRESSIONS:
                allowed = isinstance(value, tuple) and all(
                    isinstance(each, tuple) and len(each) == 2 and all(map(_is_size, each))
                    for each in value
                )
                expected = (
                    "pairs of a correlation time and a standard deviation, as in ((0.05, 0.1),)"
                )
            if not (allowed or name in _FLAGS or (value is None and name in _SENSORS)):
                raise UsageError(
                    f"the {name.replace('_', ' ')} of the noise is {quoted(value)}. Give "
                    f"{expected}.",
                    code="noise",
                )

    @classmethod
    def of_experiment(cls, axis: Axis) -> "Chain":
        """Return the position noise and encoder step that an axis's experiment declares."""
        experiment = axis.experiment
        if experiment is None:
            return cls()
        return cls(position=experiment.position_noise, position_step=experiment.resolution)

    @property
    def likeliest(self) -> "Chain":
        """The noise with its most likely values only, as it is reported and written to files."""
        return Chain(**{each.name: getattr(self, each.name) for each in fields(Chain)})

    @property
    def is_silent(self) -> bool:
        """True if the chain has no noise and no quantisation."""
        return not any(getattr(self, each.name) for each in fields(self) if each.name not in _FLAGS)

    @property
    def is_random(self) -> bool:
        """True if two replicas with this chain differ, which needs more than quantisation steps."""
        of_chance = ("position", *_SENSORS, "jitter", "anywhere", *_AUTOREGRESSIONS)
        return any(getattr(self, name) for name in of_chance)

    def drawn_offset(self, rng: AntitheticDraws) -> float:
        """Return a random distance of the first position from the middle of an encoder step, SI.

        It is 0 if motions do not begin at a random place.
        """
        return self.anywhere * self.position_step * rng.of_a_step()

    def drawn_disturbance(self, rng: AntitheticDraws, samples: int, period: float) -> Array:
        """Return a random disturbance that adds to the control, (N,), in the drive's unit.

        `samples` is N, `period` the sampling period, s.
        """
        return _drawn(self.disturbances, rng, samples, period)

    def logged_control(self, rng: AntitheticDraws, control: Array, period: float) -> Array:
        """Return a control or force, (N,), with the noise and quantisation of the log.

        Both use random numbers `rng`: quantisation rounds on a grid with a random offset, so that
        the rounding errors of replicas differ. `period` is the sampling period, s.
        """
        if self.control:
            control = control + _drawn(self.control, rng, len(control), period)
        return _rounded(control, self.control_step, rng)

    def logged(
        self, record: Record, rng: AntitheticDraws, of_control: AntitheticDraws
    ) -> dict[str, Array]:
        """Return the columns of a record with sensor noise and quantisation, by role.

        Parameters
        ----------
        record : Record
            Its position has its noise already, as the law may read that.
        rng, of_control : AntitheticDraws
            Random numbers for velocity and acceleration, and for the control or force.
        """
        columns: dict[str, Array] = {}
        if record.velocity is not None:
            noise = (self.velocity or 0.0) * rng.normal(len(record))
            columns["velocity"] = _rounded(record.velocity + noise, self.velocity_step, rng)
        if record.acceleration is not None:
            noise = (self.acceleration or 0.0) * rng.normal(len(record))
            columns["acceleration"] = record.acceleration + noise
        if self.control or self.control_step:
            role = "control" if record.force is None else "force"
            columns[role] = self.logged_control(of_control, getattr(record, role), record.period)
        return columns


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredChain(Chain):
    """The noise of a record with the uncertainty of its disturbances.

    Attributes
    ----------
    drawn : tuple of Autoregressions
        Alternative estimates of the disturbances; each replica uses one of them at random.
    """

    drawn: tuple[Autoregressions, ...] = ()

    def drawn_disturbance(self, rng: AntitheticDraws, samples: int, period: float) -> Array:
        """Return a random disturbance that adds to the control, (N,), in the drive's unit.

        It is drawn from one of the alternative estimates, or from `disturbances` without any.
        `samples` is N, `period` the sampling period, s.
        """
        chosen = self.disturbances
        if self.drawn:  # replicas of opposite noise choose the same alternative
            chosen = self.drawn[rng.rng.integers(len(self.drawn))]
        return _drawn(chosen, rng, samples, period)


_SENSORS = ("velocity", "acceleration")
_AUTOREGRESSIONS = ("control", "disturbances")
_FLAGS = ("anywhere", "is_measured_by_law")


def _is_size(value: object) -> bool:
    """Return True for a finite number of 0 or more."""
    return is_real(value) and 0 <= value < math.inf


def _rounded(values: Array, step: float, rng: AntitheticDraws) -> Array:
    """Return values rounded to a step on a grid of random offset; unchanged for a step of 0."""
    if not step:
        return values
    offset = rng.of_a_step()
    return np.asarray((np.round(values / step + offset) - offset) * step)


def _drawn(parts: Autoregressions, rng: AntitheticDraws, samples: int, period: float) -> Array:
    """Return a random sum of autoregressions, (N,), for N samples with a period in s.

    White noise is multiplied by the root of the power spectrum of the sum. As this makes a periodic
    signal, more samples than needed are drawn, and the first N are returned.
    """
    longest = max((time for time, _ in parts), default=0.0)
    run_in = min(samples, int(np.ceil(_RUN_IN * longest / period)))
    m = next_fast_len(samples + run_in, real=True)
    noise = rng.normal(m)
    if not longest:
        return math.hypot(*(sd for _, sd in parts)) * noise[:samples]
    return np.fft.irfft(np.fft.rfft(noise) * _response(parts, period, m), m)[:samples]


@lru_cache(maxsize=32)
def _response(parts: Autoregressions, period: float, samples: int) -> Array:
    """Return the amplitude by frequency that turns white noise into a sum of autoregressions.

    The spectrum of a short autoregression is given by `spectrum`; that of a long one, which does
    not fade within the samples, by its covariance. The shape is (samples // 2 + 1,); `period` is
    the sampling period, s.
    """
    power = np.zeros(samples // 2 + 1)
    for time, deviation in parts:
        if samples > _FORGOTTEN * (time / period):
            power += deviation**2 * spectrum(time / period, samples)
            continue
        # A long one by circulant embedding: its covariance declines in both directions.
        lags = np.minimum(np.arange(samples), samples - np.arange(samples))
        covariance = np.exp(-lags / (time / period))
        power += deviation**2 * np.maximum(np.fft.rfft(covariance).real, 0.0)
    return np.sqrt(power)


def spectrum(time: float, samples: int, apart: float = 1.0) -> Array:
    """Return the power of a first-order autoregression of variance 1, (samples // 2 + 1,).

    ``(1 - a^2) / |1 - a exp(-i w)|^2`` with ``a = exp(-1/time)``.

    Parameters
    ----------
    time : float
        Correlation time in samples; 0 for white noise.
    samples : int
        Length whose discrete frequencies are returned.
    apart : float
        Decimation factor: the frequencies are those of rows that are this many samples apart.
    """
    pole = np.exp(-1 / time) if time else 0.0
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(samples) / apart)
    return np.asarray((1 - pole**2) / np.abs(1 - pole * turn) ** 2, dtype=float)
