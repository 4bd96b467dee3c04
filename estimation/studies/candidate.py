"""One model of a comparison: its estimate, its criteria, and what it explains of unseen rows."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtr

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.estimates import Estimate
from axisid.estimation.parameters import GAIN
from axisid.estimation.problems import Problem
from axisid.estimation.regression import Hac, InverseForm, Solution
from axisid.estimation.thresholds import SIGNIFICANCE_LEVEL
from axisid.support.arrays import Exact
from axisid.support.missing import Missing
from axisid.support.remedy import Note

from .held_out import (
    HeldOut,
    HeldOutBlock,
    Rows,
    held_out_equation,
    held_out_simulation,
    regression_rows,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterCheck:
    """Whether the record needs a parameter.

    Attributes
    ----------
    name : str
    p_value : float or None
        That it is zero: Student, autocorrelation-consistent.
    without_percent : float or None
        Held-out equation error where it is left out; None if the model has no other.
    informed : bool or None
        The test rejects zero at 5 %, and leaving it out raises the held-out error; without a test,
        by more than one standard error. None of a nonlinear parameter.
    not_tested : str or None
        Why there is no `p_value`.
    """

    name: str
    p_value: float | None = None
    without_percent: float | None = None
    informed: bool | None = None
    not_tested: str | None = None


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
    simulation : HeldOut or None
        Held-out error of the simulated loop.
    reason : Note or None
        Why there is no `simulation`.
    checks : tuple of ParameterCheck
    """

    name: str
    axis: GeneratedAxis
    estimate: Estimate
    criteria: Criteria
    equation: HeldOut
    simulation: HeldOut | None
    reason: Note | None
    checks: tuple[ParameterCheck, ...]

    @property
    def size(self) -> int:
        """How many parameters."""
        return len(self.estimate.physical)


def candidate(
    name: str,
    problem: Problem,
    estimate: Estimate,
    blocks: Sequence[HeldOutBlock],
) -> Candidate:
    """Hold an estimate's model against blocks that it is not estimated from.

    Parameters
    ----------
    name : str
    problem : Problem
        That the estimate was made from.
    estimate : Estimate
        Of the inverse model.
    blocks : sequence of HeldOutBlock

    Raises
    ------
    EstimationError
        Without some block the parameters cannot be told apart.
    """
    rows = regression_rows(estimate)
    weights = 1.0 if estimate.weights is None else estimate.weights
    signal = float(np.linalg.norm(weights * estimate.y))
    equation, thetas = held_out_equation(rows, blocks, signal)
    simulation = held_out_simulation(problem, estimate, blocks, thetas)
    reason = simulation.note if isinstance(simulation, Missing) else None
    return Candidate(
        name=name,
        axis=problem.axis,
        estimate=estimate,
        criteria=criteria(rows.by_least_squares()),
        equation=equation,
        simulation=None if isinstance(simulation, Missing) else simulation,
        reason=reason,
        checks=tuple(
            _checked(column, problem, estimate, rows, blocks, equation)
            for column in range(len(rows.names))
        ),
    )


def criteria(solution: Solution) -> Criteria:
    """Information criteria of a least-squares fit.

    Parameters
    ----------
    solution : Solution
    """
    e, (n, k) = solution.residuals, solution.influence.shape
    # Measured in G of V_iid = s^2 G G', the HAC covariance is free of units. What a fit takes of
    # the errors is what the criterion is about: of few scores, as an estimate's own.
    within = np.linalg.solve(solution.inverse_factor, Hac().matrix(solution))
    relative = np.linalg.solve(solution.inverse_factor, within.T) / (e @ e / (n - k))
    likelihood = -n / 2 * (math.log(2 * math.pi) + float(np.log(e @ e / n)) + 1)
    return Criteria(
        log_likelihood=likelihood,
        aic=2 * k - 2 * likelihood,
        bic=k * math.log(n) - 2 * likelihood,
        tic=2 * float(np.trace(relative)) - 2 * likelihood,
    )


def _checked(
    column: int,
    problem: Problem,
    estimate: Estimate,
    rows: Rows,
    blocks: Sequence[HeldOutBlock],
    equation: HeldOut,
) -> ParameterCheck:
    """A parameter of an estimate against zero, and against the model without it."""
    name, why = rows.names[column], ""
    if name in rows.nonlinear:
        why = "it enters nonlinearly, so that a model without it is none with it at zero"
    elif name == GAIN:
        why = "it is the drive's, and no term of the model"
    if why:
        return ParameterCheck(name=name, not_tested=why)
    poorer = _without(column, problem, estimate, rows)
    without, excess, deviation = None, math.inf, 0.0
    if poorer.names:
        without, _ = held_out_equation(poorer, blocks, equation.signal)
        excess, deviation = without.excess(equation)
    # Where it is zero, these may be fitted to noise: the held-out error alone tells.
    lost = " and ".join(each for each in rows.nonlinear if each not in poorer.names)
    p_value = 0.0 if lost else _p_value(estimate, column)
    return ParameterCheck(
        name=name,
        p_value=None if lost else p_value,
        without_percent=None if without is None else without.error_percent,
        informed=p_value < SIGNIFICANCE_LEVEL.value and excess > (deviation if lost else 0.0),
        not_tested=f"at zero, {lost} would mean nothing" if lost else None,
    )


def _p_value(estimate: Estimate, column: int) -> float:
    """That a parameter is zero."""
    value = estimate.corrected[column]
    deviation = float(np.sqrt(estimate.covariances["hac"][column, column]))
    freedom = float(estimate.freedom["hac"][column])
    return float(2 * stdtr(freedom, -abs(value) / deviation)) if deviation else 0.0


def _without(column: int, problem: Problem, estimate: Estimate, rows: Rows) -> Rows:
    """The rows without a parameter, and without those that then move nothing."""
    if not rows.nonlinear:
        return rows.without(column)
    physical = estimate.physical.copy()
    physical[column] = 0.0
    form = InverseForm(problem.axis, physical)
    found = problem.reduced(form, [data.signals for data in problem.data])
    moved = replace(rows, left=found.left - found.intercept, regressor=found.regressor)
    own = found.regressor
    unused = [i for i in range(len(physical)) if i == column or not own[:, i].any()]
    for i in reversed(unused):
        moved = moved.without(i)
    return moved
