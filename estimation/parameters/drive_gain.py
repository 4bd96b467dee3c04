"""The drive's gain, searched for with the parameters of the model.

A loop by another gain g is that by the declared gain g0 with every force times g0/g: what enters
the force linearly is searched for as it is, and simulated times that.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import ModelError
from axisid.support.remedy import Remedy, Setting

from .layout import GAIN, drive_gain_of

_MOTIONS, _SEED = 64, 0  # on which a force is held against twice its parameters
_SAME = 1e-9  # of the largest force
_NEXT_TO_0 = 1e-9  # of the declared gain


def by_declared_gain(axis: GeneratedAxis, physical: Array, gain: float) -> Array:
    """Parameters (p,) with which the declared gain moves an axis as these do with another gain."""
    declared = float(axis.axis.drive.gain)
    least = math.copysign(_NEXT_TO_0 * declared, declared)
    used = max(gain, least) if declared > 0 else min(gain, least)
    return np.where(axis.nonlinear, physical, physical * (declared / used))


def searched_gain(axes: Sequence[GeneratedAxis], names: Sequence[str]) -> Parameter:
    """The gain from where it is declared; what is declared of its deviation was known before.

    Parameters
    ----------
    axes : sequence of GeneratedAxis
        By record.
    names : sequence of str
        Of what else is searched.

    Raises
    ------
    ModelError
        The force of the drive, or of an axis, is no multiple of what would be searched.
    """
    for axis in axes:
        _check(axis, names)
    found, drive = drive_gain_of(axes[0]), axes[0].axis.drive
    value = float(drive.gain)
    found = replace(found, lower=0.0) if value > 0 else replace(found, upper=0.0)
    if not drive.relative_sd:
        return found
    return replace(found, known=value, known_sd=abs(value) * drive.relative_sd)


def _check(axis: GeneratedAxis, names: Sequence[str]) -> None:
    drive, name = axis.axis.drive, axis.axis.name
    if GAIN in names:
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: a parameter of the axis has its "
            f"name, {GAIN}; call that another.",
            code="free-gain-name",
        )
    if axis.states:
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: its friction remembers, and what it "
            "remembers need not grow with its forces; give the gain as the data sheet has it.",
            code="free-gain-states",
        )
    if not drive.is_times_gain:
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: the force of its drive, "
            f"{drive.force}, is no multiple of it; give it as the data sheet has it, or a drive "
            "of another formula.",
            code="free-gain-drive",
        )
    if not _is_multiple(axis):
        raise ModelError(
            f"the drive gain of axis {name!r} cannot be free: its equation of motion has a force "
            "of numbers alone, such as that of a rotor's inertia, which another gain would move; "
            "declare the number as a parameter, and say its value of the record; ",
            Remedy.of(Setting("known", "NAME=VALUE"), "."),
            code="free-gain-numbers",
        )


def _is_multiple(axis: GeneratedAxis) -> bool:
    """Whether the force is twice as large with twice of what enters linearly."""
    random = np.random.default_rng(_SEED)
    motion = random.uniform(0.1, 1.0, (3, _MOTIONS))
    recorded = random.uniform(0.1, 1.0, (len(axis.axis.signals), _MOTIONS))
    direction = np.sign(random.uniform(-1.0, 1.0, _MOTIONS))
    motion[1] *= direction
    values = random.uniform(0.5, 1.5, len(axis.nominal)) * np.where(axis.nominal, axis.nominal, 1.0)

    def force(physical: Array) -> Array:
        about = () if axis.is_linear else (physical,)
        row, rest = axis.evaluate("idm_regressor", *motion, direction, *recorded, *about)
        return np.asarray(row @ physical + rest[:, 0])

    with np.errstate(all="ignore"):
        once, twice = force(values), force(np.where(axis.nonlinear, values, 2 * values))
    finite = np.isfinite(once) & np.isfinite(twice)
    off = np.abs(twice - 2 * once)[finite]
    return bool(np.all(off <= _SAME * np.abs(once[finite]).max(initial=0.0)))
