"""A check fails where it matters: nothing does on records that are right to 0.003 %."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, build, identify, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics.estimates import forms_apart_check

RIGHT = 0.003  # percent
#: Where the twin has whole counts, and friction that a dead time delays.
RIGHT_OF = {"servo_joint": 0.02, "valve": 0.006}


def failing(result: Identification) -> list[str]:
    return [check.name for check in result.verdict if check.status == "fail"]


def off(result: Identification) -> float:
    """Largest error of a parameter by any method, percent."""
    truth = result.record.provenance.truth
    return max(
        100 * abs(value.corrected / truth[name] - 1)
        for estimate in result.estimates.values()
        for name, value in estimate.parameters.items()
        if truth.get(name)
    )


@pytest.mark.slow
@pytest.mark.parametrize("methods", [None, ["idm-ls"], ["idm-iv"]])
@pytest.mark.parametrize("share", [0.0, 0.01])
def test_nothing_fails_on_a_record_that_is_right(
    library_axis: GeneratedAxis, methods: Sequence[str] | None, share: float
) -> None:
    """Without noise, and with a hundredth of the twin's own."""
    experiment = library_axis.axis.experiment
    assert experiment is not None
    record = twin_record(library_axis, position_noise=share * experiment.position_noise)
    result = identify(library_axis, record, methods=methods)
    assert off(result) < RIGHT_OF.get(library_axis.axis.name, RIGHT)
    assert failing(result) == []


def check_of(result: Identification) -> Check:
    return next(c for c in result.verdict if c.name == "inverse against direct")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["vertical_screw", "belt_axis"])
def test_the_two_forms_are_compared_where_no_one_correlation_parts_them(name: str) -> None:
    """Friction of a load or of each direction: parameter by parameter."""
    library = load_axis(name)
    twin = replace(twin_record(build(library)), reference=None)
    axis = build(replace(library, control=None))
    forms = ["idm-ls", "ddm-ls"]
    assert check_of(identify(axis, twin, methods=forms)).status == "pass"
    rng = np.random.default_rng(0)
    noise = rng.normal(0.0, 5e-4 * float(np.ptp(twin.position)), len(twin))
    result = identify(axis, replace(twin, position=twin.position + noise), methods=forms)
    alone = check_of(result)
    assert alone.status == "fail"
    assert "by idm-ls and" in alone.meaning
    assert "without instruments nothing tells" in alone.meaning
    beside = forms_apart_check(result["idm-ls"], result["ddm-ls"], by_instruments=True)
    assert beside.status == "note"
    assert "believe the instruments" in beside.meaning


def test_the_two_forms_are_compared_over_several_records(emps2015: GeneratedAxis) -> None:
    records = [replace(twin_record(emps2015, seed=seed), reference=None) for seed in (1, 2)]
    assert check_of(identify(emps2015, records)).status != "not evaluated"
