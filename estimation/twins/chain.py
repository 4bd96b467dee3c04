"""The chain: what stands between a motion and its log, and what acts beside the drive."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array

#: Of forces that a chain may have, s: first-order autoregressions; 0 is white noise.
CORRELATION_TIMES = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)

_RUN_IN = (
    2.0  # of the longest correlation times: what ends meet by, as noise is drawn by its spectrum
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """The noise of one record, SI.

    Attributes
    ----------
    position_step : float
        Of the encoder, in the loop; 0 for none.
    control_step : float
        Of the logged control, beside the loop, in the drive's unit; 0 for none.
    position : float
        Deviation of white noise of the measured position, in the loop.
    jitter : float
        Deviation of the instants at which the loop is sampled, s: white.
    beside : tuple of (str, float, float)
        Role, step and deviation of white noise of what else is measured of the motion, which the
        law does not see.
    disturbances : tuple of (float, float)
        Correlation time, s, and deviation, in the drive's unit, of what acts beside the control:
        independent first-order autoregressions.
    """

    position_step: float = 0.0
    control_step: float = 0.0
    position: float = 0.0
    jitter: float = 0.0
    beside: tuple[tuple[str, float, float], ...] = ()
    disturbances: tuple[tuple[float, float], ...] = ()

    @property
    def is_silent(self) -> bool:
        """Whether a twin with it would be the loop without noise."""
        return self == Chain()

    def told(self, axis: Axis) -> str:
        """In words, as the noise of an axis's record."""
        unit, of_control = axis.coordinate.unit, axis.drive.unit
        parts = [
            f"{value:.3g} {of} {what}"
            for value, of, what in (
                (self.position_step, unit, "steps of the position"),
                (self.position, unit, "white noise of the position"),
                (self.jitter, "s", "jitter of the sampling"),
                (self.control_step, of_control, "steps of the control"),
            )
            if value
        ]
        parts += [
            f"{value:.3g} (SI) {what} of the {role}"
            for role, step, sd in self.beside
            for value, what in ((step, "steps"), (sd, "white noise"))
            if value
        ]
        parts += [
            f"{sd:.3g} {of_control} beside the control"
            + (f" over {time:g} s" if time else ", white")
            for time, sd in self.disturbances
        ]
        return ", ".join(parts) or "no noise"

    def drawn_beside(
        self, rng: np.random.Generator, columns: Mapping[str, Array]
    ) -> dict[str, Array]:
        """Columns of a motion by role as they are measured beside the loop, (N,) each."""
        made = {}
        for role, step, deviation in self.beside:
            noisy = columns[role] + deviation * rng.standard_normal(len(columns[role]))
            share = rng.uniform(-0.5, 0.5)
            made[role] = (np.round(noisy / step + share) - share) * step if step else noisy
        return made

    def drawn_position(self, rng: np.random.Generator, samples: int) -> Array:
        """White noise of the position, (N,)."""
        return self.position * rng.standard_normal(samples)

    def drawn_disturbance(self, rng: np.random.Generator, samples: int, period: float) -> Array:
        """What acts beside the control, (N,), in the drive's unit."""
        longest = max((time for time, _ in self.disturbances), default=0.0)
        m = samples + int(np.ceil(_RUN_IN * longest / period))
        noise = np.fft.rfft(rng.standard_normal(m))
        power = sum(
            (sd**2 * spectrum(time / period, m) for time, sd in self.disturbances),
            start=np.zeros(len(noise)),
        )
        return np.fft.irfft(noise * np.sqrt(power), m)[:samples]


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
