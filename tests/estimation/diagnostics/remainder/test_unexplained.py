"""What is left in the residuals: a constant force; nothing where the model is right."""

import re
from dataclasses import replace

import pytest
import sympy

from axisid import Identification, Parameter, Record, build, identify, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks.check import Check

GAIN = 35.15


def found(result: Identification, name: str) -> Check:
    (check,) = (c for c in result.verdict if c.name == name)
    return check


def of_plant(*parameters: Parameter, force: object, truth: dict[str, float]) -> Record:
    """The twin of the paper's axis with terms that its model lacks."""
    axis = load_axis("emps2015")
    assert axis.experiment is not None
    return twin_record(
        replace(
            axis,
            name="plant",
            parameters=(*axis.parameters, *parameters),
            force=axis.force + force,
            experiment=replace(axis.experiment, truth={**axis.experiment.truth, **truth}),
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("methods", [["idm-ls"], ["idm-ls", "idm-iv"]])
def test_an_offset_of_the_plant_is_proposed_with_its_size(methods: list[str]) -> None:
    F0 = Parameter("F0", "N")
    record = of_plant(F0, force=F0.symbol, truth={"F0": 5.0})
    check = found(identify(load_axis("emps2015"), record, methods=methods), "constant force")
    assert check.status == "fail"
    assert check.meaning.startswith("a constant force of 5 ")
    assert "(offset(F0), F0 about 5)" in check.meaning


@pytest.mark.slow
def test_a_constant_that_a_missing_term_may_make_is_no_second_fault() -> None:
    """Viscous friction that differs with the direction has a mean."""
    axis = load_axis("emps2015")
    K = Parameter("K", "N/(m/s)")
    speed = sympy.Abs(axis.coordinate.velocity)
    record = of_plant(K, force=K.symbol * speed, truth={"K": 60.0})
    result = identify(axis, record)
    assert found(result, "missing terms").status == "fail"
    constant = found(result, "constant force")
    assert constant.status == "note"
    assert constant.meaning.endswith("left in the residuals: the missing term may make it")


@pytest.mark.slow
def test_a_converter_that_is_off_is_told_from_an_offset(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    assert twin.control is not None
    result = identify(emps2015, replace(twin, control=twin.control + 2 / GAIN))
    check = found(result, "constant force")
    assert check.status == "fail"
    told = re.search(r"in the recorded control \(([-\d.]+)\) and not in the law", check.meaning)
    assert told is not None
    assert float(told[1]) == pytest.approx(2 / GAIN, rel=0.01)


@pytest.mark.slow
def test_a_model_with_an_offset_has_none_left(emps: GeneratedAxis) -> None:
    assert found(identify(emps, twin_record(emps)), "constant force").status == "pass"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["emps2015", "pendulum", "belt_axis", "rotary_table", "crank"])
def test_nothing_is_left_by_right_models(name: str, seed: int) -> None:
    axis = build(load_axis(name))
    result = identify(axis, twin_record(axis, seed=seed), methods=["idm-ls", "idm-iv"])
    assert found(result, "constant force").status == "pass"


def test_a_direct_model_alone_is_not_asked_for_a_constant(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = identify(emps2015, twin, methods="ddm-ls")
    assert found(result, "constant force").status == "not evaluated"
