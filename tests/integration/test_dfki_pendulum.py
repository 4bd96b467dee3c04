"""The worked example on the DFKI pendulum: its document says what the code gives."""

import importlib
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Identification, Prefilter, identify, load_axis, sweep, validate
from axisid.estimation.diagnostics import Precision
from axisid.estimation.diagnostics.agreement_findings import (
    AgreementOfEstimates,
    InstrumentsAgainstOutputError,
    LeastSquaresAgainstInstruments,
    WeakestInstrument,
)
from tests.verdicts import finding_of

ROOT = Path(__file__).resolve().parents[2]
AXIS = ROOT / "examples" / "dfki_pendulum.py"
PAGES = (ROOT / "docs" / "dfki_pendulum.md", ROOT / "examples" / "dfki_pendulum_tables.md")
DOCUMENT = "\n".join(page.read_text() for page in PAGES)
RUN = "pd_system_identification_measured.csv"


@pytest.fixture(scope="module")
def study() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "examples"))
        yield importlib.import_module("dfki_pendulum_study")


@pytest.fixture(scope="module")
def folder(data_folder: Path) -> Path:
    found = data_folder / "dfki_pendulum"
    if not (found / RUN).is_file():
        pytest.skip(f"the DFKI pendulum's records are not in {found}")
    return found


@pytest.fixture(scope="module")
def data(study: ModuleType, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return study.read_data(folder, tmp_path_factory.mktemp("dfki"))


@pytest.fixture(scope="module")
def swept(study: ModuleType, data: Any) -> dict[float, Identification]:
    return {result.prefilter.cutoff: result for result in study.sweep_results(data)}


def numbers(text: str) -> list[float]:
    return [float(n) for n in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w])", text)]


def check_documented(key: Sequence[str], cells: Sequence[str]) -> None:
    """Find the document's row that starts with some cells; compare the numbers that follow."""
    start = "| " + " | ".join(key) + " |"
    rows = [line[len(start) :] for line in DOCUMENT.splitlines() if line.startswith(start)]
    computed = numbers(" | ".join(cells))
    fits = [
        np.allclose(numbers(r), computed, rtol=0.02, atol=2e-3)
        for r in rows
        if len(numbers(r)) == len(computed)
    ]
    assert any(fits), f"{start} {cells} is not in the document, which has {rows}"


def test_law_is_pd_on_the_reference_and_its_difference() -> None:
    law = load_axis(AXIS).control
    names = ("p", "d", "reference", "measured_position", "measured_velocity", "last_reference")
    p, d, r, q, v, last = (sympy.Symbol(name, real=True) for name in names)
    stated = p * (r - q) + d * ((r - last) / sympy.Symbol("period", positive=True) - v)
    assert sympy.expand(law.output - stated) == 0
    assert dict(law.gains) == {"p": 50.0, "d": 4.0}


def test_authors_recipe_gives_the_published_digits(study: ModuleType, data: Any) -> None:
    theta, error = study.authors_recipe(data.run, data.velocity["identification run"])
    assert [f"{value:.3e}" for value in theta[[0, 1, 2, 4]]] == [
        "6.259e-02",
        "1.022e-01",
        "4.707e-02",
        "-7.586e-02",
    ]
    assert f"{theta[3]:.3e}" == "1.839e-01"
    assert error == pytest.approx(74.6, abs=0.1)


@pytest.mark.parametrize("cutoff", [5.0, 15.0])
@pytest.mark.parametrize("name", ["identification run", "direct collocation", "DDP"])
def test_least_squares_is_that_of_numpy_on_scipys_filters(
    study: ModuleType,
    data: Any,
    name: str,
    cutoff: float,
) -> None:
    record = data.records[name]
    settings = study.prefilter(record, cutoff)
    estimate = identify(study.axis, record, settings, ["idm-ls"])["idm-ls"]
    regressor, torque = study.columns_by_hand(record, settings)
    expected = np.linalg.lstsq(regressor, torque, rcond=None)[0]
    assert estimate.physical == pytest.approx(expected, rel=1e-8, abs=1e-10)


@pytest.mark.slow
def test_document_has_the_recipe_and_the_records_by_themselves(
    study: ModuleType,
    data: Any,
) -> None:
    for row in study.recipe_table(data):
        check_documented(row[:2], row[2:])
    for name, cutoff, rows, J, mc, _, Fc, ratio, error in study.motions_table(data):
        check_documented([name, cutoff, rows], [J, mc, Fc, ratio, error])
    for row in study.weak_table(data):
        check_documented(row[:1], row[1:])


@pytest.mark.slow
def test_document_has_the_sweep_and_the_gains(
    study: ModuleType,
    data: Any,
    swept: dict[float, Identification],
) -> None:
    for row in study.sweep_table(list(swept.values())):
        cutoff, count, J_ls, _, J_iv, mc_ls, _, mc_iv, strength, p = row
        cells = [J_ls, J_iv, mc_ls, mc_iv, strength.split(",")[0], p]
        check_documented([cutoff, count], cells)
    rows = {row[0]: row[1:] for row in study.gains_table(data)}
    for gains in ("50 / 4", "40 / 4", "60 / 4", "50 / 3.2", "50 / 4.8", "25 / 2", "100 / 8"):
        check_documented([gains], rows[gains])
    check_documented(["50 / 4, reference one sample late"], list(rows.values())[-1])
    values = np.array([numbers(row[1])[0] for row in rows.values()])
    assert values == pytest.approx(values[0], rel=0.05)


@pytest.mark.slow
def test_document_has_the_stretches_and_what_they_hold(study: ModuleType, data: Any) -> None:
    documented, published = study.DOCUMENTED, dict(zip(("J", "mc"), study.PUBLISHED, strict=False))
    held = []
    for ends, rows, J, J_interval, mc, mc_interval in study.stretch_table(data):
        check_documented([ends, rows], [J, J_interval, mc, mc_interval])
        intervals = {"J": numbers(J_interval), "mc": numbers(mc_interval)}
        assert all(low < documented[name] < high for name, (low, high) in intervals.items())
        if all(low < published[name] < high for name, (low, high) in intervals.items()):
            held.append(ends)
    assert held == ["116 / 58", "116 / 116"]


@pytest.mark.slow
def test_document_has_the_weight_of_a_torque_sample(study: ModuleType, data: Any) -> None:
    rows = study.weight_table(data)
    for row in rows:
        check_documented(row[:1], row[1:])
    default, named = (abs(float(row[5])) for row in (rows[1], rows[3]))
    assert default < 0.004
    assert named > 20 * default
    assert max(abs(float(row[5])) for row in rows[:3]) < 0.02


@pytest.mark.slow
def test_instruments_are_those_of_numpy(
    study: ModuleType, data: Any, swept: dict[float, Identification]
) -> None:
    """Rows from SciPy's filters, of the record and of the loop simulated with the estimate."""
    hand = importlib.import_module("dfki_pendulum_data")
    found, settings = swept[15.0]["idm-iv"].physical, study.prefilter(data.run, 15.0)
    regressor, torque = study.columns_by_hand(data.run, settings)
    instruments = hand.instruments_by_hand(data.run, found, settings)
    expected = np.linalg.solve(instruments.T @ regressor, instruments.T @ torque)
    assert found[:2] == pytest.approx(expected[:2], rel=0.01)


@pytest.mark.slow
def test_document_has_the_frozen_estimates(study: ModuleType, data: Any) -> None:
    rows = study.validation_table(data)
    for row in rows:
        check_documented(row[:1], row[1:])
    published, least_squares, instruments = ([float(cell) for cell in row[1:]] for row in rows)
    assert least_squares[0] < instruments[0]
    for other in (published, least_squares):
        assert all(iv < 0.85 * value for iv, value in zip(instruments[1:], other[1:], strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["identification run", "direct collocation", "DDP"])
def test_validation_is_that_of_numpy_at_the_same_edges(
    study: ModuleType, data: Any, swept: dict[float, Identification], name: str
) -> None:
    record, result = data.records[name], swept[15.0]
    decimate = {"identification run": 8, "direct collocation": 9, "DDP": 14}[name]
    settings = Prefilter(cutoff=15.0, decimate=decimate, hold="raw", reversals="keep")
    for held in validate(result, record):
        if held.method.startswith("idm"):
            physical = result[held.method].physical
            expected = study.frozen_error(record, physical, settings)
            assert held.equation_error_percent == pytest.approx(expected, rel=1e-6)


@pytest.mark.slow
def test_document_has_the_timing_and_it_grows_with_the_cut_off(
    study: ModuleType, data: Any
) -> None:
    twins = importlib.import_module("dfki_pendulum_twins")
    rows = twins.delay_table(study.Data(records=slow(data.records), velocity={}))
    for name, cutoff, *cells in rows:
        if float(cutoff) >= 5:
            check_documented([name, cutoff], cells)
    found = {(name, float(cutoff)): float(best) for name, cutoff, best, *_ in rows}
    for name in slow(data.records):
        assert abs(found[name, 5.0]) < 5
        assert found[name, 15.0] - found[name, 5.0] > 12


def slow(records: Any) -> dict[str, Any]:
    """The smooth motions."""
    return {name: records[name] for name in ("direct collocation", "DDP")}


@pytest.mark.slow
def test_sweep_recommends_what_the_document_says(study: ModuleType, data: Any) -> None:
    base = Prefilter(hold="raw", reversals="keep")
    by_default = sweep(study.axis, data.run, prefilter=base)
    assert by_default.recommended == pytest.approx(13.6)
    chosen = next(r for r in by_default.results if r.prefilter.cutoff == by_default.recommended)
    assert chosen["idm-iv"].physical[:2] == pytest.approx([0.145, 0.285], abs=1e-3)
    assert sweep(study.axis, data.run, study.CUTOFFS, base).recommended == 10.0
    highest = by_default.results[-1]
    assert study.check_of(highest, "instrument strength").status == "fail"
    assert study.check_of(highest, "alignment").status == "not evaluated"


@pytest.mark.slow
def test_what_should_complain_complains(
    study: ModuleType, swept: dict[float, Identification]
) -> None:
    shown, weak = swept[15.0], swept[30.0]
    law = study.check_of(shown, "control law")
    assert law.status == "fail"
    assert law.figure == pytest.approx(76.8, abs=0.5)
    precision = study.check_of(shown, "precision")
    assert precision.status == "fail"
    unidentified = [
        [each.name for each in group.parameters]
        for group in finding_of(precision, Precision).unidentified
    ]
    assert ["Fv", "Fc", "tau0"] in unidentified
    assert study.check_of(shown, "simulation").status == "fail"
    compared = study.check_of(shown, "method")
    assert compared.status == "note"
    (finding,) = finding_of(compared, AgreementOfEstimates).findings
    assert isinstance(finding, LeastSquaresAgainstInstruments | InstrumentsAgainstOutputError)
    lower = [each.name for each in finding.comparison.differences if each.difference < 0]
    assert lower[:2] == ["J", "mc"]
    assert study.check_of(shown, "instrument strength").status == "pass"
    strength = study.check_of(weak, "instrument strength")
    assert strength.status == "fail"
    assert finding_of(strength, WeakestInstrument).column == "J"
    for cutoff in (5.0, 10.0, 15.0):
        assert study.check_of(swept[cutoff], "alignment").status == "not evaluated"
    p = {f: study.check_of(r, "method").p_value for f, r in swept.items()}
    assert p[5.0] > 0.05
    assert max(p[f] for f in (12.0, 15.0)) < 2e-3
    for cutoff in (20.0, 30.0, 60.0):
        for name in ("method", "alignment"):
            assert study.check_of(swept[cutoff], name).status == "not evaluated"
    assert study.check_of(swept[5.0], "rows").status == "fail"
    assert any("outside its bounds" in remark for remark in weak["idm-ls"].remarks)


@pytest.mark.slow
def test_instruments_hold_the_documented_masses_and_not_the_published(
    study: ModuleType, swept: dict[float, Identification]
) -> None:
    for cutoff in (8.0, 10.0, 12.0, 15.0, 20.0, 30.0):
        for i, name in enumerate(("J", "mc")):
            low, high = swept[cutoff]["idm-iv"].parameters[name].interval
            assert low < study.DOCUMENTED[name] < high
            assert not low < study.PUBLISHED[i] < high or (name, cutoff) == ("mc", 8.0)
