"""What residuals are like where nothing is wrong: those of loops that are measured as the record.

The regressor of an output error has no noise that residuals could drown in, and what a loop makes
of an encoder's steps, or of noise that shakes friction, comes again where the motion does. So its
residuals are held against those of the same loops with such an encoder or noise, left by the same
estimator.

Of a velocity that is measured in steps almost nothing is left at a constant speed, and all of it
where the speed changes: such residuals have heavy tails without an outlier in them.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimates import Estimate, solver_of
from axisid.estimation.problems import Problem
from axisid.estimation.thresholds.diagnostics import LARGE_SAMPLE
from axisid.estimation.twins import Twins
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

_TWINS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftAsMeasured:
    """What an estimator leaves of loops that are measured as the record is.

    Attributes
    ----------
    residuals, net : (n,) arrays
        All of it, and less what the filter alone leaves.
    columns : (n, k) array
        What the motion stands in: instruments, or a regressor.
    """

    residuals: Array
    net: Array
    columns: Array


def tails_as_measured(
    problem: Problem, estimate: Estimate, away: NDArray[np.bool_] | None = None
) -> Array:
    """Largest of the `tails` of such residuals, (2,); 0 where there are none.

    Parameters
    ----------
    problem : Problem
        What the estimate was made from.
    estimate : Estimate
    away : (n,) array of bool, optional
        See `tails`.
    """
    every = [tails(left.residuals, left.net, away) for left in _left_as_measured(problem, estimate)]
    return np.max(every, axis=0) if every else np.zeros(2)


def tails(residuals: Array, net: Array, away: NDArray[np.bool_] | None) -> Array:
    """Mean fourth power of residuals, and of those less what the filter leaves, (2,).

    Of rows away from reversals and rests where these are a large sample and not all. Unlike a
    kurtosis it tells how large what stands out is.
    """
    if is_apart(away):
        residuals, net = residuals[away], net[away]
    return np.array([np.mean((each - each.mean()) ** 4) for each in (residuals, net)])


def is_apart(away: NDArray[np.bool_] | None) -> bool:
    """Whether rows away from reversals can be looked at by themselves."""
    return away is not None and bool(LARGE_SAMPLE.value <= away.sum() < len(away))


def _left_as_measured(problem: Problem, estimate: Estimate) -> Iterator[LeftAsMeasured]:
    """Residuals of twins, left by the same estimator; none without."""
    chains = estimate.inference.chains
    if not chains:
        return
    form, weights = estimate.form, problem.row_weights
    at = estimate.corrected
    twins = Twins(problem=problem, form=form, at=at, chains=chains, count=_TWINS)
    solver, quiet = solver_of(estimate), estimate.noise_free
    for rows in twins.rows(form):
        with suppress(AxisidError):
            by_row = 1.0 if weights is None else weights
            residuals = solver(form, rows).residuals / by_row
            columns = estimate.loop_rows
            yield LeftAsMeasured(
                residuals=residuals,
                net=residuals if quiet is None else residuals - quiet.residuals,
                columns=(rows.regressor.T / by_row).T if columns is None else columns,
            )
