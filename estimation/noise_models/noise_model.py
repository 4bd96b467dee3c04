"""The noise model of a record, a `Chain`: what its sensors add, and what acts beside the drive."""

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from scipy.fft import next_fast_len

from axisid.estimation.records import Record
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import UsageError, is_real, quoted

#: Of forces that a chain may have, s: first-order autoregressions; 0 is white noise.
CORRELATION_TIMES = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)

#: Of the longest correlation times: what ends meet by, as noise is drawn by its spectrum.
_RUN_IN = 2.0
_FORGOTTEN = 9.0  # correlation times around a circle, after which nothing comes back

#: Correlation times, s, and deviations of independent first-order autoregressions, which add up.
Autoregressions = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class AntitheticDraws:
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
    """The noise of a record, as it was measured in one or is declared for twins, SI.

    Attributes
    ----------
    position_step : float
        Of the encoder; 0 for none.
    anywhere : bool
        Whether a motion begins anywhere in a count of the encoder, drawn for each twin, which
        decides how the loop hunts; else where the experiment has it.
    control_step : float
        Of the logged control, or force where that is logged, beside the loop; 0 for none.
    position : float
        Deviation of white noise of the measured position.
    velocity_step : float
        Of a measured velocity, beside the loop; 0 for none.
    velocity, acceleration : float or None
        Deviations of white noise of a measured velocity and acceleration, beside the loop; None
        where they are not measured.
    jitter : float
        Deviation of the instants at which the position is sampled, s: white.
    is_measured_by_law : bool
        Whether the law has the steps, noise and jitter of the position, or the log alone.
    control : tuple of (float, float)
        Correlation time, s, and deviation, in the drive's unit, of noise that the logged control
        has, beside the loop: independent first-order autoregressions; a time of 0 for white noise.
    disturbances : tuple of (float, float)
        Likewise of what acts beside the control and is not logged.

    Raises
    ------
    UsageError
        One of these is no size of a noise.
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
        for name, value in ((each.name, getattr(self, each.name)) for each in fields(Chain)):
            allowed, form = _is_size(value), "a number of 0 or more"
            if name in _AUTOREGRESSIONS:
                allowed = isinstance(value, tuple) and all(
                    isinstance(each, tuple) and len(each) == 2 and all(map(_is_size, each))
                    for each in value
                )
                form = "pairs of a correlation time and a deviation, as in ((0.05, 0.1),)"
            if not (allowed or name in _FLAGS or (value is None and name in _SENSORS)):
                raise UsageError(
                    f"the {name.replace('_', ' ')} of the noise is {quoted(value)}; give {form}.",
                    code="noise",
                )

    @classmethod
    def of_experiment(cls, axis: Axis) -> "Chain":
        """What an axis's experiment declares: noise of the position and an encoder, if any."""
        experiment = axis.experiment
        if experiment is None:
            return cls()
        return cls(position=experiment.position_noise, position_step=experiment.resolution)

    @property
    def likeliest(self) -> "Chain":
        """As it is told and written: of one that was measured, what that makes the likeliest."""
        return Chain(**{each.name: getattr(self, each.name) for each in fields(Chain)})

    @property
    def is_silent(self) -> bool:
        """Whether a twin with it would be the loop without noise."""
        return not any(getattr(self, each.name) for each in fields(self) if each.name not in _FLAGS)

    @property
    def is_random(self) -> bool:
        """Whether two twins with it differ: steps alone are the same in each."""
        of_chance = ("position", *_SENSORS, "jitter", "anywhere", *_AUTOREGRESSIONS)
        return any(getattr(self, name) for name in of_chance)

    def told(self, unit: str, of_control: str) -> str:
        """In words, by the units of the coordinate and of the drive's control."""
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
            f"{sd:.3g} {of_control} {where}" + (f" over {time:g} s" if time else ", white")
            for each, where in (
                (self.control, "of noise of the recorded control"),
                (self.disturbances, "beside the control"),
            )
            for time, sd in each
        ]
        noise = ", ".join(parts) or "no noise"
        return noise if self.is_measured_by_law else f"{noise}; the law measures another position"

    def drawn_offset(self, rng: AntitheticDraws) -> float:
        """How far from the middle of a count a motion begins."""
        return self.anywhere * self.position_step * rng.of_a_step()

    def drawn_disturbance(self, rng: AntitheticDraws, samples: int, period: float) -> Array:
        """What acts beside the control, (N,), in the drive's unit."""
        return _drawn(self.disturbances, rng, samples, period)

    def logged_control(self, rng: AntitheticDraws, control: Array, period: float) -> Array:
        """A control, or force, as the log has it, (N,)."""
        if self.control:
            control = control + _drawn(self.control, rng, len(control), period)
        return _rounded(control, self.control_step, rng)

    def logged(
        self, record: Record, rng: AntitheticDraws, of_control: AntitheticDraws
    ) -> dict[str, Array]:
        """Columns of a record as sensors and drive log them, where these have noise or steps.

        Parameters
        ----------
        record : Record
            Its position is measured already, as the law may measure it.
        rng, of_control : AntitheticDraws
            Of velocity and acceleration, and of the control or force.
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
    """The noise of a record, as surely as it was measured.

    Attributes
    ----------
    drawn : tuple of Autoregressions
        What the disturbances may be as well, of which each twin has one.
    """

    drawn: tuple[Autoregressions, ...] = ()

    def drawn_disturbance(self, rng: AntitheticDraws, samples: int, period: float) -> Array:
        """See `Chain.drawn_disturbance`."""
        # The same of the opposite numbers.
        chosen = self.drawn[rng.rng.integers(len(self.drawn))] if self.drawn else self.disturbances
        return _drawn(chosen, rng, samples, period)


_SENSORS = ("velocity", "acceleration")
_AUTOREGRESSIONS = ("control", "disturbances")
_FLAGS = ("anywhere", "is_measured_by_law")


def _is_size(value: object) -> bool:
    return is_real(value) and 0 <= value < math.inf


def _rounded(values: Array, step: float, rng: AntitheticDraws) -> Array:
    """Values in steps, which begin anywhere; as they are without."""
    if not step:
        return values
    offset = rng.of_a_step()
    return np.asarray((np.round(values / step + offset) - offset) * step)


def _drawn(parts: Autoregressions, rng: AntitheticDraws, samples: int, period: float) -> Array:
    """A sum of autoregressions, (N,)."""
    longest = max((time for time, _ in parts), default=0.0)
    run_in = min(samples, int(np.ceil(_RUN_IN * longest / period)))
    m = next_fast_len(samples + run_in, real=True)
    noise = rng.normal(m)
    if not longest:
        return math.hypot(*(sd for _, sd in parts)) * noise[:samples]
    return np.fft.irfft(np.fft.rfft(noise) * _response(parts, period, m), m)[:samples]


@lru_cache(maxsize=32)
def _response(parts: Autoregressions, period: float, samples: int) -> Array:
    """What makes white noise of these autoregressions, by frequency."""
    power = np.zeros(samples // 2 + 1)
    for time, deviation in parts:
        if samples > _FORGOTTEN * (time / period):
            power += deviation**2 * spectrum(time / period, samples)
            continue
        # One that lasts by circulant embedding: its covariance declines either way around.
        lags = np.minimum(np.arange(samples), samples - np.arange(samples))
        covariance = np.exp(-lags / (time / period))
        power += deviation**2 * np.maximum(np.fft.rfft(covariance).real, 0.0)
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
