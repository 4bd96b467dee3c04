"""What is done in every run of a study: on which twin, how many, and by which methods."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import fitted_output
from axisid.estimation.noise_models import Chain
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import twin_plan
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Levels
from axisid.support.errors import UsageError, is_whole, quoted, refuse
from axisid.support.mappings import FrozenMapping

#: What the intervals of a fit are of: errors that follow an autoregression.
COLOURED, IID = "coloured", "iid"
_MOST_RUNS = 10_000_000  # whose numbers a study holds together


@dataclass(frozen=True, slots=True, kw_only=True)
class MonteCarloPlan:
    """What is done in every run.

    Attributes
    ----------
    axis : GeneratedAxis
        That is identified.
    twin : GeneratedAxis
        That is simulated; the same, unless the model is to be wrong.
    runs : int
    seed : int
    methods : tuple of str
        Of `METHODS`, and fits such as ``fit:control``.
    noise : Chain
    prefilter : Prefilter
        What it leaves open is chosen for the twins' rate.
    checks : int
        How many runs are judged, from the first on.
    settings : mapping of str to object
        What else `identify` takes: ``covariance``, ``lags``, ``start``, ``loss``, which are nothing
        to fits.
    bootstrap : int
        How many twins tell the bias and HAC deviations of an estimate; 0 for none.
    levels : Levels
        By which runs are judged.
    """

    axis: GeneratedAxis
    twin: GeneratedAxis
    runs: int
    seed: int
    methods: tuple[str, ...]
    noise: Chain
    prefilter: Prefilter
    checks: int
    settings: Mapping[str, Any]
    bootstrap: int = 0
    levels: Levels = DEFAULT_LEVELS

    def __post_init__(self) -> None:
        refuse(
            UsageError,
            *(
                (
                    not (is_whole(value) and least <= value <= most),
                    f"the {what} {quoted(value)}; give a study a whole number of {least} or "
                    f"more, and of runs {_MOST_RUNS:,} at most, whose numbers are in memory "
                    "together",
                )
                for what, value, least, most in (
                    ("runs are", self.runs, 1, _MOST_RUNS),
                    ("seed is", self.seed, 0, math.inf),
                    ("checks are", self.checks, 0, math.inf),
                )
            ),
            code="study",
        )
        object.__setattr__(self, "settings", FrozenMapping(self.settings))

    @property
    def is_right(self) -> bool:
        """Whether what is identified is what is simulated, what is known exactly included."""
        if self.axis.signature != self.twin.signature:
            return False
        true = twin_plan(self.twin).true_values
        return all(
            math.isclose(p.known, true.get(p.name, p.known))
            for p in self.axis.base.known
            if p.known is not None and not p.known_sd
        )

    @property
    def regressions(self) -> tuple[str, ...]:
        """The methods of `identify`."""
        return tuple(method for method in self.methods if not fitted_output(method))

    @property
    def fits(self) -> tuple[str, ...]:
        """The methods that are fits of the output error."""
        return tuple(filter(fitted_output, self.methods))


def interval_covariance(method: str, chosen: str) -> str:
    """What the printed intervals of a method are of: those of identifications are chosen."""
    return COLOURED if fitted_output(method) else chosen
