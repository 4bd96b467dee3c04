"""What a model leaves, as checks: what it lacks, how much repeats, and whether its loop follows."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels, status_of
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.lack_of_fit import LackOfFit
from axisid.estimation.misspecification import Misspecification, sentence
from axisid.estimation.records import Record, advised_shift
from axisid.estimation.signals import rests_first
from axisid.estimation.thresholds import (
    MAX_SIMULATION_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_MODEL_SHARE,
)
from axisid.support.errors import Missing, of_found

from .column_comparison import scale_remedy

_LESS = (
    '; empty such cells and read with resample="auto", or let such rows count for '
    'less, loss="huber"'
)
_MAX_CLOSE_SIMULATION_ERROR = 10.0  # %, below which nothing is said of the simulation
_SAME_UNIT = 0.02  # distance of a factor from that of another unit, up to which it is that
# HAC deviations by those of noise alone; from there on they are too wide for it
_MIN_HAC_EXCESS = 1.5

#: By check of what is lacking: what is said where there is nothing.
_NOTHING: Mapping[str, str] = {
    "missing terms": "nothing that was looked for is in the residuals",
    "recorded signals": "the recorded signals are in time with the forces that they make, and of "
    "their size",
    "outliers": "no single sample leaves its course",
}


@of_found
def lacks_check(
    found: Sequence[Misspecification],
    name: str,
    axis: GeneratedAxis,
    record: Record,
    levels: Levels = DEFAULT_LEVELS,
    *,
    bounded: bool = False,
) -> Check:
    """Whether something of a kind is in the residuals that the model lacks.

    Parameters
    ----------
    found : sequence of Misspecification
        Of any kind.
    name : {"missing terms", "recorded signals", "outliers"}
        A term or a parameter that changes; a recorded signal that is late or of another size; or a
        single sample of what was measured that leaves its course.
    axis : GeneratedAxis
    record : Record
    levels : Levels
    bounded : bool
        Whether the loss has bounded what outliers do, which are no more than a note then.
    """
    own = [lack for lack in found if lack.check == name]
    advice = ""
    if own and name == "recorded signals":
        advice = f": {_advice(axis, record, own[0])}"
    elif own and name == "outliers" and not bounded:
        advice = _LESS
    said = "; ".join(sentence(lack, axis, record) for lack in own) or _NOTHING[name]
    return Check(
        name=name,
        status=status_of(not own, matters=not bounded),
        figure=100 * max((lack.own_share for lack in own), default=0.0),
        threshold=100 * levels.least_share,
        p_value=min((lack.p_value for lack in own), default=None),
        source="percent of the force, root mean square; fails where the residuals hold more of it "
        f"than those of twins (Hotelling's test, {100 * levels.level:g} % over all that is looked "
        f"for, by Holm's rule) and it is more than {100 * levels.least_share:g} % of the force "
        "beside what the parameters make of it, or moves one by more than its interval",
        meaning=said + advice,
    )


def _advice(axis: GeneratedAxis, record: Record, found: Misspecification) -> str:
    value, deviation, name = found.values[0], found.deviation, found.parameter
    if found.kind == "late signal":
        return advised_shift(name, value, max(MIN_DISTANCE_FROM_NOISE.value * deviation, 0.5))
    column = record.provenance.columns.get(name, "NAME")
    (declared,) = (s for s in axis.axis.signals if s.name == name)
    vague = _SAME_UNIT + MIN_DISTANCE_FROM_NOISE.value * deviation / abs(value)
    if known := scale_remedy(name, column, str(declared.unit), 1 / value, vague):
        return known
    scaled = f"columns {name}={column}:UNIT*{value:.4g}"
    return f"check its unit and its scale ({scaled}), and what is declared as known of its force"


def lack_of_fit_check(found: LackOfFit | None, preferred: Estimate) -> Check | None:
    """How much of what is left is the model's, by what is left again where the motion repeats."""
    if found is None:
        return None
    unit = left_unit(preferred)
    noise, again = f"{found.noise:.2g} {unit} is noise", "repeats wherever a move does"
    if found.period is not None:
        again = f"repeats every {found.period:.4g} s"
    return Check(
        name="lack of fit",
        status=status_of(not found.is_mostly_model, matters=False),
        figure=100 * found.share,
        threshold=100 * MIN_MODEL_SHARE.value,
        source="percent of the residuals' power that is left again where the reference repeats, "
        "from the products of residuals of different repeats; it counts where noise "
        "repeats as much but for a chance of 1e-3 (HAC over the phases), and where it goes on from "
        "row to row",
        meaning=f"{100 * found.share:.0f} % of what the model leaves is the model: "
        f"{found.repeated:.2g} {unit} ({100 * found.repeated / found.left:.2g} % of the "
        f"{preferred.form.left}) {again}, {noise}{_too_wide(found)}"
        if found.is_mostly_model
        else f"{found.repeated:.2g} {unit} of what the model leaves {again} but jumps from "
        f"row to row, as the steps of an encoder do, {noise}"
        if found.is_there and not found.is_smooth
        else f"most of what the model leaves is noise: {found.repeated:.2g} {unit} {again}, {noise}"
        if found.is_there
        else f"what the model leaves is noise: nothing of it {again}, {noise}",
    )


def left_unit(estimate: Estimate) -> str:
    """Unit of the regression's left side."""
    coordinate = estimate.form.axis.axis.coordinate
    unit = coordinate.acceleration_unit if estimate.is_direct else coordinate.force_unit
    return str(unit)


def _too_wide(found: LackOfFit) -> str:
    """What HAC deviations are in those of the noise; nothing where they are about the same."""
    ratios = sorted(found.hac_excess.values())
    if ratios[0] < _MIN_HAC_EXCESS or ratios[-1] == np.inf:  # without noise there is no ratio
        return ""
    low, high = f"{ratios[0]:.2g}", f"{ratios[-1]:.2g}"
    times = low if low == high else f"{low} to {high}"
    return (
        f"; HAC deviations are {times} times those of that noise, and say nothing of how far the "
        "model's error moves the parameters"
    )


def following(preferred: Estimate, rest: float) -> Check | Missing:
    """The simulation error of an estimate; `rest` is the part of its samples at which it stands."""
    error, simulated = preferred.simulation_error_percent, preferred.simulated
    if isinstance(simulated, NotSimulated) and simulated.by_estimate:
        return Check(
            name="simulation",
            status="fail",
            source="an axis that was recorded can be simulated",
            meaning="the loop cannot be simulated with the estimate, as that of an axis that was "
            f"recorded can: {str(simulated).removesuffix('.')}",
        )
    if isinstance(simulated, NotSimulated) or error is None:
        unknown = Missing("the closed loop could not be simulated")
        return simulated if isinstance(simulated, NotSimulated) else unknown
    good, form = error < MAX_SIMULATION_ERROR.value, preferred.form
    but = f" but for {error:.2g} %" * (error >= _MAX_CLOSE_SIMULATION_ERROR)
    units = form.axis.axis.coordinate.unit, form.axis.axis.drive.unit
    noise = "".join(f" ({chain.told(*units)})" for chain in preferred.inference.chains[:1])
    blamed = rests_first(rest) or (
        f"check the law, signs and units, or see whether the record is noise{noise}, or a motion "
        "that the model does not have"
    )
    lost = f"the simulated loop leaves {error:.3g} % of the {form.left} unexplained; "
    said = "the simulated loop follows the record" + but if good else f"{lost}{blamed}"
    return Check(
        name="simulation",
        status=status_of(good),
        figure=error,
        threshold=MAX_SIMULATION_ERROR.value,
        source="simulation error in percent of the left side; at 50 the loop explains three "
        "quarters of its power, at 100 nothing",
        meaning=said,
    )
