"""The page of an identification: what has one cause is told once."""

from dataclasses import replace

import pytest

from axisid import Record, build, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis


@pytest.mark.slow
@pytest.mark.parametrize("lacking", ["reference", "law"])
def test_a_log_without_a_loop_is_led_to_a_fit_of_the_open_loop_once(
    emps2015: GeneratedAxis, twin: Record, lacking: str
) -> None:
    axis, record = emps2015, replace(twin, reference=None)
    if lacking == "law":
        axis, record = build(replace(emps2015.axis, control=None)), twin
    page = " ".join(identify(axis, record).summary().split())
    assert (
        page.count("has no reference column" if lacking == "reference" else "no control law") == 1
    )
    assert page.count('fit(axis, record, "open-loop")') == 1
    assert "law, loop" in page
    assert "without idm-iv, ddm-iv, didim: see the verdict" in page
