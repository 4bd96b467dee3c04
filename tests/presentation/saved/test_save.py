"""What is saved is loaded and saved again the same, its drive with it."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from msgspec import UNSET

from axisid import (
    Identification,
    Parameter,
    Record,
    fit,
    identify,
    load_axis,
    load_result,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import Drive
from axisid.estimation import validate_fit
from axisid.presentation.saved import SavedFitValidation
from axisid.presentation.saved.file import refuse_differences
from axisid.presentation.saved.record import WrittenDriveTime, WrittenResponse
from tests.refusals import refuses


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis) -> Identification:
    return identify(emps2015, twin_record(emps2015), methods=["idm-ls"])


def test_what_is_saved_is_loaded_and_saved_again_the_same(
    result: Identification, tmp_path: Path
) -> None:
    file = result.save(tmp_path / "result.json")
    read = load_result(file)
    assert read.to_dict() == result.to_dict()
    assert read.save(tmp_path / "again.json").read_bytes() == file.read_bytes()


def test_a_validation_of_a_fit_is_printed_saved_and_loaded(
    emps2015: GeneratedAxis, twin: Record, tmp_path: Path
) -> None:
    fitted = fit(emps2015, twin, bootstrap=0)
    found = validate_fit(fitted, twin_record(emps2015, seed=2))
    read = load_result(found.save(tmp_path / "held.json"))
    assert isinstance(read, SavedFitValidation)
    assert read.to_dict() == found.to_dict()
    assert (read.summary(), read.belief, read.checks) == (
        found.summary(),
        found.belief,
        found.checks,
    )
    assert (read.percent, read.error, read.output) == (found.percent, found.error, found.output)


@pytest.mark.parametrize("name", ["result.txt", 3])
def test_other_names_are_refused(result: Identification, name: object, tmp_path: Path) -> None:
    with refuses("result-file", says="give a name that ends in .json"):
        result.save(tmp_path / name if isinstance(name, str) else name)  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def test_what_no_result_is_saved_by_is_refused_with_what_it_takes(
    result: Identification, tmp_path: Path
) -> None:
    with refuses("result-file", says="not saved by 'full'; beside the file it takes draws"):
        result.save(tmp_path / "result.json", full=True)
    assert not [*tmp_path.iterdir()]


FOUND = WrittenDriveTime(
    name="Tc", of="lag", nominal=1e-4, value=1e-3, sd=1e-5, interval_95=(9e-4, 1.1e-3)
)


def _lag(nominal: float) -> Parameter:
    return Parameter("Tc", "s", nominal=nominal)


@pytest.mark.parametrize(
    ("given", "found", "says"),
    [
        ({"lag": 2e-3}, UNSET, "lag 0.001"),
        ({"logged": "current"}, UNSET, "logged command"),
        ({"lag": _lag(1e-3)}, UNSET, "to be estimated"),
        ({"relative_sd": 0.02}, UNSET, "relative_sd 0.005"),
        ({}, UNSET, ""),
        # The start of a lag that was found is part of the drive.
        ({"lag": _lag(1e-4)}, FOUND, ""),
        ({"lag": _lag(1e-3)}, FOUND, ""),
        ({"lag": _lag(5e-4)}, FOUND, "estimated from 0.0001"),
    ],
)
def test_an_axis_with_another_drive_is_refused(
    given: dict[str, Any], found: Any, says: str
) -> None:
    written = WrittenResponse(lag=1e-3, delay=0.0, logged="command", estimated=found)
    estimate = SimpleNamespace(gain_relative_sd=0.005, physical=None)
    held = SimpleNamespace(drive=written, estimates=[estimate])
    drive = Drive(**{"gain": 35.0, "lag": 1e-3, "relative_sd": 0.005, **given})
    axis = replace(load_axis("emps2015"), drive=drive)
    with refuses("result-file", says) if says else nullcontext():
        refuse_differences(cast(Any, held), "result.json", axis)
