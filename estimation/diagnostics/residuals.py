"""What an estimate's residuals say, as checks."""

import numpy as np
from scipy.special import chdtri

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import ResidualTests

from .check import Check, passed

_SIGNIFICANT = 0.05
_ALONE = "too few rows follow each other in time"
_TWO_SIDED = 1.96
_MANY = 100  # rows from which estimates are about normal whatever the residuals are
_OUTLIERS = 6.0  # excess kurtosis from which a few rows decide all the same; Laplace's is 3


def independence(tests: ResidualTests, chosen: str) -> Check:
    """Whether neighbouring residuals are alike; no matter where the HAC covariance was chosen."""
    if not tests.ljung_box_freedom:
        return Check.missing("independent residuals", _ALONE)
    independent = tests.ljung_box_p >= _SIGNIFICANT
    limit = float(chdtri(tests.ljung_box_freedom, _SIGNIFICANT))
    return Check(
        name="independent residuals",
        status=passed(independent, matters=chosen != "hac"),
        figure=tests.ljung_box,
        threshold=limit,
        p_value=tests.ljung_box_p,
        source="Ljung-Box at 5 %",
        meaning="the residuals look independent"
        if independent
        else f"the residuals are autocorrelated, as those of filtered data are (Ljung-Box "
        f"{tests.ljung_box:.4g}, less than {limit:.3g} if not; Durbin-Watson "
        f"{tests.durbin_watson:.2f}): believe the HAC deviations, not the i.i.d. ones",
    )


def sign_runs(tests: ResidualTests, rows: int, chosen: str) -> Check:
    """Whether the residuals keep their sign longer than by chance."""
    if np.isnan(tests.runs_z):
        return Check.missing("runs of one sign", _ALONE)
    by_chance = tests.runs_p >= _SIGNIFICANT
    longest = len(tests.run_lengths)
    return Check(
        name="runs of one sign",
        status=passed(by_chance, matters=tests.runs_z < 0 or chosen != "hac"),
        figure=tests.runs_z if abs(tests.runs_z) < float("inf") else None,
        threshold=_TWO_SIDED,
        p_value=tests.runs_p,
        source="Wald-Wolfowitz runs about zero, in deviations from chance, at 5 %",
        meaning="the residuals change their sign as often as by chance"
        if by_chance
        else (
            f"the residuals keep their sign longer than by chance (for {longest} of {rows} rows at "
            "most): something slow is not in the model, such as friction that depends on the "
            "position or on time"
        )
        if tests.runs_z < 0
        else "the residuals change their sign more often than by chance, as the edge of the "
        "decimation filter or a vibration makes them; the HAC deviations allow for it"
        + ("" if chosen == "hac" else ", which were not chosen here"),
    )


def left_of_the_motion(tests: ResidualTests, estimate: Estimate) -> Check:
    """Whether the residuals follow the motion."""
    nothing = tests.cross_z <= tests.cross_limit
    relative = abs(tests.cross_correlation) / tests.cross_deviations
    row, column = divmod(int(relative.argmax()), relative.shape[1])
    lag = row - (len(relative) - 1) // 2
    names = [q.expression or q.name for q in estimate.form.quantities]
    of = "instrument" if estimate.Z is not None else "regressor's column"
    return Check(
        name="residuals against the motion",
        status=passed(nothing),
        figure=tests.cross_z,
        threshold=tests.cross_limit,
        p_value=tests.cross_p,
        source="largest correlation of the residuals with an instrument (a regressor's column for "
        "least squares) over the lags, in deviations by Bartlett's formula; 5 % over all of them",
        meaning="the residuals do not follow the motion"
        if nothing
        else f"the residuals follow the motion, most the {of} of {names[column]}, {abs(lag)} rows "
        f"{'before' if lag < 0 else 'after'} it: a term, a delay or a dynamic is not in "
        "the model, or the filter rounds reversals",
    )


def normality(tests: ResidualTests, estimate: Estimate) -> Check:
    """Whether outliers decide the estimate."""
    rows = len(estimate.y)
    normal = tests.jarque_bera_p >= _SIGNIFICANT
    shape = "heavier" if tests.excess_kurtosis > 0 else "lighter"
    return Check(
        name="normal residuals",
        status=passed(normal, matters=rows < _MANY or tests.excess_kurtosis > _OUTLIERS),
        figure=tests.jarque_bera,
        threshold=5.991,
        p_value=tests.jarque_bera_p,
        source="Jarque-Bera, chi-squared with 2 degrees of freedom at 5 %; supposes independent "
        "residuals",
        meaning="the residuals look normal"
        if normal
        else f"the residuals have {shape} tails than normal ones (excess kurtosis "
        f"{tests.excess_kurtosis:.2g}, skewness {tests.skewness:.2g}): intervals rest on the "
        f"number of rows{_largest(estimate) if tests.excess_kurtosis > 0 else ''}",
    )


def _largest(estimate: Estimate) -> str:
    """Where the largest residual is, and how large."""
    residuals, coordinate = estimate.residuals, estimate.form.axis.axis.coordinate
    worst = int(np.argmax(np.abs(residuals)))
    sample = int(estimate.rows[worst])
    time = sample * estimate.period if estimate.times is None else float(estimate.times[worst])
    unit = coordinate.force_unit if estimate.form.left == "force" else coordinate.acceleration_unit
    deviations = abs(residuals[worst]) / residuals.std()
    return (
        f"; look for outliers at reversals, the largest at sample {sample + 1}, {time:.6g} s after "
        f"the first: {residuals[worst]:.3g} {unit}, {deviations:.3g} deviations"
    )
