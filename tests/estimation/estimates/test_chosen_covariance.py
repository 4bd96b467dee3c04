"""What intervals, draws and tests assume of the residuals is the user's choice."""

import numpy as np
import pytest
from scipy.special import stdtrit

from axisid import Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from tests.refusals import refuses


@pytest.mark.slow
@pytest.mark.parametrize("chosen", ["hac", "robust", "iid"])
def test_intervals_draws_and_correlation_are_of_the_chosen_covariance(
    emps2015: GeneratedAxis, twin: Record, chosen: str
) -> None:
    result = identify(emps2015, twin, covariance=chosen)  # type: ignore[arg-type]
    for method in ("idm-iv", "ddm-ls"):
        estimate = result[method]
        covariance = estimate.covariances[chosen]
        reach = stdtrit(estimate.freedom[chosen], 0.975) * np.sqrt(np.diag(covariance))
        for value, r, sd in zip(
            estimate.parameters.values(), reach, np.sqrt(np.diag(covariance)), strict=True
        ):
            assert value.deviation == pytest.approx(sd)
            assert value.interval == pytest.approx((value.corrected - r, value.corrected + r))
        drawn = estimate.propagate("M", draws=20_000)
        assert drawn.interval == pytest.approx(
            estimate.parameters["M"].interval, abs=0.06 * estimate.parameters["M"].deviation
        )
        assert estimate.derive("M").deviation == pytest.approx(np.sqrt(covariance[0, 0]))
    assert result.to_dict()["estimates"][0]["chosen_covariance"] == chosen


def test_another_covariance_is_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    with refuses("unknown-choice", says="hac, robust, iid"):
        identify(emps2015, twin, covariance="bootstrap")  # type: ignore[arg-type]
