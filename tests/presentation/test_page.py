"""The report: complete, self-contained, and safe whatever names a file brings."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import (
    Identification,
    Prefilter,
    Record,
    __version__,
    build,
    load_axis,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import Sweep
from axisid.estimation.verdict_checks import conclusion
from axisid.presentation.documents import readable_text
from axisid.presentation.page import report_html, report_sweep, script_json, thinned
from axisid.presentation.sentences import conclusion_text
from tests.command_line import Refused, Run
from tests.pages import Page
from tests.unjudged import identify

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&<!--"
FIGURES = (
    "force friction convergence tracking autocorrelation spectrum repeats sweep record".split()
)


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, Prefilter(reversals="keep"))


@pytest.fixture(scope="module")
def swept(result: Identification) -> Sweep:
    return report_sweep(result)


@pytest.fixture(scope="module")
def page(result: Identification, swept: Sweep) -> Page:
    return Page(report_html(result, swept, command="axisid identify emps2015 --cutoff 60"))


def squeezed(text: str) -> str:
    """Without blanks, which elements within a sentence bring."""
    return "".join(text.split())


def values(reference: Any, arrays: list[str]) -> np.ndarray:
    if isinstance(reference, int):
        return np.frombuffer(base64.b64decode(arrays[reference]), dtype="<f4").astype(float)
    count = np.arange(reference["count"])
    return np.asarray(reference["start"] + reference["step"] * count, dtype=float)


@pytest.mark.slow
def test_nothing_comes_from_outside(result: Identification, swept: Sweep) -> None:
    """And the same result gives the same page."""
    text = report_html(result, swept)
    assert report_html(result, swept) == text
    page = Page(text)
    assert page.opened == []
    links = [a[n] for _, a in page.elements for n in ("src", "href", "action", "data") if n in a]
    assert all(link and link.startswith("#") for link in links)
    assert not page.tags("link")
    assert not page.tags("iframe")
    assert re.findall(r"https?://[^\"'\s]+", text) == ["http://www.w3.org/2000/svg"]
    assert not re.search(r"@import|url\((?!#)", text)


@pytest.mark.slow
def test_the_policy_lets_only_the_pages_own_script_and_style_run(page: Page) -> None:
    policy = next(a["content"] for a in page.tags("meta") if "http-equiv" in a)
    assert policy.startswith("default-src 'none'")
    for text in (page.texts["script"][1], page.texts["style"][0]):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert not any("style" in attributes for _, attributes in page.elements)
    assert not any(name.startswith("on") for _, a in page.elements for name in a)


@pytest.mark.slow
def test_the_page_says_everything(page: Page, result: Identification) -> None:
    text = page.text
    assert [p["name"] for p in page.data["plots"]] == FIGURES
    for figure in FIGURES:
        assert any(a.get("id") == f"plot-{figure}" for a in page.tags("div"))
    for check in result.verdict:
        assert check.name.lower() in text.lower()
        if check.status == "fail":
            assert squeezed(readable_text(check.meaning)) in squeezed(text)
    headline = conclusion_text(conclusion(result.verdict))
    assert headline in text
    judged, interval = result.diagnosis.preferred.upper(), result.preferred["M"].interval
    assert judged == "DIDIM"
    begins = text.index(f"{interval[0]:.3f} to {interval[1]:.3f}")
    assert text.index(headline) < begins < text.index("equation error")
    for part in (
        f"axisid {__version__}",
        f"numpy {np.__version__}",
        f"sympy {sympy.__version__}",
        result.axis.signature,
        "twin of emps2015",
        "axisid identify emps2015 --cutoff 60",
        "Butterworth, 60 Hz, order 4",
        "48 samples are dropped at the start and 48 at the end",
        "N/(m/s)",
        "viscous friction",
    ):
        assert part in text, part


@pytest.mark.slow
def test_a_twin_is_called_simulated_and_a_measurement_is_not(
    page: Page, result: Identification
) -> None:
    assert "SIMULATED." in page.text
    assert "M = 100.2 kg" in page.text
    assert "truth M = 100.2 kg" in page.text
    provenance = replace(result.record.provenance, truth={})
    measured = replace(
        result,
        problem=replace(
            result.problem,
            data=(replace(result.data, record=replace(result.record, provenance=provenance)),),
        ),
    )
    assert "SIMULATED" not in Page(report_html(measured)).text


def test_curves_are_those_of_the_result(page: Page, result: Identification) -> None:
    data = page.data
    force = data["plots"][0]["panels"][0]["series"]
    estimate = result["didim"]
    measured = next(s for s in force if s["label"] == "measured")
    assert values(measured["y"], data["arrays"]) == pytest.approx(estimate.y, rel=1e-6)
    time = values(measured["x"], data["arrays"])
    assert time == pytest.approx(estimate.rows * estimate.period)
    error = next(s for s in force if s["label"] == "residual, DIDIM")
    assert values(error["y"], data["arrays"]) == pytest.approx(estimate.residuals, rel=1e-6)


def hostile(result: Identification) -> Identification:
    provenance = replace(
        result.record.provenance,
        source=HOSTILE,
        sha256=HOSTILE,
        columns={"position": HOSTILE, "time": "${script}$"},
    )
    title = HOSTILE.replace("'", "")
    axis = replace(result.axis, axis=replace(result.axis.axis, title=title))
    record = replace(result.record, provenance=provenance)
    data = replace(result.data, axis=axis, record=record)
    problem = replace(result.problem, axis=axis, data=(data,))
    return replace(result, problem=problem, skipped={"ddm-ls": HOSTILE})


@pytest.mark.slow
def test_names_from_files_stay_text(page: Page, result: Identification) -> None:
    text = report_html(hostile(result), command=f"axisid identify '{HOSTILE}'")
    spoiled = Page(text)
    assert [tag for tag, _ in spoiled.elements].count("script") == 2
    assert not spoiled.tags("img")
    assert spoiled.text.count(" ".join(HOSTILE.split())) >= 4
    assert "position = " + HOSTILE in spoiled.text
    assert "${script}$" in spoiled.text
    assert spoiled.texts["script"][1] == page.texts["script"][1]


@pytest.mark.parametrize("text", [HOSTILE, "\u2028\u2029", "]]>", "<!--<script>"])
def test_data_cannot_end_their_script(text: str) -> None:
    written = script_json({text: [text]})
    assert not set(written) & set("<>&\u2028\u2029")
    assert json.loads(written) == {text: [text]}


def test_thinning_keeps_every_extreme_and_even_steps() -> None:
    rng = np.random.default_rng(7)
    x, y = np.arange(100_001) * 1e-4, rng.normal(size=100_001)
    y[54_321], y[99_999] = 50.0, -60.0
    few_x, few_y = thinned(x, y, 1000)
    assert len(few_x) == len(few_y) <= 1002
    assert (few_y.max(), few_y.min()) == (50.0, -60.0)
    assert np.diff(few_x) == pytest.approx(few_x[1] - few_x[0])
    width = few_x[1] - few_x[0]
    assert few_x[np.argmax(few_y)] == pytest.approx(5.4321, abs=2 * width)


@pytest.mark.slow
def test_what_cannot_be_drawn_is_said_in_its_place(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(build(replace(emps2015.axis, control=None)), twin)
    page = Page(report_html(result, report_sweep(result)))
    drawn = [p["name"] for p in page.data["plots"]]
    assert drawn == [f for f in FIGURES if f not in ("convergence", "tracking")]
    assert "has no control law" in page.text
    assert "IDM-LS is not iterative" in page.text
    halves = [a for a in page.tags("figure") if a.get("class") == "half"]
    assert len(halves) == 2  # residuals; friction has the whole width without its neighbour


@pytest.mark.slow
def test_a_real_record_fits_into_three_megabytes(emps: GeneratedAxis, emps_record: Record) -> None:
    assert len(report_html(identify(emps, emps_record))) < 1_500_000


@pytest.mark.slow
def test_command_writes_page_and_figures(run: Run, tmp_path: Path) -> None:
    report, figures = tmp_path / "report.html", tmp_path / "figures"
    code, out, _ = run("identify", "emps2015", "--report", report, "--figures", figures)
    assert code == 0
    page = Page(report.read_text(encoding="utf-8"))
    assert [p["name"] for p in page.data["plots"]] == [*FIGURES]
    assert f"axisid identify emps2015 --report {report}" in page.text
    assert sorted(path.name for path in figures.iterdir()) == sorted(f"{n}.pdf" for n in FIGURES)
    for path in figures.iterdir():
        assert path.read_bytes().startswith(b"%PDF")
        assert f"wrote {path}" in out


@pytest.mark.slow
def test_json_on_standard_output_stays_json_and_a_second_record_is_in_the_page(
    run: Run, tmp_path: Path, twin: Record
) -> None:
    report = tmp_path / "report.html"
    log = twin.write(tmp_path / "log.csv", load_axis("emps2015"))
    options = ("--method", "idm-ls", "--json", "-", "--report", report, "--validate", log)
    code, out, err = run("identify", "emps2015", *options)
    assert (code, json.loads(out)["axis"]) == (0, "emps2015")
    assert f"wrote {report}" in err
    page = Page(report.read_text())
    assert "sweep" in [p["name"] for p in page.data["plots"]]
    assert "on a second record" in page.text


def test_places_are_checked_before_anything_is_computed(refused: Refused, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("time,position\n")
    for option, place, message in (
        ("--report", tmp_path, "not a file"),
        ("--report", "-", "not a file"),
        ("--report", tmp_path / "no" / "r.html", "the folder does not exist"),
        ("--report", file, "it is an input of this run"),
        ("--figures", file, "folder"),
    ):
        assert option in refused("identify", "emps2015", file, option, place, says=message)
    assert list(tmp_path.iterdir()) == [file]
    refused("identify", "emps2015", "--json", tmp_path / "a", "--report", tmp_path / "a")
