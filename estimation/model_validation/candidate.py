"""One model of a comparison: its estimate, information criteria and held-out error."""

import math
from dataclasses import dataclass

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import Estimate
from axisid.support.arrays import Exact, MaybeNan

from .held_out import HeldOut, Regression


@dataclass(frozen=True, slots=True, kw_only=True)
class Criteria:
    """Information criteria of the least-squares fit; only differences mean anything.

    Rows of filtered data are not independent, so that both overrate every further parameter.

    Attributes
    ----------
    log_likelihood : float
        Gaussian, at the variance that maximises it.
    aic, bic : float
        ``-2 logL + 2 k`` and ``-2 logL + k log n``: for independent rows.
    """

    log_likelihood: MaybeNan
    aic: MaybeNan
    bic: MaybeNan


def criteria(rows: Regression) -> Criteria:
    """Information criteria of a regression by least squares."""
    solution = rows.solved(by_instruments=False)
    e, (n, k) = solution.residuals, solution.influence.shape
    likelihood = -n / 2 * (math.log(2 * math.pi) + float(np.log(e @ e / n)) + 1)
    return Criteria(
        log_likelihood=likelihood,
        aic=2 * k - 2 * likelihood,
        bic=k * math.log(n) - 2 * likelihood,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate(Exact):
    """One model of the comparison.

    Attributes
    ----------
    name : str
    axis : GeneratedAxis
    estimate : Estimate
        From all rows.
    criteria : Criteria
    equation : HeldOut
        Held-out error of the equation.
    """

    name: str
    axis: GeneratedAxis
    estimate: Estimate
    criteria: Criteria
    equation: HeldOut

    @property
    def size(self) -> int:
        """How many parameters."""
        return len(self.estimate.physical)
