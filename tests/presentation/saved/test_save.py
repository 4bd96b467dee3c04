"""What results are saved to, and read back from."""

from pathlib import Path

import pytest

from axisid import Identification, Record, fit, identify, load_result, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import validate_fit
from axisid.presentation.saved import SavedFitValidation
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
    with refuses("save-ending", says="give a name that ends in .json"):
        result.save(tmp_path / name if isinstance(name, str) else name)  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def test_what_no_result_is_saved_by_is_refused_with_what_it_takes(
    result: Identification, tmp_path: Path
) -> None:
    with refuses("save-option", says="not saved by 'full'; beside the file it takes draws"):
        result.save(tmp_path / "result.json", full=True)
    assert not [*tmp_path.iterdir()]
