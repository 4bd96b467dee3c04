"""Values of another order of size than declared are remarked, as a wrong unit makes them."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Parameter, Record, fit, identify, load_axis
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.estimates import nominal_check
from axisid.modeling import LIBRARY

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
    assert found is None or (found.status == "note" and f"{value / 10:.2g} times" in found.meaning)


@pytest.mark.parametrize("name", LIBRARY)
def test_no_axis_of_the_library_is_remarked(name: str) -> None:
    axis = load_axis(name)
    truth = axis.experiment.truth
    rows = [(p, truth[p.name], (truth[p.name],) * 2) for p in axis.parameters if p.name in truth]
    assert rows
    assert nominal_check(rows) is None


@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_position_in_another_unit_is_remarked_without_a_reference(
    emps2015: GeneratedAxis, twin: Record, factor: float
) -> None:
    given = replace(twin, position=factor * twin.position, reference=None)
    result = identify(emps2015, given, methods="idm-ls")
    remarks = [check.meaning for check in result.verdict if check.name == "nominal values"]
    assert len(remarks) == (factor != 1.0)
    assert all("M = " in said and "check the units" in said for said in remarks)


@pytest.mark.slow
def test_fit_remarks_it_too(emps2015: GeneratedAxis, twin: Record) -> None:
    given = replace(twin, position=10 * twin.position, reference=None)
    names = [check.name for check in fit(emps2015, given, output="open-loop").checks]
    assert "nominal values" in names
