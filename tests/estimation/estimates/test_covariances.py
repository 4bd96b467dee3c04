"""Covariances as rows of a table, and two estimates against each other and a resampling."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import statsmodels.api as sm
from scipy.special import stdtrit

from axisid import (
    Identification,
    Record,
    load_result,
    read_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation import choices
from axisid.estimation.diagnostics.hausman import HausmanTest, hausman, significant_differences
from axisid.estimation.estimates import COVARIANCES
from axisid.support.missing import Missing
from benchmarks.machines import Machine, records, white
from tests.recipes import row_of_recipe
from tests.refusals import refuses
from tests.unjudged import identify

NAME, RECIPE = "hc3", "Add a covariance"
MODULE = "axisid.estimation.regression.leave_one_out"


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    row = row_of_recipe(RECIPE, MODULE, monkeypatch)
    monkeypatch.setattr(choices, "COVARIANCE_ROWS", (*choices.COVARIANCE_ROWS, row))
    monkeypatch.setitem(COVARIANCES, NAME, row)


@pytest.fixture
def by_hc3(added: None, emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, methods=["idm-ls", "ddm-ls"], covariance=NAME)


@pytest.mark.slow
def test_one_class_and_one_row_add_a_covariance(by_hc3: Identification) -> None:
    estimate = by_hc3["idm-ls"]
    fitted = sm.OLS(estimate.y, estimate.X).fit(cov_type="HC3")
    assert estimate.covariances[NAME] == pytest.approx(fitted.cov_params(), rel=1e-9)
    for estimate in by_hc3.estimates.values():
        for value, variance in zip(
            estimate.parameters.values(), np.diag(estimate.covariances[NAME]), strict=True
        ):
            assert {*value.deviations} == {*COVARIANCES}
            assert value.deviation == value.deviations[NAME] == pytest.approx(np.sqrt(variance))
    assert "HC3" in by_hc3.summary(full=True)


@pytest.mark.slow
@pytest.mark.usefixtures("added")
def test_a_file_of_a_covariance_that_is_not_there_is_refused(
    by_hc3: Identification, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = by_hc3.save(tmp_path / "result.json")
    monkeypatch.delitem(COVARIANCES, NAME)
    with refuses("result-file", says="'hc3'"):
        load_result(file)


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


def test_it_is_the_difference_of_what_is_less_its_bias(result: Identification) -> None:
    for one, other in pairwise(("idm-ls", "idm-iv", "didim")):
        expected = result[one].corrected - result[other].corrected
        found = hausman(result[one], result[other])
        assert [each.difference for each in found.values()] == list(expected)


def test_two_solvers_of_one_system_differ_by_nothing(result: Identification) -> None:
    """IDM-IV and DDM-IV solve the same equations by the same instruments."""
    found = hausman(result["idm-iv"], result["ddm-iv"])
    assert max(each.shift for each in found.values()) < 1e-2
    assert significant_differences(found) == {}


@pytest.mark.slow
def test_it_is_of_the_same_rows(emps2015: GeneratedAxis, twin: Record) -> None:
    long, short = (
        identify(emps2015, record, methods="idm-iv")["idm-iv"]
        for record in (twin, twin.windowed((None, 4.0)))
    )
    assert isinstance(hausman(long, short), Missing)


@pytest.mark.slow
def test_deviation_of_the_difference_is_its_scatter(emps2015: GeneratedAxis, twin: Record) -> None:
    """Over runs of a right model, of which it tells none from chance."""
    machine = Machine(
        mass=100.2, viscous=236.9, coulomb=24.8, has_tachometer=True, position_noise=white(3.8e-6)
    )
    found = []
    for columns in records(machine, twin.reference, 12, seed=11):
        result = identify(emps2015, read_record(columns, emps2015), methods=["idm-iv", "didim"])
        found.append(hausman(result["idm-iv"], result["didim"]))
    assert min(each.joint_p_value for of_one in found for each in of_one.values()) > 0.01
    for name in emps2015.names:
        apart = [of_one[name].difference for of_one in found]
        claimed = np.mean([of_one[name].deviation for of_one in found])
        assert 0.5 < claimed / np.std(apart, ddof=1) < 3
        assert abs(np.mean(apart)) < 3 * claimed / len(apart) ** 0.5


@pytest.mark.slow
def test_noise_of_the_position_parts_least_squares_and_instruments(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """And that of the control does not."""
    noises = {"position_noise": white(5e-6)}, {"control_noise": white(0.05)}
    for noise, names in zip(noises, (["M"], []), strict=True):
        machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, **noise)  # type: ignore[arg-type]
        for columns in records(machine, twin.reference, 2, seed=5):
            result = identify(
                emps2015, read_record(columns, emps2015), methods=["idm-ls", "idm-iv"], bootstrap=0
            )
            found = significant_differences(hausman(result["idm-ls"], result["idm-iv"]))
            assert [*found][:1] == names
            assert all(each.difference < 0 for name, each in found.items() if name == "M")


@pytest.mark.parametrize(
    ("p", "joint", "shift", "there"),
    [
        (0.001, 0.001, 3.0, True),
        (0.2, 0.001, 3.0, True),
        (0.001, 0.02, 9.0, False),
        (1e-9, 1e-9, 0.4, False),
    ],
)
def test_parameters_part_alone_or_together(
    p: float, joint: float, shift: float, *, there: bool
) -> None:
    one = HausmanTest(difference=1.0, deviation=0.1, p_value=p, joint_p_value=joint, shift=shift)
    assert bool(significant_differences({"M": one})) is there
