"""What the simulated loop makes of the samples that were left out near reversals and rests.

The regression rounds friction there, and its direction is unknown at rest. The loop has both: the
force that it takes is held against the record's, both decimated alike, where samples were left out
and elsewhere.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds.diagnostics import (
    MAX_NEAR_EXCESS,
    MAX_NEAR_RATIO,
    MIN_LEFT_OUT_ROWS,
)
from axisid.support.arrays import Array
from axisid.support.missing import Missing


@dataclass(frozen=True, slots=True, kw_only=True)
class NearReversals:
    """Force of the record less that of the simulated loop, root mean square.

    Attributes
    ----------
    near, elsewhere : float
        Where samples were left out, and on the rows of the fit; in the unit of the force.
    force : float
        The record's own, where samples were left out.
    rows : int
        That were left out.
    """

    near: float
    elsewhere: float
    force: float
    rows: int


def near_reversals(data: FilteredRecord, quiet: FilteredRecord | None) -> NearReversals | Missing:
    """The simulated loop, `quiet`, on all rows, those that were left out among them."""
    if data.prefilter.reversals != "leave-out":
        return Missing("no samples were left out")
    if quiet is None:
        return Missing("the simulated loop does not follow the record")
    whole = data.keeping_reversals()
    simulated = quiet.signals.force
    force = whole.reduce(data.signals.force)
    apart = force - whole.reduce(simulated)
    fitted = np.isin(whole.row_numbers, data.row_numbers)
    if fitted.all() or not fitted.any():
        return Missing("no rows were left out")
    return NearReversals(
        near=_root_mean_square(apart[~fitted]),
        elsewhere=_root_mean_square(apart[fitted]),
        force=_root_mean_square(force[~fitted]),
        rows=int(np.sum(~fitted)),
    )


def near_reversals_check(
    found: NearReversals | Missing, unit: str, *, explained: bool = False, late: bool = False
) -> Check | Missing:
    """Whether the model holds where samples were left out.

    `explained` is what another check has named: it may be that which is wrong here. `late` is a
    force whose delay is not as declared: a force that jumps at a reversal is wrong there for it.
    """
    if isinstance(found, Missing):
        return found
    if found.rows < MIN_LEFT_OUT_ROWS.value:
        return Missing(f"only {found.rows} rows were left out")
    ratio = found.near / found.elsewhere if found.elsewhere > 0 else np.inf
    excess = float(np.sqrt(max(found.near**2 - found.elsewhere**2, 0.0)))
    good = ratio <= MAX_NEAR_RATIO.value or excess <= MAX_NEAR_EXCESS.value * found.force
    sizes = f"{found.near:.2g} {unit} off, elsewhere {found.elsewhere:.2g} {unit}"
    return Check(
        name="near reversals",
        status=passed(good, matters=not (explained or late)),
        figure=ratio if np.isfinite(ratio) else None,
        threshold=MAX_NEAR_RATIO.value,
        source="root mean square of the record's force less the simulated loop's, where samples "
        "were left out, by that of the rows of the fit; fails where the difference is also more "
        f"than {100 * MAX_NEAR_EXCESS.value:g} % of the force there; a note where another check "
        "names what is wrong",
        meaning="the simulated loop is right where samples were left out, too"
        if good
        else f"near reversals and rests, whose samples are left out, the simulated loop's force is "
        f"{sizes}: "
        + (
            "the delay that alignment tells of may make it; mend that first"
            if late
            else "what fails besides may make it"
            if explained
            else "the estimates hold in motion; friction at low speed is not the model's, such as "
            "a Stribeck peak, sticking or presliding"
        ),
    )


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
