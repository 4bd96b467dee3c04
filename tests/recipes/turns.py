"""Whether the axis turns often enough to tell friction from an offset."""

import numpy as np

from axisid.estimation.findings import Said
from axisid.estimation.verdict_checks import Check, status_of

from .diagnostic_inputs import DiagnosticInputs

_MIN_TURNS = 4  # of the sign of the velocity; fewer do not tell friction from an offset


def turns_check(case: DiagnosticInputs) -> Check:
    """How often the filtered velocity changes its sign."""
    turns = int(np.count_nonzero(np.diff(np.sign(case.data.signals.velocity))))
    good = turns >= _MIN_TURNS
    return Check(
        name="turns",
        status=status_of(good, matters=False),
        figure=float(turns),
        threshold=float(_MIN_TURNS),
        source="changes of the sign of the filtered velocity",
        finding=Said(
            text=f"the axis turns {turns} times"
            if good
            else f"the axis turns {turns} times only: record more strokes"
        ),
    )
