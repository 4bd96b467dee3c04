"""A check fails where it matters: nothing does on records that are right to 0.003 %."""

from collections.abc import Sequence

import pytest

from axisid import Identification, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis

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
@pytest.mark.parametrize(
    ("methods", "share"), [(None, 0.0), (None, 0.01), (["idm-ls"], 0.01), (["idm-iv"], 0.01)]
)
def test_nothing_fails_on_a_record_that_is_right(
    library_axis: GeneratedAxis, methods: Sequence[str] | None, share: float
) -> None:
    """Without noise, and with a hundredth of the twin's own."""
    experiment = library_axis.axis.experiment
    record = twin_record(library_axis, position_noise=share * experiment.position_noise)
    result = identify(library_axis, record, methods=methods)
    assert off(result) < RIGHT_OF.get(library_axis.axis.name, RIGHT)
    assert failing(result) == []
