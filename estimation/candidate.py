"""One model of a comparison: its estimate, its criteria, and what it explains of unseen rows."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from axisid.codegen import GeneratedAxis

from .covariance import Hac
from .estimate import Estimate
from .held_out import (
    Block,
    HeldOut,
    Rows,
    held_out_equation,
    held_out_simulation,
    regression_rows,
)
from .linear import Solution
from .prefilter import Prefilter
from .record import Record

#: Of the tests of parameters and of nested models.
LEVEL = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterCheck:
    """Whether the record needs a parameter.

    Attributes
    ----------
    name : str
    p_value : float
        That it is zero: Student, autocorrelation-consistent.
    without_percent : float or None
        Held-out equation error where it is left out; None if the model has no other.
    informed : bool
        The test rejects zero at 5 %, and leaving it out raises the held-out error.
    """

    name: str
    p_value: float
    without_percent: float | None
    informed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Criteria:
    """Information criteria of the least-squares fit; only differences mean anything.

    Attributes
    ----------
    log_likelihood : float
        Gaussian, at the variance that maximises it.
    aic, bic : float
        ``-2 logL + 2 k`` and ``-2 logL + k log n``: for independent rows.
    tic : float
        ``-2 logL + 2 tr(V_iid^-1 V_hac)`` [Takeuchi1976]_: the penalty as autocorrelation has it.
    """

    log_likelihood: float
    aic: float
    bic: float
    tic: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
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
    simulation : HeldOut or None
        Held-out error of the simulated loop.
    reason : str
        Why there is no `simulation`; else empty.
    checks : tuple of ParameterCheck
    """

    name: str
    axis: GeneratedAxis
    estimate: Estimate
    criteria: Criteria
    equation: HeldOut
    simulation: HeldOut | None
    reason: str
    checks: tuple[ParameterCheck, ...]

    @property
    def size(self) -> int:
        """How many parameters."""
        return len(self.estimate.physical)


def candidate(
    name: str,
    axis: GeneratedAxis,
    record: Record,
    prefilter: Prefilter,
    estimate: Estimate,
    blocks: Sequence[Block],
) -> Candidate:
    """Hold an estimate's model against blocks that it is not estimated from.

    Parameters
    ----------
    name : str
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
        As of the estimate.
    estimate : Estimate
        Of the inverse model.
    blocks : sequence of Block

    Raises
    ------
    EstimationError
        Without some block the parameters cannot be told apart.
    """
    rows = regression_rows(estimate)
    signal = float(np.linalg.norm(estimate.y))
    equation, thetas = held_out_equation(rows, blocks, signal)
    simulation = held_out_simulation(axis, record, prefilter, estimate, blocks, thetas)
    reason = simulation if isinstance(simulation, str) else ""
    return Candidate(
        name=name,
        axis=axis,
        estimate=estimate,
        criteria=criteria(rows.by_least_squares()),
        equation=equation,
        simulation=None if isinstance(simulation, str) else simulation,
        reason=reason,
        checks=tuple(
            _check(rows, i, estimate, blocks, equation, signal) for i in range(len(rows.names))
        ),
    )


def criteria(solution: Solution) -> Criteria:
    """Information criteria of a least-squares fit.

    Parameters
    ----------
    solution : Solution
    """
    e, (n, k) = solution.residuals, solution.influence.shape
    # Measured in G of V_iid = s^2 G G', the HAC covariance is free of units.
    within = np.linalg.solve(solution.inverse_factor, Hac().matrix(solution))
    relative = np.linalg.solve(solution.inverse_factor, within.T) / (e @ e / (n - k))
    likelihood = -n / 2 * (math.log(2 * math.pi) + float(np.log(e @ e / n)) + 1)
    return Criteria(
        log_likelihood=likelihood,
        aic=2 * k - 2 * likelihood,
        bic=k * math.log(n) - 2 * likelihood,
        tic=2 * float(np.trace(relative)) - 2 * likelihood,
    )


def _check(
    rows: Rows,
    column: int,
    estimate: Estimate,
    blocks: Sequence[Block],
    equation: HeldOut,
    signal: float,
) -> ParameterCheck:
    """One parameter against zero, and against the model without it."""
    value = estimate.physical[column]
    deviation = float(np.sqrt(estimate.covariances["hac"][column, column]))
    p_value = float(2 * stdtr(estimate.dof, -abs(value) / deviation)) if deviation else 0.0
    without = None
    if len(rows.names) > 1:
        poorer, _ = held_out_equation(rows.without(column), blocks, signal)
        without = poorer.error_percent
    return ParameterCheck(
        name=rows.names[column],
        p_value=p_value,
        without_percent=without,
        informed=p_value < LEVEL and (without is None or without > equation.error_percent),
    )
