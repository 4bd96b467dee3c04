"""Plan of a Monte-Carlo study: twin, number of runs, and methods."""

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
from axisid.support.checks import is_whole, refuse
from axisid.support.errors import UsageError
from axisid.support.mappings import FrozenMapping
from axisid.support.wording import quoted

#: Kinds of intervals of a fit: for autoregressive errors, and for independent errors.
COLOURED, IID = "coloured", "iid"
_MOST_RUNS = 10_000_000  # limited by memory


@dataclass(frozen=True, slots=True, kw_only=True)
class MonteCarloPlan:
    """Plan of a study: settings of every run.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis to identify.
    twin : GeneratedAxis
        Axis to simulate; the same, unless the model is to be wrong.
    runs : int
        Number of runs.
    seed : int
        Seed of the noise of all runs.
    methods : tuple of str
        From `METHODS`, and fits such as ``fit:control``.
    noise : Chain
        Noise of the twins.
    prefilter : Prefilter
        Filter, with open settings chosen for the sampling period of the twins.
    checks : int
        Number of runs with a verdict, from the first on.
    settings : mapping of str to object
        Other arguments of `identify`: ``covariance``, ``lags``, ``start``, ``loss``; not used by
        fits.
    bootstrap : int
        Number of simulated replicas for bias and HAC standard errors of an estimate; 0 for none.
    levels : Levels
        Levels of the verdicts.
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
                    f"the {what} {quoted(value)}. Give a whole number of {least} or more; runs are "
                    f"at most {_MOST_RUNS:,}, as their numbers are in memory together",
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
        """True if the identified model is the simulated one, with correct exactly known values."""
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
        """Names of the planned methods that are methods of `identify`."""
        return tuple(method for method in self.methods if not fitted_output(method))

    @property
    def fits(self) -> tuple[str, ...]:
        """Names of the planned methods that are output-error fits."""
        return tuple(filter(fitted_output, self.methods))


def interval_covariance(method: str, chosen: str) -> str:
    """Return the covariance of the printed intervals of a method: the chosen one, or coloured."""
    return COLOURED if fitted_output(method) else chosen
