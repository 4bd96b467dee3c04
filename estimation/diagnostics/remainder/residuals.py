"""What an estimate's residuals say, as checks."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import ResidualTests, excess_kurtosis
from axisid.estimation.thresholds.diagnostics import (
    LARGE_SAMPLE,
    MAX_EXCESS_KURTOSIS,
    MAX_JARQUE_BERA,
    NEGLIGIBLE_RESIDUAL,
)
from axisid.estimation.thresholds.lacking import MIN_STEPS_EXCESS
from axisid.estimation.thresholds.regression import SIGNIFICANCE_LEVEL
from axisid.support.arrays import Array
from axisid.support.remedy import Remedy, Setting

from .as_measured import is_apart, tails


def _are_noticeable(estimate: Estimate) -> bool:
    """Whether the residuals, less the filter's own, are any part of the left side."""
    left = float(np.linalg.norm(estimate.net_residuals))
    return left > NEGLIGIBLE_RESIDUAL.value * float(np.linalg.norm(estimate.y))


def normality(
    tests: ResidualTests,
    estimate: Estimate,
    away: NDArray[np.bool_] | None = None,
    by_loops: Callable[[], Array] = lambda: np.zeros(2),
    *,
    explained: bool = False,
) -> Check:
    """Whether outliers decide the estimate; no matter where what residuals are is `explained`.

    What is tested is noise alone; intervals rest on all that is left, the filter's own error too,
    which may be most of it. Where an axis turns, the filter and whatever the model lacks of
    friction leave most: that is told of by checks of its own, and counts once.

    Parameters
    ----------
    tests : ResidualTests
    estimate : Estimate
    away : (n,) array of bool, optional
        Rows that are not near reversals or rests; all by default.
    by_loops : callable
        Gives the `tails` of residuals of loops that are measured as the record is; it is asked for
        where the tails are heavy.
    """
    rows = len(estimate.y)
    left = tests.excess_kurtosis
    if estimate.noise_free is not None:
        left = min(left, excess_kurtosis(estimate.residuals))
    if is_apart(away):
        sides = (estimate.residuals[away], estimate.net_residuals[away])
        left = min(left, *map(excess_kurtosis, sides))
    normal = tests.jarque_bera_p >= SIGNIFICANCE_LEVEL.value
    heavy = not normal and left > MAX_EXCESS_KURTOSIS.value and _are_noticeable(estimate)
    own = tails(estimate.residuals, estimate.net_residuals, away)
    by_steps = heavy and bool(np.any(own <= MIN_STEPS_EXCESS.value * by_loops()))
    shape = "heavier" if tests.excess_kurtosis > 0 else "lighter"
    return Check(
        name="normal residuals",
        status=passed(
            normal,
            matters=(rows < LARGE_SAMPLE.value or left > MAX_EXCESS_KURTOSIS.value)
            and _are_noticeable(estimate)
            and estimate.counts is None
            and not (by_steps or explained),
        ),
        figure=tests.jarque_bera,
        threshold=MAX_JARQUE_BERA.value,
        p_value=tests.jarque_bera_p,
        source="Jarque-Bera, chi-squared with 2 degrees of freedom at 5 %; supposes independent "
        "residuals",
        meaning="the residuals look normal"
        if normal
        else f"the residuals have {shape} tails than normal ones (excess kurtosis "
        f"{tests.excess_kurtosis:.2g}, skewness {tests.skewness:.2g}): "
        + (
            "as those of loops that are measured in such steps, or with such noise, have"
            if by_steps
            else f"the {estimate.loss} loss bounds what they do"
            if estimate.counts is not None
            else "intervals rest on the number of rows"
        )
        + (_largest(estimate, away) if tests.excess_kurtosis > 0 else ""),
        remedy=_LESS if heavy and not by_steps and estimate.counts is None else None,
    )


_LESS = Remedy.of("; to let such rows count for less, ", Setting("loss", "huber"))


def _largest(estimate: Estimate, away: NDArray[np.bool_] | None) -> str:
    """Where the largest residual is, and how large."""
    residuals, coordinate = estimate.residuals, estimate.form.axis.axis.coordinate
    worst = int(np.argmax(np.abs(residuals)))
    sample = int(estimate.rows[worst])
    time = sample * estimate.period if estimate.times is None else float(estimate.times[worst])
    unit = coordinate.force_unit if estimate.form.left == "force" else coordinate.acceleration_unit
    deviations = abs(residuals[worst]) / residuals.std()
    turns = away is not None and len(away) == len(residuals) and not away[worst]
    return (
        f"; look for outliers{' at reversals' * turns}, the largest at sample {sample + 1}, "
        f"{time:.6g} s after the first: {residuals[worst]:.3g} {unit}, {deviations:.3g} deviations"
    )
