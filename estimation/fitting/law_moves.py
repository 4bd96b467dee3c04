"""What a control law that is not the drive's moves an output-error estimate by.

The simulated loop answers to a law that is a little other as to what that adds to its control: each
term of the law with a factor of ``1 + eps`` is the loop with ``eps`` times that term injected. So
two lanes a term tell the slopes of the outputs, and with them what every percent of a term moves
each parameter by.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.predictions import Predictions
from axisid.support.arrays import Array
from axisid.support.missing import Missing

_PERCENT = 0.01


def moves_per_percent(
    predictions: Predictions, physical: Array, influence: Array
) -> Mapping[str, Array]:
    """What each term of the law, 1 % larger, moves the parameters by, (P,), by its gains.

    Parameters
    ----------
    predictions : Predictions
    physical : (P,) array
        The estimate.
    influence : (P, n) array
        Of the errors on the estimate.
    """
    slopes = predictions.slopes_by_law(physical)
    return {name: -_PERCENT * (influence @ slope) for name, slope in slopes.items()}


def move_by_record(moves: Mapping[str, Array], laws: Sequence[LawCheck | Missing]) -> Array | None:
    """What the law as the records have it, less the declared one, moves the parameters by, (P,).

    Returns
    -------
    (P,) array or None
        None where no record tells the law's factors.
    """
    told = [law.factors for law in laws if isinstance(law, LawCheck)]
    told = [factors for factors in told if all(name in factors for name in moves)]
    if not told or not moves:
        return None
    factors = {name: float(np.mean([each[name] for each in told])) for name in moves}
    moved = [move * (factors[name] - 1) / _PERCENT for name, move in moves.items()]
    return np.asarray(np.sum(moved, axis=0))


def first_failing(laws: Sequence[LawCheck | Missing]) -> LawCheck | Missing:
    """The first law that fails its record, else that of the first record."""
    failing = (law for law in laws if isinstance(law, LawCheck) and not law.passed)
    return next(failing, laws[0])
