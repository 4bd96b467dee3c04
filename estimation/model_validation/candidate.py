"""One model of a comparison: its estimate, its criteria, and whether another one contains it.

A model is nested in another where the columns of the other span its own on the rows at hand. The
classical F test takes the rows for independent; the Wald test takes the autocorrelation-consistent
covariance of the larger model instead.

A nonlinear parameter that only the larger model has means nothing where the smaller one holds:
there it is fitted to the noise, and neither statistic is F distributed [Davies1987]_. Such pairs
are not tested.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np
from scipy.special import stdtr

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import Estimate
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.parameters import GAIN
from axisid.estimation.regression import (
    Classical,
    Covariance,
    Hac,
    InverseForm,
    Solution,
    joint_p,
    wald,
)
from axisid.estimation.thresholds import SIGNIFICANCE_LEVEL
from axisid.support.arrays import Array, Exact, MaybeNan
from axisid.support.errors import Missing

from .held_out import (
    HeldOut,
    HeldOutBlock,
    Regression,
    held_out_equation,
    held_out_simulation,
    regression_rows,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterSignificance:
    """Whether the record needs a parameter.

    Attributes
    ----------
    name : str
    p_value : float or None
        That it is zero, HAC, by Student's distribution.
    without_percent : float or None
        Held-out equation error without it; null if the model has no other.
    informed : bool or None
        The test rejects zero at 5 %, and leaving it out raises the held-out error; without a test,
        by more than one standard error. Not judged: null, of a nonlinear parameter.
    not_tested : str or None
        Why there is no p-value.
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
        Takeuchi's, for autocorrelated rows: ``-2 logL + 2 tr(V_iid^-1 V_hac)`` [Takeuchi1976]_.
    """

    log_likelihood: MaybeNan
    aic: MaybeNan
    bic: MaybeNan
    tic: MaybeNan


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
    reason : str or None
        Why there is no `simulation`.
    checks : tuple of ParameterSignificance
    """

    name: str
    axis: GeneratedAxis
    estimate: Estimate
    criteria: Criteria
    equation: HeldOut
    simulation: HeldOut | None
    reason: str | None
    checks: tuple[ParameterSignificance, ...]

    @property
    def size(self) -> int:
        """How many parameters."""
        return len(self.estimate.physical)


@np.errstate(all="ignore")
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
    whole = estimate.weights * estimate.y
    equation, thetas = held_out_equation(rows, blocks, float(np.linalg.norm(whole)))
    simulation = held_out_simulation(problem, whole, blocks, thetas)
    return Candidate(
        name=name,
        axis=problem.axis,
        estimate=estimate,
        criteria=criteria(rows.solved(by_instruments=False)),
        equation=equation,
        simulation=None if isinstance(simulation, Missing) else simulation,
        reason=simulation.reason if isinstance(simulation, Missing) else None,
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
    rows: Regression,
    blocks: Sequence[HeldOutBlock],
    equation: HeldOut,
) -> ParameterSignificance:
    """A parameter of an estimate against zero, and against the model without it."""
    name = rows.names[column]
    if name in rows.nonlinear or name == GAIN:
        return ParameterSignificance(
            name=name,
            not_tested="it is the drive's, and no term of the model"
            if name == GAIN
            else "it enters nonlinearly, so that a model without it is none with it at zero",
        )
    poorer = _without(column, problem, estimate, rows)
    without, excess, deviation = None, math.inf, 0.0
    if poorer.names:
        without, _ = held_out_equation(poorer, blocks, equation.signal)
        excess, deviation = without.excess(equation)
    # Where it is zero, these may be fitted to noise: the held-out error alone tells.
    lost = " and ".join(each for each in rows.nonlinear if each not in poorer.names)
    deviation_hac = float(np.sqrt(estimate.covariances["hac"][column, column]))
    distance = abs(estimate.corrected[column]) / deviation_hac if deviation_hac else math.inf
    p_value = 0.0 if lost else float(2 * stdtr(estimate.freedom["hac"][column], -distance))
    return ParameterSignificance(
        name=name,
        p_value=None if lost else p_value,
        without_percent=None if without is None else without.error_percent,
        informed=p_value < SIGNIFICANCE_LEVEL.value and excess > (deviation if lost else 0.0),
        not_tested=f"at zero, {lost} would mean nothing" if lost else None,
    )


def _without(column: int, problem: Problem, estimate: Estimate, rows: Regression) -> Regression:
    """The rows without a parameter, and without those that then move nothing."""
    if not rows.nonlinear:
        return rows.without(column)
    physical = estimate.physical.copy()
    physical[column] = 0.0
    signals = [data.signals for data in problem.data]
    found = problem.reduced(InverseForm(problem.axis, physical), signals)
    unused = [i for i, own in enumerate(found.regressor.T) if i == column or not own.any()]
    changed = replace(rows, left=found.left - found.intercept, regressor=found.regressor)
    return changed.without(*unused)


# of a column of the smaller model, not spanned by those of the larger
_MAX_NESTING_REMAINDER = 1e-8


@dataclass(frozen=True, slots=True, kw_only=True)
class NestedTest:
    """The smaller model against the larger one that contains it.

    Attributes
    ----------
    smaller, larger : str
        Candidates.
    restrictions : int
        Numerator degrees of freedom.
    dof : int
        Denominator degrees of freedom of the classical F.
    f, f_p : float or None
        Classical F of least squares and its p-value, for independent residuals.
    wald, wald_p : float or None
        Wald statistic over its restrictions, HAC, and its p-value, Hotelling's, by the effective
        degrees of freedom of that covariance.
    not_tested : str or None
        Why there are no statistics.
    """

    smaller: str
    larger: str
    restrictions: int
    dof: int
    f: float | None = None
    f_p: float | None = None
    wald: float | None = None
    wald_p: float | None = None
    not_tested: str | None = None


#: T, (l, k), and start, (l,), of ``X_small theta + known_small = X_large (T theta + start) +
#: known_large``.
Embedding = tuple[Array, Array]


@np.errstate(all="ignore")
def nested_tests(
    models: Mapping[str, Regression],
) -> tuple[tuple[NestedTest, ...], tuple[tuple[str, str], ...]]:
    """Test each model in the next richer ones that contain it.

    Parameters
    ----------
    models : mapping of str to Regression
        Regressions of one left side on the same rows.

    Returns
    -------
    tests : tuple of NestedTest
    same : tuple of (str, str)
        Pairs that span the same columns: one model in different parameters.
    """
    size = {name: len(rows.names) for name, rows in models.items()}
    within = {
        (a, b): how
        for a, b in permutations(models, 2)
        if size[a] <= size[b] and (how := nesting(models[a], models[b])) is not None
    }
    nested = {(a, b) for a, b in within if size[a] < size[b]}
    tests = tuple(
        _tested(a, b, models, how)
        for (a, b), how in within.items()
        if (a, b) in nested and not any({(a, c), (c, b)} <= nested for c in models)
    )
    same = (pair for pair in combinations(models, 2) if pair in within and pair not in nested)
    return tests, tuple(same)


def _tested(a: str, b: str, models: Mapping[str, Regression], how: Embedding) -> NestedTest:
    n, k = models[b].regressor.shape
    pair = NestedTest(smaller=a, larger=b, restrictions=k - len(models[a].names), dof=n - k)
    if free := [name for name in models[b].nonlinear if name not in models[a].nonlinear]:
        return replace(
            pair, not_tested=f"{b} estimates {' and '.join(free)}, of no meaning where {a} holds"
        )
    # By the covariance of least squares the Wald statistic is the classical F.
    f, f_p = wald_test(models[b].solved(by_instruments=False), how, Classical())
    # A restriction of what the fit took, widened for few scores: of right ones on 1.5 to 3 s it
    # rejects 0 to 4 % at 5 %, the kernel alone 2 to 16 %; in a force of 500 ms 6 to 14 %, and 24
    # to 38 %.
    wald, wald_p = wald_test(models[b].solved(), how, Hac())
    return replace(pair, f=f, f_p=f_p, wald=wald, wald_p=wald_p)


def nesting(small: Regression, large: Regression) -> Embedding | None:
    """How the larger model's parameters give the smaller model; None if they cannot."""
    size = np.linalg.norm(large.regressor, axis=0)
    basis, triangle = np.linalg.qr(large.regressor / size)
    wanted = np.column_stack([small.regressor, large.left - small.left])
    shares = basis.T @ wanted
    missed = np.linalg.norm(wanted - basis @ shares, axis=0)
    allowed = _MAX_NESTING_REMAINDER * np.linalg.norm(wanted, axis=0)
    # The difference of the known parts is rounding where they are the same.
    allowed[-1] = max(allowed[-1], _MAX_NESTING_REMAINDER * float(np.linalg.norm(large.left)))
    if np.any(missed > allowed):
        return None
    weights = np.linalg.solve(triangle, shares) / size[:, None]
    return weights[:, :-1], weights[:, -1]


def wald_test(larger: Solution, how: Embedding, covariance: Covariance) -> tuple[float, float]:
    """Wald statistic over its restrictions, and the p-value, that the smaller model holds.

    Parameters
    ----------
    larger : Solution
        Of the larger model.
    how : Embedding
        Of the smaller model in it.
    covariance : Covariance
    """
    (matrix, start), k = how, how[0].shape[1]
    # Units must not enter: parameters are measured in their own deviations.
    spread = covariance.matrix(larger)
    size = np.sqrt(np.diag(spread))
    inside = matrix / size[:, None]
    across = np.linalg.qr(inside / np.linalg.norm(inside, axis=0), mode="complete")[0][:, k:].T
    departure = across @ ((larger.theta - start) / size)
    square, restrictions = wald(departure, across @ (spread / np.outer(size, size)) @ across.T)
    dof = float(np.min(covariance.applied(larger).freedom))
    return square / restrictions, joint_p(
        square, restrictions, dof, one_variance=covariance.has_one_variance
    )
