"""Forces, and other values of what is held, that outputs ask for beside a model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

from .missing import Lacking, Left, lacking_of
from .motion_terms import PLAIN, TERMS, subject_of, terms_of

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
        forces = _by_forces(predictions, physical)
        if isinstance(forces, Missing):
            return forces
        numbers, columns = forces
        values, slopes = _by_held(predictions, physical, held)
        weighed = left.weights[:, None] * np.hstack([columns, slopes])
    declared = np.hstack([left.jacobian, weighed[:, columns.shape[1] :]])
    kept = _not_declared(numbers, weighed[:, : columns.shape[1]], declared)
    numbers, columns = [numbers[j] for j in kept], columns[:, kept]
    whole = np.hstack([columns, slopes])
    found = lacking_of(left, whole, _MOST, LACKING_LEVEL.value, len(values))
    if left.by_windows and not found:
        return Missing("the motion is in too few windows to tell chance from what the model lacks")
    tests = whole.shape[1]
    subjects = [subject_of(n, has_stribeck=axis.has_stribeck) for n in numbers]
    return tuple(_told(each, subjects, values, held, tests) for each in found)


def _not_declared(numbers: Sequence[int], columns: Array, declared: Array) -> list[int]:
    """Which weighted columns (n, m) are none of what the parameters make of the errors, (n, k)."""
    sizes = np.linalg.norm(declared, axis=0)
    basis = np.linalg.qr(declared[:, sizes > 0] / sizes[sizes > 0])[0]
    own = np.linalg.norm(columns - basis @ (basis.T @ columns), axis=0)
    least = [
        MIN_OWN_SLOPE_OF_PLAIN.value if TERMS[n][0] in PLAIN else MIN_OWN_SLOPE.value
        for n in numbers
    ]
    return [int(j) for j in np.flatnonzero(own > least * np.linalg.norm(columns, axis=0))]


def _by_forces(predictions: Predictions, physical: Array) -> tuple[list[int], Array] | Missing:
    motions = predictions.motions(physical)
    if motions is None:
        return Missing("the motion cannot be simulated sample by sample")
    terms = terms_of(motions)
    pieces = [np.column_stack(each) for each in zip(*terms.values(), strict=True)]
    slopes = predictions.slopes_by_added(physical, pieces)
    if slopes is None or not np.all(np.isfinite(slopes)):
        return Missing("the motion cannot be simulated with a force beside the model")
    return [*terms], slopes


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
    subjects: Sequence[str],
    values: Sequence[int],
    held: HeldParameters,
    tests: int,
) -> Lack:
    of_held = found.number - len(subjects)
    if of_held < 0:
        subject, unit, factor = subjects[found.number], "%", 100.0
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
