"""Whether the axis moved, and the simulated loop with it: every threshold from both sides."""

from types import SimpleNamespace
from typing import cast

import pytest

from axisid import load_axis
from axisid.estimation.checks.check import Check
from axisid.estimation.diagnostics.loop.simulation import following
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.thresholds import MAX_SIMULATION_ERROR
from axisid.estimation.twins import Chain
from axisid.support.missing import Missing

MOST = MAX_SIMULATION_ERROR.value


def judged(error: float | None, simulated: Missing | None = None) -> Estimate:
    return cast(
        Estimate,
        SimpleNamespace(
            simulation_error_percent=error,
            simulated=simulated,
            form=SimpleNamespace(left="force", axis=SimpleNamespace(axis=load_axis("emps2015"))),
            inference=SimpleNamespace(chains=(Chain(jitter=2e-4),)),
        ),
    )


def found(error: float, rest: float = 0.0) -> Check:
    check = following(judged(error), rest)
    assert isinstance(check, Check)
    return check


@pytest.mark.parametrize(
    ("error", "status"),
    [(0.0, "pass"), (9.9, "pass"), (MOST - 0.1, "pass"), (MOST, "fail"), (1e6, "fail")],
)
def test_a_loop_follows_if_it_explains_three_quarters_of_the_power(
    error: float, status: str
) -> None:
    check = found(error)
    assert (check.status, check.figure, check.threshold) == (status, error, MOST)


def test_rests_are_the_first_cause_of_a_loop_that_does_not_follow() -> None:
    """An axis that rests for most of its record is to be looked at without its rests first."""
    assert "rests in 40 %" in str(found(80.0, 0.4).note)
    assert "check the law" not in str(found(80.0, 0.4).note)
    assert "check the law" in str(found(80.0, 0.1).note)


def test_an_estimate_that_cannot_be_simulated_fails_and_one_without_a_loop_is_not_judged() -> None:
    failed = following(judged(None, NotSimulated("it is too stiff.", by_estimate=True)), 0.0)
    assert failed.status == "fail"
    assert failed.meaning.endswith(": it is too stiff")
    untold = NotSimulated("it has no law")
    assert following(judged(None, untold), 0.0) == untold, "with the reason"
