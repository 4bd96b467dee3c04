"""What was fixed, against what the record says: shifted by known parts of its deviations."""

import pytest

from axisid import Record, fix, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.estimates import fixed_check
from axisid.estimation.estimates import Estimate


@pytest.fixture(scope="module")
def iv(emps2015: GeneratedAxis, twin: Record) -> Estimate:
    return identify(emps2015, twin, methods="idm-iv")["idm-iv"]


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
    assert (f"M is fixed at {value:.4g}"[:16] in check.meaning) is (status == "fail")
