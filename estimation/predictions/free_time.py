"""A lag or a delay of the drive that is searched for with the parameters of the model.

A loop is generated for one lag and one delay. About these its output is a straight line of either:
a delay takes from a command its way of that time, ``-du/dt``, and a lag that of what it has made of
the command, so that the slope is that by such an added control. Where a search ends, the loop is
generated anew, until it is there.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.records import Record
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .added_slopes import Motion
from .lanes import LANE_LOST, Lanes, Predictions


class TimedPredictions:
    """Predictions about the time that their loops were generated for.

    Parameters
    ----------
    of_model : Predictions
        Of the parameters before the last one, which is the time.
    time : float
        Of the generated loops, s.
    name : str
        ``lag`` or ``delay``.
    """

    def __init__(self, of_model: Predictions, time: float, name: str) -> None:
        self._of_model, self._time = of_model, time
        self._lag = time if name == "lag" else 0.0
        self._slope: Array | None = None
        self.spans, self.samples = of_model.spans, of_model.samples
        self.units, self.step = of_model.units, of_model.step
        self.measured, self.counted = of_model.measured, of_model.counted

    def settle(self, physical: Array) -> None:
        """See `Predictions.settle`; the slope by the time is that of the first parameters."""
        self._of_model.settle(physical[:-1])
        if self._slope is None:
            self._slope = _slope_by_time(self._of_model, physical[:-1], self._lag)

    def __call__(self, physical: Array) -> Lanes:
        """See `Predictions.__call__`."""
        if self._slope is None:
            self.settle(physical[0])
        found = self._of_model(physical[:, :-1])
        moved = np.outer(np.asarray(self._slope), physical[:, -1] - self._time)
        return Lanes(errors=found.errors + moved, failures=found.failures)

    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """See `Predictions.outputs_of`."""
        return self._of_model.outputs_of(records, physical[:-1])

    def by_noise(
        self, physical: Array, count: int, random: np.random.Generator, factor: float = 1.0
    ) -> Array:
        """See `Predictions.by_noise`."""
        return self._of_model.by_noise(physical[:-1], count, random, factor)

    def slopes_by_start(self, physical: Array) -> tuple[tuple[slice, Array], ...]:
        """See `Predictions.slopes_by_start`."""
        return self._of_model.slopes_by_start(physical[:-1])

    def slopes_by_law(self, physical: Array) -> Mapping[str, Array]:
        """See `Predictions.slopes_by_law`."""
        return self._of_model.slopes_by_law(physical[:-1])

    def motions(self, physical: Array) -> tuple[Motion, ...] | None:
        """See `Predictions.motions`."""
        return self._of_model.motions(physical[:-1])

    def slopes_by_added(self, physical: Array, added: Sequence[Array]) -> Array | None:
        """See `Predictions.slopes_by_added`."""
        return self._of_model.slopes_by_added(physical[:-1], added)


def _slope_by_time(predictions: Predictions, physical: Array, lag: float) -> Array:
    """Slope of the errors by a time of the drive, (n,); by its lag where one is given."""
    slopes = None
    motions = predictions.motions(physical)
    if motions is not None:
        slopes = predictions.slopes_by_added(physical, [-_way(m, lag)[:, None] for m in motions])
    if motions is None or slopes is None or not np.all(np.isfinite(slopes)):
        raise EstimationError(
            "the loop cannot be simulated about the drive's time, which is to be found.",
            code=LANE_LOST,
        )
    width = len(predictions.units)
    periods = [np.full(width * len(m.time), _period(m)) for m in motions]
    return np.asarray(slopes[:, 0] / np.concatenate(periods))


def _period(motion: Motion) -> float:
    return float(motion.time[1] - motion.time[0])


def _way(motion: Motion, lag: float) -> Array:
    """By how much a command changes in each sample behind a lag, (N,)."""
    way = np.diff(motion.control, prepend=motion.control[0])
    if not lag:
        return way
    from scipy.signal import lfilter

    stays = math.exp(-_period(motion) / lag)
    return np.asarray(lfilter([1 - stays], [1, -stays], way))
