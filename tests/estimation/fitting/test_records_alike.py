"""A machine that is another in one of several records is told; one that is the same is not."""

import re
from dataclasses import replace

import pytest

from axisid import Record, fit, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.fitting import OutputFit
from axisid.estimation.records import record_labels


def _records(axis: GeneratedAxis, *changes: dict[str, float]) -> list[Record]:
    """Twins, each of a machine with some parameters changed."""
    declared, experiment = axis.declared, axis.declared.experiment
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


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_a_payload_that_nobody_told_is_named_with_its_size(
    emps2015: GeneratedAxis, output: str
) -> None:
    records = _records(emps2015, {"M": 100.0}, {"M": 105.0}, {"M": 100.0})
    found = fit(emps2015, records, output)
    check = _alike(found)
    assert check.status == "fail"
    (own, others), *_ = re.findall(r"M is ([\d.]+) \+- .* and ([\d.]+) \+- ", check.meaning)
    assert check.meaning.startswith(f"{record_labels(records)[1]} speaks against the rest")
    assert (float(own), float(others)) == pytest.approx((105.0, 100.0), abs=0.3)
    assert "another load" in check.meaning
    assert not found.believed


def test_of_two_records_one_is_told_beside_the_other_and_what_lets_them_differ(
    emps2015: GeneratedAxis,
) -> None:
    records = _records(emps2015, {}, {"Fc": 26.0})
    check = _alike(fit(emps2015, records))
    assert check.status == "fail"
    figures = sorted(map(float, re.findall(r"(2[\d.]+) \+- ", check.meaning)))
    assert figures == pytest.approx([24.8, 26.0], abs=0.3)
    assert [s.value for s in check.remedy.settings if s.name == "local"] == ["Fc"]
    own = fit(emps2015, records, local="Fc")
    assert _alike(own).status == "pass"
    assert own.believed


def test_records_of_one_machine_are_alike(emps2015: GeneratedAxis) -> None:
    found = fit(emps2015, _records(emps2015, {}, {}))
    assert _alike(found).status == "pass"
    assert found.believed
