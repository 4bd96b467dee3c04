"""Every finding on several records has a sentence with its numbers, names and remedies."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics.overlapping_records import CommonSamples, RepeatedSamples
from axisid.estimation.diagnostics.pooling_findings import (
    ComparedRecords,
    DifferingParameter,
    OddRecord,
    UnidentifiedInRecord,
)
from axisid.estimation.findings import Finding
from axisid.support.settings import setting

COMMON = CommonSamples(names=("a", "b"), samples=100, spans=((10.0, 10.099), (0.0, 0.099)))
MASS = DifferingParameter(
    name="M", own=103.2, common=100.2, standard_error=0.06, unit="kg", is_load=True
)
FRICTION = replace(MASS, name="Fc", own=26.0, common=24.8, unit="N", is_load=False)
ODD = OddRecord(name="run 3", other=None, parameters=(MASS, FRICTION), matters=True)
RECORDS = ComparedRecords(
    odd=ODD, largest_percent=3.14, least_percent=1.0, output="force", unidentified=()
)
NUMBERS = ["M is 103.2 kg in run 3", "100.2 kg", "+3 +- 0.06 kg", "3.1 % of the force"]
UNIDENTIFIED = (
    UnidentifiedInRecord(record="one", parameters=("b", "c")),
    UnidentifiedInRecord(record="two", parameters=()),
)


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (
            RepeatedSamples(pairs=(COMMON,), repetitions=4.0),
            ["a and b have 100 samples", "10 to 10.099 s", "0 to 0.099 s", "2 times too small"],
        ),
        (
            RECORDS,
            [
                *NUMBERS,
                "Fc is 26 N",
                "Another load changes M ",
                setting("known", {"NAME": ("V1", "V2")}),
                setting("local", ("M", "Fc")),
            ],
        ),
        (replace(RECORDS, odd=replace(ODD, other="run 1")), [*NUMBERS, "in run 1"]),
        (replace(RECORDS, odd=replace(ODD, matters=False)), [*NUMBERS, "1 % of the force"]),
        (
            replace(RECORDS, odd=None, output="output", unidentified=UNIDENTIFIED),
            ["3.1 % of the output", "one alone does not identify b and c", "two alone"],
        ),
    ],
)
def test_every_number_and_remedy_is_in_the_sentence(finding: Finding, parts: list[str]) -> None:
    assert [part for part in parts if part not in finding.sentence] == []


def test_only_a_mass_or_an_inertia_is_said_to_be_a_load() -> None:
    friction = replace(RECORDS, odd=replace(ODD, parameters=(FRICTION,)))
    assert "nother load" not in friction.sentence
