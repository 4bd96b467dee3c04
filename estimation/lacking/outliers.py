"""Single samples of a signal that leave its course: what such a pulse makes of the rows."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import stdtr

from axisid.support.arrays import Array

from .hypotheses import Hypothesis
from .scores import RecordScores

_PULSE = 1e-4  # of a signal's size: so small that it moves no sign
_PLACES = 5  # from one row to the next but one


def outliers_of(scores: RecordScores) -> list[Hypothesis]:
    """A pulse in each signal that was measured, about the row of which most is left.

    None without twins: the variance by HAC is that of the very samples.
    """
    if not scores.twins:
        return []
    data = scores.data
    rows = data.row_numbers.astype(np.int64)
    left = np.abs(scores.nets)
    worst, chance = int(np.argmax(left[:, 0])), _chance(left.max(axis=0))
    width = data.prefilter.decimate
    near = np.round(np.linspace(-width, width, _PLACES if width > 1 else 3))
    places = np.clip(rows[worst] + near, 0, len(data.record) - 1)
    pulses = _Pulses(scores)
    return [
        Hypothesis(
            kind="outlier",
            parameter=role,
            columns=partial(pulses.columns, role),
            places=np.unique(places),
            least=chance,
            between=_every_sample,
        )
        for role in ("position", "velocity", "acceleration", "force", "control")
        if role in pulses.signals
    ]


def _chance(largest: Array) -> float:
    """That noise leaves as much in the row of which most is left: by twins', log-normal."""
    sizes = np.log(np.maximum(largest, np.finfo(float).tiny))
    own, twins = sizes[0], sizes[1:]
    spread = float(np.std(twins, ddof=1)) * math.sqrt(1 + 1 / len(twins))
    beyond = (own - twins.mean()) / spread if spread else np.inf
    return float(stdtr(len(twins) - 1, -beyond))


def _every_sample(grid: Array, at: float) -> Array:
    step = int(np.diff(grid).max(initial=0)) // 2
    return np.asarray(np.clip(np.arange(at - step, at + step + 1), grid[0], grid[-1]))


class _Pulses:
    """What is left of rows by a pulse of one in one sample of a signal."""

    def __init__(self, scores: RecordScores) -> None:
        self._scores = scores
        record = scores.data.record
        every = record.channels()
        hidden = {"control"} if record.force is not None else set()
        self.signals = {role: v for role, v in every.items() if role not in hidden}
        self._left = self._of({})

    def columns(self, role: str, samples: Array) -> Array:
        """Of each sample, (n, m, 1)."""
        return np.stack([self._by(role, int(sample)) for sample in samples], axis=1)[:, :, None]

    def _by(self, role: str, sample: int) -> Array:
        values = self.signals[role].copy()
        pulse = _PULSE * (float(np.std(values)) or 1.0)
        values[sample] += pulse
        return np.asarray((self._of({role: values}) - self._left) / pulse)

    def _of(self, changed: dict[str, Array]) -> Array:
        """Residuals, (n,), of a record with other values."""
        scores = self._scores
        data = replace(scores.data, record=scores.data.record.with_motion(changed))
        rows = scores.form.equations(data.signals).reduced(data)
        left = rows.left - rows.intercept - rows.regressor @ scores.physical
        return np.asarray(left, dtype=float)
