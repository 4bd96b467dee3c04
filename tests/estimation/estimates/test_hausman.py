"""Two estimates of the same rows against each other, and against a resampling."""

from itertools import pairwise

import numpy as np
import pytest

from axisid import Identification, Record, identify, read_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.estimates import Estimate, HausmanTest, hausman, significant_differences
from axisid.support.errors import Missing
from benchmarks.machines import Machine, records, white


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


def less(one: Estimate, other: Estimate) -> dict[str, HausmanTest]:
    return hausman(one, other)


def test_it_is_the_difference_of_what_is_less_its_bias(result: Identification) -> None:
    for one, other in pairwise(("idm-ls", "idm-iv", "didim")):
        expected = result[one].corrected - result[other].corrected
        found = less(result[one], result[other])
        assert [each.difference for each in found.values()] == list(expected)


def test_two_solvers_of_one_system_differ_by_nothing(result: Identification) -> None:
    """IDM-IV and DDM-IV solve the same equations by the same instruments."""
    found = less(result["idm-iv"], result["ddm-iv"])
    assert max(each.shift for each in found.values()) < 1e-2
    assert significant_differences(found) == {}


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
        found.append(less(result["idm-iv"], result["didim"]))
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
            found = significant_differences(less(result["idm-ls"], result["idm-iv"]))
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
