"""Least squares of the two forms parameter by parameter, where no one correlation parts them.

Terms that depend on the force, a friction of each direction, or records that are weighted leave the
two forms without other columns that are the same; then r^2 of force and acceleration is not what
parts them, and the parameters themselves are compared.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.choices.outputs import OPEN_LOOP_FIT
from axisid.estimation.estimates import Estimate, alike_corrected
from axisid.estimation.thresholds.diagnostics import (
    MAX_BIAS_DISTANCE,
    MAX_RELATIVE_DEVIATION,
    MAX_UNSEEN_BIAS,
    NEGLIGIBLE_BIAS,
    NOTICEABLE_BIAS,
)
from axisid.support.remedy import Remedy

#: What tells which of the two forms is off, or that both are, where no instruments do.
TOLD_BY_OPEN_LOOP = Remedy.of(
    "; take a fit of the position under the recorded control, which no noise of a derivative "
    "moves: ",
    OPEN_LOOP_FIT,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pair:
    """A parameter by both: its values, their distance by the larger one and in deviations."""

    name: str
    inverse: float
    direct: float
    share: float
    shift: float

    @property
    def differs(self) -> bool:
        return self.share > NEGLIGIBLE_BIAS.value and self.shift > MAX_UNSEEN_BIAS.value

    @property
    def is_far(self) -> bool:
        return self.share > NOTICEABLE_BIAS.value and self.shift > MAX_BIAS_DISTANCE.value

    def text(self) -> str:
        return (
            f"{self.name} is {self.inverse:.5g} by idm-ls and {self.direct:.5g} by ddm-ls "
            f"({self.shift:.2g} deviations)"
        )


def forms_apart_check(inverse: Estimate, direct: Estimate, *, by_instruments: bool) -> Check:
    """Whether least squares of the inverse and of the direct model are two answers.

    Parameters
    ----------
    inverse, direct : Estimate
        By least squares, of the same rows.
    by_instruments : bool
        Whether instruments tell which of the two is off.
    """
    pairs = _pairs(inverse, direct)
    far = [pair for pair in pairs if pair.is_far]
    apart = far or [pair for pair in pairs if pair.differs]
    fails = bool(far) and not by_instruments
    return Check(
        name="inverse against direct",
        status=passed(not apart, matters=fails),
        figure=100 * max(pair.share for pair in pairs) if pairs else None,
        threshold=100 * NOTICEABLE_BIAS.value,
        source="largest difference of a parameter by idm-ls and ddm-ls in percent of the larger "
        "value; a note from 1 % and half a deviation on, and without instruments a failure from "
        "10 % and three deviations on",
        meaning=", ".join(pair.text() for pair in apart) + _why(by_instruments=by_instruments)
        if apart
        else "least squares of the two forms agrees",
        remedy=TOLD_BY_OPEN_LOOP if fails else None,
    )


def _why(*, by_instruments: bool) -> str:
    said = ": noise or what the model lacks parts the two"
    if by_instruments:
        return f"{said}; believe the instruments"
    return (
        f"{said}, and without instruments nothing tells which is nearer; the intervals do not hold "
        "this"
    )


def _pairs(inverse: Estimate, direct: Estimate) -> list[_Pair]:
    """Parameters that are known, by both."""
    found = []
    both = zip(inverse.parameters.items(), *alike_corrected(inverse, direct), strict=True)
    for (name, value), here, there in both:
        if value.relative_deviation_percent >= MAX_RELATIVE_DEVIATION.value:
            continue
        apart, largest = abs(float(here - there)), max(abs(float(here)), abs(float(there)))
        deviation = max(value.deviation, direct.parameters[name].deviation)
        found.append(
            _Pair(
                name=name,
                inverse=float(here),
                direct=float(there),
                share=apart / largest if largest else 0.0,
                shift=apart / deviation if deviation > 0 else np.inf,
            )
        )
    return found
