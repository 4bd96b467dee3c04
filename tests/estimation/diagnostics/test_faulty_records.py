"""Records with a plausible fault: something must say so."""

from dataclasses import replace

import pytest

from axisid import (
    Record,
    compare,
    friction_ladder,
    identify,
    load_axis,
    sweep,
    twin_record,
    validate,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks.check import Check
from tests.refusals import refuses


def failing(checks: tuple[Check, ...]) -> set[str]:
    return {check.name for check in checks if check.status == "fail"}


def test_negative_mass_is_out_of_bounds(emps2015: GeneratedAxis, twin: Record) -> None:
    flipped = replace(twin, control=-twin.control, reference=None)
    result = identify(emps2015, flipped, methods=["idm-ls"])
    assert "bounds" in failing(result.verdict)
    (check,) = (c for c in result.verdict if c.name == "bounds")
    assert "M = -" in check.meaning


@pytest.mark.slow
def test_comparison_and_sweep_pass_the_law_check_on(emps2015: GeneratedAxis, twin: Record) -> None:
    flipped = replace(twin, control=-twin.control)
    text = " ".join(compare(friction_ladder(load_axis("emps2015")), flipped).summary().split())
    assert "Believe nothing" in text
    assert "is outside its bounds [0, inf]" in text
    swept = sweep(emps2015, flipped, (40.0, 80.0), methods=["idm-ls"]).summary()
    assert "believe nothing before this is mended" in swept
    assert "believe nothing" not in sweep(emps2015, twin, (40.0,), methods=["idm-ls"]).summary()


def test_validation_that_is_not_finite_is_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin, methods=["idm-ls"])
    with refuses("not-finite"):
        validate(result, replace(twin, control=1e-200 * twin.control, reference=None))


def test_endless_twins_and_sweeps_and_lags_are_refused(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    from axisid.estimation.studies.sweep import default_cutoffs

    law = emps2015.axis.control
    with refuses("twin", says="1e-09"):
        twin_record(replace(emps2015.axis, control=replace(law, period=1e-9)))
    with refuses("sweep", says="500"):
        default_cutoffs(1000.0, points=10**6)
    with refuses("sweep"):
        sweep(emps2015, twin, [])
    with refuses("result"):
        identify(emps2015, twin, methods="idm-ls", lags=500)
