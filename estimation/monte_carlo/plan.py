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
        Other arguments of `identify`: ``covariance``, ``lags``, ``start``, ``loss``. Fits do not
        use them.
    bootstrap : int
        Number of simulated replicas for bias and HAC standard errors of an estimate; 0 for none.
    levels : Levels
        Thresholds of the checks.
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
        """Refuse numbers that are not whole or out of range, and make `settings` read-only."""
        for what, value, least, most, expected in (
            (
                "number of runs",
                self.runs,
                1,
                _MOST_RUNS,
                f"from 1 to {_MOST_RUNS:,}, because the numbers of all runs are kept in memory",
            ),
            ("seed", self.seed, 0, math.inf, "of 0 or more"),
            ("number of checks", self.checks, 0, math.inf, "of 0 or more"),
        ):
            is_right = is_whole(value) and least <= value <= most
            refuse(
                UsageError,
                (
                    not is_right,
                    f"the {what} is {quoted(value)}. Give a whole number {expected}",
                ),
                code="study",
            )
        object.__setattr__(self, "settings", FrozenMapping(self.settings))

    @property
    def is_right(self) -> bool:
        """True if the identified model is the simulated model, and its exact known values are true.

        Known values with a standard deviation may differ from the true values.
        """
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
    """Return the name of the covariance of a method's printed intervals.

    It is ``coloured`` for a fit, and the `chosen` covariance for a method of `identify`.
    """
    return COLOURED if fitted_output(method) else chosen
