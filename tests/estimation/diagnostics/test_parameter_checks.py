"""Parameters against what was fixed and their nominal values, and rows enough for them."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Parameter,
    Prefilter,
    Record,
    fit,
    fix,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics import fixed_check, nominal_check
from axisid.estimation.diagnostics.parameter_findings import (
    FarFromNominalValues,
    FewRows,
    FixedValues,
)
from axisid.estimation.estimates import Estimate
from axisid.modeling import LIBRARY
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of


def test_rows_that_are_few_for_the_parameters_are_not_believed(emps2015: GeneratedAxis) -> None:
    result = identify(emps2015, twin_record(emps2015), Prefilter(decimate=400), "idm-ls")
    found = checks_of(result)["rows"]
    assert (found.status, result.belief) == ("fail", "with care")
    assert found.figure == len(result.preferred.y) / 3 < found.threshold == 10
    rows = finding_of(found, FewRows)
    assert (rows.rows, rows.parameters) == (len(result.preferred.y), 3)


@pytest.fixture(scope="module")
def iv(emps2015: GeneratedAxis, twin: Record) -> Estimate:
    return identify(emps2015, twin, methods="idm-iv")["idm-iv"]


@pytest.mark.slow
@pytest.mark.parametrize(("deviations", "status"), [(1.0, "pass"), (4.0, "fail")])
def test_a_value_that_is_fixed_may_be_off_by_what_the_record_leaves_open(
    emps2015: GeneratedAxis, twin: Record, iv: Estimate, deviations: float, status: str
) -> None:
    """At 1 %, one degree of freedom allows 2.6 deviations."""
    mass = iv.parameters["M"]
    value = mass.corrected + deviations * mass.sd_hac
    result = identify(fix(emps2015.axis, M=value), twin, methods="idm-iv")
    check = fixed_check(result["idm-iv"])
    assert check.status == status
    assert (check.p_value < 0.01) is (status == "fail")
    found = finding_of(check, FixedValues)
    assert found.agree is (status == "pass")
    assert [(each.name, each.value) for each in found.values] == [("M", value)]


MASS = Parameter("m", "kg", nominal=10.0, lower=0.0)


@pytest.mark.parametrize(
    ("value", "interval", "remarked"),
    [
        (10.0, (9.0, 11.0), False),
        (1.0, (0.9, 1.1), True),
        (1.9, (1.5, 2.3), False),
        (60.0, (55.0, 65.0), True),
        (60.0, (45.0, 75.0), False),
        (0.0, (0.0, 0.0), True),
        (-10.0, (-11.0, -9.0), True),
        (60.0, (-np.inf, np.inf), False),
    ],
)
def test_a_value_is_remarked_where_all_of_its_interval_is_far(
    value: float, interval: tuple[float, float], remarked: bool
) -> None:
    found = nominal_check([(MASS, value, interval)])
    assert (found is not None) == remarked
    if found is not None:
        (far,) = finding_of(found, FarFromNominalValues).parameters
        assert (found.status, far.ratio, far.nominal) == ("note", value / 10, 10.0)


@pytest.mark.parametrize(
    ("nominal", "value", "deviation", "remarked"),
    [
        (5.0, 5000.0, 10.0, True),
        (5.0, 0.005, 1e-5, True),
        (5.0, -5000.0, 10.0, True),
        (-5.0, 5000.0, 10.0, True),
        (5.0, -6.0, 0.1, False),
        (5.0, 0.1, 2.0, False),
        (0.0, 5000.0, 10.0, False),
    ],
)
def test_a_value_of_either_sign_is_remarked_by_its_size(
    nominal: float, value: float, deviation: float, remarked: bool
) -> None:
    parameter = Parameter("m", "kg", nominal=nominal)
    interval = (value - 2 * deviation, value + 2 * deviation)
    assert (nominal_check([(parameter, value, interval)]) is not None) == remarked


@pytest.mark.parametrize("name", LIBRARY)
def test_no_axis_of_the_library_is_remarked(name: str) -> None:
    axis = load_axis(name)
    truth = axis.experiment.truth
    rows = [(p, truth[p.name], (truth[p.name],) * 2) for p in axis.parameters if p.name in truth]
    assert rows
    assert nominal_check(rows) is None


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_position_in_another_unit_is_remarked_without_a_reference(
    emps2015: GeneratedAxis, twin: Record, factor: float
) -> None:
    given = replace(twin, position=factor * twin.position, reference=None)
    result = identify(emps2015, given, methods="idm-ls")
    checks = (*result.verdict, *fit(emps2015, given, output="open-loop").checks)
    remarks = [check for check in checks if check.name == "nominal values"]
    assert len(remarks) == 2 * (factor != 1.0)
    for check in remarks:
        assert "M" in [each.name for each in finding_of(check, FarFromNominalValues).parameters]
