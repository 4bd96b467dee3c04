"""A machine that is another in one of several records is told; one that is the same is not."""

import re
from dataclasses import replace

import pytest

from axisid import Record, fit, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.fitting import OutputFit


def _records(axis: GeneratedAxis, *changes: dict[str, float]) -> list[Record]:
    """Twins, each of a machine with some parameters changed."""
    declared, experiment = axis.declared, axis.declared.experiment
    assert experiment is not None
    return [
        twin_record(
            replace(declared, experiment=replace(experiment, truth={**experiment.truth, **each})),
            seed=seed,
        )
        for seed, each in enumerate(changes)
    ]


def _alike(found: OutputFit) -> Check:
    (check,) = (each for each in found.checks if each.name == "records alike")
    return check


@pytest.mark.parametrize("output", ["control", "position"])
def test_a_payload_that_nobody_told_is_named_with_its_size(
    emps2015: GeneratedAxis, output: str
) -> None:
    records = _records(emps2015, {"M": 100.0}, {"M": 105.0}, {"M": 100.0})
    found = fit(emps2015, records, output)
    check = _alike(found)
    assert check.status == "fail"
    (more,) = re.findall(r"M is ([\d.]+) \+- .* more in record 2 than in the others", check.meaning)
    assert float(more) == pytest.approx(5.0, abs=0.2)
    assert not found.believed


def test_of_two_records_one_is_told_beside_the_other_and_what_lets_them_differ(
    emps2015: GeneratedAxis,
) -> None:
    records = _records(emps2015, {}, {"Fc": 26.0})
    check = _alike(fit(emps2015, records))
    assert check.status == "fail"
    assert re.search(
        r"Fc is 1\.\d+ \+- .* (less in record 1 than in record 2|"
        "more in record 2 than in record 1)",
        check.meaning,
    )
    own = fit(emps2015, records, local="Fc")
    assert _alike(own).status == "pass"
    assert own.believed


def test_records_of_one_machine_are_alike(emps2015: GeneratedAxis) -> None:
    """25 pairs by control and 15 triples by position had no chance below 29 %."""
    found = fit(emps2015, _records(emps2015, {}, {}))
    assert _alike(found).status == "pass"
    assert found.believed


def test_a_record_by_itself_is_not_asked(emps2015: GeneratedAxis, twin: Record) -> None:
    assert all(check.name != "records alike" for check in fit(emps2015, twin).checks)
