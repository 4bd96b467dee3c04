"""Instruments less DIDIM against a resampling of its own."""

import numpy as np
import pytest

from axisid import Record, identify, read_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.noise import second_opinion
from benchmarks.machines import Machine, records, white


@pytest.mark.slow
def test_deviation_of_the_difference_is_its_scatter(emps2015: GeneratedAxis, twin: Record) -> None:
    """Over runs of a right model, of which it tells none from chance."""
    assert twin.reference is not None
    machine = Machine(
        mass=100.2, viscous=236.9, coulomb=24.8, has_tachometer=True, position_noise=white(3.8e-6)
    )
    found = []
    for columns in records(machine, twin.reference, 12, seed=11):
        result = identify(emps2015, read_record(columns, emps2015), methods=["idm-iv", "didim"])
        found.append(second_opinion(result["idm-iv"], result["didim"]))
    assert min(each.joint_p_value for of_one in found for each in of_one.values()) > 0.01
    for name in emps2015.names:
        apart = [of_one[name].difference for of_one in found]
        claimed = np.mean([of_one[name].deviation for of_one in found])
        assert 0.5 < claimed / np.std(apart, ddof=1) < 3
        assert abs(np.mean(apart)) < 3 * claimed / len(apart) ** 0.5


def test_it_is_of_two_estimates_of_the_same_rows(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin, methods=["idm-iv", "ddm-iv", "didim"])
    (short,) = identify(emps2015, twin.windowed((None, 4.0)), methods="didim").estimates.values()
    didim = result["didim"]
    assert second_opinion(result["ddm-iv"], didim) == {}
    assert second_opinion(result["idm-iv"], short) == {}
    apart = second_opinion(result["idm-iv"], didim)
    expected = result["idm-iv"].corrected - didim.corrected
    assert [each.difference for each in apart.values()] == list(expected)
