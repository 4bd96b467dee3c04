"""What of the errors of outputs is noise."""

import numpy as np

from axisid.estimation.predictions import Predictions, record_rows, whole_lanes
from axisid.support.arrays import Array

from .missing import Left

_TWINS, _SEED = 8, 0


def noise_left(predictions: Predictions, physical: Array, left: Left) -> tuple[float, ...]:
    """Root mean square of what is noise in what is left, by record and output, in its unit.

    What errors of the measured position make in the loop, or what nothing before it tells of an
    error: the more of both.

    Parameters
    ----------
    predictions : Predictions
    physical : (P,) array
        The estimate.
    left : Left
    """
    twins = left.twins
    if twins is None:
        with np.errstate(all="ignore"):
            noise = predictions.by_noise(physical, _TWINS, np.random.default_rng(_SEED))
        twins = left.weights[:, None] * whole_lanes(noise)
    models, found = left.autoregressions(left.errors), []
    for model, spans in zip(models, left.spans, strict=True):
        for place, variance in enumerate(model.innovations):
            rows = record_rows(spans, place, left.outputs)
            used = left.counted[rows]
            weight = float(left.weights[rows][used].max(initial=0.0)) or 1.0
            own = np.sqrt(max(variance, 0.0)), _size(twins[rows][used])
            found.append(float(max(own)) / weight)
    return tuple(found)


def _size(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0
