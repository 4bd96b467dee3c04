"""The worked example on the DFKI pendulum: its document says what the code gives."""

import importlib
import json
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Identification, identify, load_axis

ROOT = Path(__file__).resolve().parents[2]
AXIS = ROOT / "examples" / "dfki_pendulum.py"
DOCUMENT = (ROOT / "docs" / "dfki_pendulum.md").read_text()
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
    fits = [np.allclose(numbers(r), computed, rtol=0.02, atol=2e-3) for r in rows if same(r, cells)]
    assert any(fits), f"{start} {cells} is not in the document, which has {rows}"


def same(row: str, cells: Sequence[str]) -> bool:
    return len(numbers(row)) == len(numbers(" | ".join(cells)))


def test_equation_of_motion_is_the_one_that_is_stated() -> None:
    axis = load_axis(AXIS)
    J, mc, Fv, Fc, tau0 = (p.symbol for p in axis.parameters)
    q, dq, ddq = (getattr(axis.coordinate, n) for n in ("symbol", "velocity", "acceleration"))
    stated = J * ddq + mc * sympy.Float(9.81) * sympy.sin(q) + Fv * dq + Fc * sympy.sign(dq) + tau0
    assert sympy.expand(axis.force - stated) == 0


def test_law_is_pd_on_the_reference_and_its_difference() -> None:
    law = load_axis(AXIS).control
    assert law is not None
    names = ("p", "d", "reference", "measured_position", "measured_velocity", "last_reference")
    p, d, r, q, v, last = (sympy.Symbol(name, real=True) for name in names)
    stated = p * (r - q) + d * ((r - last) / sympy.Symbol("period", positive=True) - v)
    assert sympy.expand(law.output - stated) == 0
    assert dict(law.gains) == {"p": 50.0, "d": 4.0}


def test_figures_of_the_document_are_there_and_small() -> None:
    figures = re.findall(r"\]\((figures/\w+\.png)\)", DOCUMENT)
    assert len(figures) == 4
    for figure in figures:
        assert 10_000 < (ROOT / "docs" / figure).stat().st_size < 150_000


def test_documented_values_follow_from_the_masses(study: ModuleType) -> None:
    """0.676 kg with its centre of gravity at 0.45 m, as the rig's description has it."""
    assert study.DOCUMENTED["mc"] == pytest.approx(0.676 * 0.45, rel=0.005)
    assert study.DOCUMENTED["J"] == pytest.approx(0.150, abs=5e-4)


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


def test_document_has_the_recipe_and_the_records_by_themselves(
    study: ModuleType,
    data: Any,
) -> None:
    for row in study.recipe_table(data):
        check_documented(row[:2], row[2:])
    motions, weak = study.motions_table(data), study.weak_table(data)
    for motion, integrated in zip(motions, weak, strict=True):
        name, J, mc, _, Fc, ratio, error = motion
        check_documented([name], [J, mc, Fc, ratio, error, *integrated[1:3]])


def test_document_has_the_sweep_and_the_gains(
    study: ModuleType,
    data: Any,
    swept: dict[float, Identification],
) -> None:
    for cutoff, J_ls, _, J_iv, mc_ls, _, mc_iv, *_ in study.sweep_table(list(swept.values())):
        if float(cutoff) >= 5:
            line = next(row for row in DOCUMENT.splitlines() if row.startswith(f"| {cutoff} | "))
            computed = numbers(" ".join([J_ls, J_iv, mc_ls, mc_iv]))
            assert numbers(line)[1:9] == pytest.approx(computed, rel=0.02, abs=2e-3)
    rows = {row[0]: row[1:] for row in study.gains_table(data)}
    for gains in ("50 / 4", "40 / 4", "60 / 4", "50 / 3.2", "50 / 4.8", "25 / 2", "100 / 8"):
        check_documented([gains], rows[gains])
    check_documented(["50 / 4, reference one sample late"], list(rows.values())[-1])
    values = np.array([numbers(row[1])[0] for row in rows.values()])
    assert np.ptp(values) < 0.02 * values[0]


def test_document_has_the_frozen_estimates(study: ModuleType, data: Any) -> None:
    rows = study.validation_table(data)
    for row in rows:
        check_documented(row[:1], row[1:])
    published, least_squares, instruments = ([float(cell) for cell in row[1:]] for row in rows)
    for other in (published, least_squares):
        assert all(iv < 0.5 * value for iv, value in zip(instruments[1:], other[1:], strict=True))


def test_document_has_the_timing(study: ModuleType, data: Any) -> None:
    record = data.records["direct collocation"]
    errors, physical = study.delay_profile(record, 5.0, study.DELAYS)
    best, none = int(errors.argmin()), int(np.abs(study.DELAYS).argmin())
    figures = [1e3 * study.DELAYS[best], errors[best], errors[none]]
    moved = [physical[none, 1], physical[best, 1]]
    cells = [*(f"{f:.1f}" for f in figures), *(f"{m:.3f}" for m in moved)]
    check_documented(["direct collocation", "5"], cells)


def test_what_should_complain_complains(
    study: ModuleType, swept: dict[float, Identification]
) -> None:
    shown, weak = swept[15.0], swept[30.0]
    law = study.check_of(shown, "control law")
    assert law.status == "fail"
    assert law.figure == pytest.approx(78.1, abs=0.5)
    precision = study.check_of(shown, "precision")
    assert precision.status == "fail"
    assert "Fv, Fc, tau0" in precision.meaning
    assert study.check_of(shown, "instrument strength").status == "pass"
    strength = study.check_of(weak, "instrument strength")
    assert strength.status == "fail"
    assert re.search(r"\bJ\b", strength.meaning)
    assert study.check_of(shown, "alignment").status != "pass"
    p = {
        f: study.check_of(r, "least squares against instruments").p_value for f, r in swept.items()
    }
    assert p[5.0] > 0.05
    assert max(p[f] for f in (12.0, 15.0, 20.0, 30.0, 60.0)) < 1e-6
    assert any("few" in remark for remark in swept[5.0]["idm-iv"].remarks)
    assert any("outside its bounds" in remark for remark in weak["idm-ls"].remarks)


def test_instruments_hold_the_documented_masses_and_not_the_published(
    study: ModuleType, swept: dict[float, Identification]
) -> None:
    for cutoff in (10.0, 12.0, 15.0, 20.0, 30.0):
        for i, name in enumerate(("J", "mc")):
            low, high = swept[cutoff]["idm-iv"].parameters[name].interval
            assert low < study.DOCUMENTED[name] < high
            assert not low < study.PUBLISHED[i] < high


def test_shaking_alone_pulls_the_recipe_down_and_not_the_instruments(
    study: ModuleType,
    data: Any,
    swept: dict[float, Identification],
) -> None:
    truth = swept[15.0]["idm-iv"].physical
    shaken = study.twin(data, truth, 0, spiked=False)
    theta, _ = study.authors_recipe(shaken.run, shaken.velocity["identification run"])
    result = identify(study.axis, shaken.run, study.prefilter(shaken.run, 15.0), ["idm-iv"])
    assert theta[:2] == pytest.approx([0.052, 0.079], abs=2e-3)
    assert result["idm-iv"].physical[:2] == pytest.approx(truth[:2], rel=0.03)


def test_command_line_reads_the_joined_and_the_measured_file(
    run: Callable[..., tuple[int, str, str]],
    study: ModuleType,
    folder: Path,
    tmp_path: Path,
) -> None:
    study.read_data(folder, tmp_path)
    settings = "--cutoff 15 --decimate 8 --hold raw --json -".split()
    code, out, _ = run("identify", AXIS, tmp_path / "dfki_joined.csv", *settings)
    assert code == 0
    values = {e["method"]: e["parameters"]["mc"]["value"] for e in json.loads(out)["estimates"]}
    assert values["idm-iv"] == pytest.approx(0.340, abs=1e-3)
    assert values["idm-ls"] == pytest.approx(0.184, abs=1e-3)
    code, out, err = run("identify", AXIS, folder / RUN, *settings)
    assert code == 0
    assert "no reference column" in err
    assert {e["method"] for e in json.loads(out)["estimates"]} == {"idm-ls", "ddm-ls"}
