"""What a record is filtered to, and what is said of one that the filter cannot serve."""

from dataclasses import replace

import pytest

from axisid import Prefilter, Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from tests.refusals import refuses


@pytest.mark.parametrize(
    ("factor", "told"),
    [
        (1e-3, "every 1 us, .* runs every 1 ms"),
        (1e3, "every 1 s, .* runs every 1 ms"),
        (60.0, "every 60 ms, .* runs every 1 ms"),
    ],
)
def test_time_in_another_unit_is_asked_about_before_the_filter(
    emps2015: GeneratedAxis, twin: Record, factor: float, told: str
) -> None:
    record = replace(twin, time=factor * twin.time, sample_period=None)
    with refuses("time-unit", says=f"{told}: is time's unit right.*As it stands, the"):
        identify(emps2015, record, Prefilter(cutoff=60.0))


def test_filter_that_does_not_suit_the_record_is_the_only_complaint_otherwise(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    for record in (twin, replace(twin, time=7 * twin.time, sample_period=None)):
        with refuses("cutoff-too-high", says=r"^the cutoff 900 Hz is not below"):
            identify(emps2015, record, Prefilter(cutoff=900.0))
