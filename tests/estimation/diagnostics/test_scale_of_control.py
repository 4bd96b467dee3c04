"""A control that is recorded a little too large or small fails where it moves a parameter far."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Record,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.diagnostics.control_law import LawReproduced
from axisid.estimation.diagnostics.scale_of_control import ControlScaleMoves
from axisid.estimation.verdict_checks import Check, belief
from axisid.modeling.quantities import Constant
from tests.unjudged import identify
from tests.verdicts import finding_of


def law_of(axis: GeneratedAxis, record: Record) -> Check:
    (law,) = (check for check in identify(axis, record).verdict if check.name == "control law")
    return law


def scaled(record: Record, scale: float) -> Record:
    return replace(record, control=scale * np.asarray(record.control))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scale", "status"), [(1.0, "pass"), (1.0099, "fail"), (0.9901, "fail"), (1.00001, "pass")]
)
def test_a_scale_within_one_percent_fails_by_what_it_moves(
    emps2015: GeneratedAxis, twin: Record, scale: float, status: str
) -> None:
    result = identify(emps2015, scaled(twin, scale))
    (law,) = (check for check in result.verdict if check.name == "control law")
    assert law.status == status
    assert (belief(result.verdict) == "not believed") == (status == "fail")
    if status == "fail":
        found = finding_of(law, ControlScaleMoves)
        assert found.scale == pytest.approx(scale, abs=1e-4)
        assert (found.unit, found.standard_errors) == (
            result.preferred.parameters[found.parameter].unit,
            law.figure,
        )
    else:
        assert finding_of(law, LawReproduced).residual_percent == law.figure


@pytest.mark.slow
def test_a_known_mass_is_part_of_what_the_scale_moves() -> None:
    declared = load_axis("emps2015")
    known = Constant(98.0, "kg").symbol
    assert declared.experiment is not None
    experiment = replace(declared.experiment, truth={"M": 2.2, "Fv": 236.9, "Fc": 24.8})
    force = declared.force + known * declared.coordinate.acceleration
    axis = build(replace(declared, force=force, experiment=experiment))
    record = twin_record(axis)
    right, moved = (
        identify(axis, each).preferred.parameters["M"] for each in (record, scaled(record, 1.005))
    )
    law = law_of(axis, scaled(record, 1.005))
    assert law.status == "fail"
    assert law.figure == pytest.approx((moved.value - right.value) / right.deviation, rel=0.1)


@pytest.mark.slow
def test_a_measured_force_has_nothing_of_the_scale_of_the_control(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    control = np.asarray(twin.control)
    force = emps2015.axis.drive.gain * control
    assert law_of(emps2015, replace(twin, control=1.005 * control, force=force)).status == "pass"


def test_rounding_of_the_position_is_no_scale_of_the_control() -> None:
    axis = build(load_axis("balanced_slide"))
    record, step = twin_record(axis, seed=0), 1e-6
    assert record.reference is not None
    rounded = replace(
        record,
        position=step * np.round(record.position / step),
        reference=step * np.round(record.reference / step),
    )
    assert law_of(axis, rounded).status == "pass"


def test_one_scaled_record_of_two_fails(emps2015: GeneratedAxis) -> None:
    one, other = (twin_record(emps2015, seed=seed) for seed in (1, 2))
    result = identify(emps2015, [one, scaled(other, 1.004)])
    (law,) = (check for check in result.verdict if check.name == "control law")
    assert law.status == "fail"
