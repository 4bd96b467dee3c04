"""Forces, and other values of what is held, that outputs ask for beside a model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.lacking import PLAIN
from axisid.estimation.predictions import Predictions, slopes_of
from axisid.estimation.thresholds.fitting import (
    FEWEST_WINDOWS,
    LACKING_LEVEL,
    MIN_OWN_SLOPE,
    MIN_OWN_SLOPE_OF_PLAIN,
)
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

from .missing import Asking, Lacking, Left, lacking_of
from .motion_terms import Force, forces_of

_MOST = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldParameters:
    """What of the parameters is held, is at a bound or was known before, (P,) each.

    Attributes
    ----------
    names : tuple of str
    units : tuple of str
    than : tuple of str
        By what each is held, in words; empty for one that is not.
    lower, upper : array
        Bounds of all.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    than: tuple[str, ...]
    lower: Array
    upper: Array

    @property
    def which(self) -> NDArray[np.bool_]:
        """Those of them, (P,)."""
        return np.array([bool(each) for each in self.than])


@dataclass(frozen=True, slots=True, kw_only=True)
class Lack:
    """What the errors of outputs ask for beside a model.

    Attributes
    ----------
    subject : str
        In words.
    size, deviation : float
        A force: of its root mean square by that of the control, %. What is held: by how much it
        would be more, in its unit.
    unit : str
    chance : float
        That noise asks for as much of the strongest of all that was looked for.
    tests : int
        How many were.
    """

    subject: str
    size: float
    deviation: float
    unit: str
    chance: float
    tests: int

    @property
    def told_of(self) -> str:
        """Unit of its size, in words."""
        return "% of the control" if self.unit == "%" else self.unit

    @property
    def is_there(self) -> bool:
        """Whether it is more than chance."""
        return self.chance <= LACKING_LEVEL.value


def lacks_beside(
    axis: Axis, predictions: Predictions, physical: Array, left: Left, held: HeldParameters
) -> tuple[Lack, ...] | Missing:
    """What is asked for, the strongest first; that one whether it is there or not.

    What the axis declares is no force that it may lack, whatever holds its parameter: that is asked
    for by the parameter's name.

    Parameters
    ----------
    axis : Axis
    predictions : Predictions
    physical : (P,) array
        The estimate.
    left : Left
    held : HeldParameters
    """
    windows = sum(map(len, left.spans))
    if left.by_windows and windows < left.jacobian.shape[1] + FEWEST_WINDOWS.value:
        few = "1 window is" if windows == 1 else f"{windows} windows are"
        return Missing(f"{few} too few to tell chance from what the model lacks")
    with np.errstate(all="ignore"):
        forces = forces_of(axis, predictions, physical, left)
        if isinstance(forces, Missing):
            return forces
        values, slopes = _by_held(predictions, physical, held)
        weighed = left.weights[:, None] * slopes
    declared = np.hstack([left.jacobian, weighed])
    forces = [force for force in forces if not _is_declared(force, left, declared)]
    whole = np.column_stack([*(force.slopes for force in forces), slopes])
    alike = [*(force.asking for force in forces), *(Asking() for _ in values)]
    found = lacking_of(left, whole, _MOST, LACKING_LEVEL.value, len(values), alike)
    if left.by_windows and not found:
        return Missing("the motion is in too few windows to tell chance from what the model lacks")
    tests = whole.shape[1]
    return tuple(_told(each, axis, forces, values, held, tests) for each in found)


def _is_declared(force: Force, left: Left, declared: Array) -> bool:
    """Whether what it makes of the errors is made by parameters, (n, k), but for little."""
    sizes = np.linalg.norm(declared, axis=0)
    basis = np.linalg.qr(declared[:, sizes > 0] / sizes[sizes > 0])[0]
    column = left.weights * force.slopes
    own = np.linalg.norm(column - basis @ (basis.T @ column))
    plain = force.term.kind in PLAIN
    least = MIN_OWN_SLOPE_OF_PLAIN.value if plain else MIN_OWN_SLOPE.value
    return bool(own <= least * np.linalg.norm(column))


def _by_held(
    predictions: Predictions, physical: Array, held: HeldParameters
) -> tuple[list[int], Array]:
    """Slopes by what is held and can be moved, and which that is."""
    places = [int(j) for j in np.flatnonzero(held.which)]
    scale = np.where(physical != 0, np.abs(physical), 1.0)
    try:
        slopes = slopes_of(predictions, physical, scale, held.lower, held.upper, held.which)
    except EstimationError:
        places = []
        return places, np.zeros((len(predictions.measured), 0))
    return places, slopes.jacobian[:, places]


def _told(
    found: Lacking,
    axis: Axis,
    forces: Sequence[Force],
    values: Sequence[int],
    held: HeldParameters,
    tests: int,
) -> Lack:
    of_held = found.number - len(forces)
    if of_held < 0:
        subject, unit, factor = forces[found.number].subject(axis, found.factor), "%", 100.0
    else:
        place = values[of_held]
        subject, unit = f"another {held.names[place]} than {held.than[place]}", held.units[place]
        factor = 1.0
    return Lack(
        subject=subject,
        size=factor * found.factor,
        deviation=factor * found.deviation,
        unit=unit,
        chance=found.chance,
        tests=tests,
    )
