"""What `--full` prints is what the result holds."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid import Identification, Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.presentation.text.identification import covariance_name
from axisid.support.missing import Missing
from axisid.support.number_text import plain_numbers


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


def block(text: str, title: str) -> list[str]:
    lines = text[text.index(f"\n{title}") :].strip().split("\n\n")[0].splitlines()
    return lines[1:]


def test_every_parameter_has_its_interval_and_deviations(result: Identification) -> None:
    rows = block(result.summary(full=True), "95 % intervals")
    for method, estimate in result.estimates.items():
        for name, value in (estimate.parameters | estimate.ddm_parameters).items():
            (row,) = (r for r in rows if r.startswith(f"{method.upper()} {name} "))
            cells = row.split()
            assert float(cells[-7]) == pytest.approx(value.interval[0], rel=1e-5)
            assert float(cells[-6]) == pytest.approx(value.interval[1], rel=1e-5)
            assert float(cells[-5]) == pytest.approx(value.sd_hac, rel=5e-3)
            assert float(cells[-3]) == pytest.approx(value.sd, rel=5e-3)


def test_every_check_has_its_figure_and_threshold(result: Identification) -> None:
    rows = block(result.summary(full=True), "Checks")
    for check in result.verdict:
        (row,) = (r for r in rows if r.startswith(f"{check.name}  "))
        assert f" {check.status} " in row
        if check.figure is not None and check.threshold is not None:
            assert f" {check.figure:.3g} " in row
            assert f" {check.threshold:.3g} " in row


def test_correlation_law_and_instruments_are_told(result: Identification) -> None:
    text = result.summary(full=True)
    found = result.diagnosis
    assert f"{result['didim'].correlation[0, 1]:.3f}" in block(text, "Correlation, DIDIM")[2]
    assert not isinstance(found.law, Missing)
    assert f"{found.law.factors['kv']:.5g}" in "".join(block(text, "Control law"))
    assert found.instruments is not None
    assert f"{found.instruments.columns[0].conditional_f:.4g}" in block(text, "Instruments")[2]
    assert not isinstance(found.alignment, Missing)
    assert f"{found.alignment.best:.3f}" in "".join(block(text, "Alignment"))
    assert not isinstance(found.endogeneity, Missing)
    statistic = plain_numbers(f"F = {found.endogeneity.statistic:.4g}")
    assert statistic in "".join(block(text, "Durbin-Wu-Hausman"))


def test_what_was_not_measured_says_why(emps2015: GeneratedAxis, twin: Record) -> None:
    alone = identify(emps2015, replace(twin, reference=None), methods="idm-ls")
    text = alone.summary(full=True)
    (said,) = block(text, "Control law")
    assert said.startswith("not checked: ")
    assert block(text, "Instruments") == ["none"]
    assert "it needs idm-iv" in block(text, "Durbin-Wu-Hausman")[0]


def test_without_it_the_table_is_as_short_as_before(result: Identification) -> None:
    assert result.summary(full=True).startswith(result.summary())
    assert "Correlation" not in result.summary()


@pytest.mark.slow
def test_the_note_says_whose_deviations_are_those_of_autoregressive_residuals(
    emps2015: GeneratedAxis, twin: Record, rng: np.random.Generator
) -> None:
    said = ": the larger deviation of residuals that are an AR(1)"
    sluggish = lfilter([0.05], [1.0, -0.95], rng.normal(size=len(twin.time)))
    noisy = replace(twin, control=twin.control + sluggish).windowed((None, 1.0))
    result = identify(emps2015, noisy)
    told = " ".join(result.summary().split())
    tails = {e.covariance_names["hac"].partition("; ")[2] for e in result.estimates.values()}
    assert any(tails)
    assert all(said in tail and tail in told for tail in tails if tail)
    assert said not in identify(emps2015, twin).summary()


def test_a_note_of_several_methods_says_which_are_wider() -> None:
    names = {"idm-ls": "HAC, 9 lags; M: larger", "idm-iv": "HAC, 8 lags; M: larger"}
    assert covariance_name(names) == "HAC, 9, 8 lags; M: larger"
    one = names | {"ddm-iv": "HAC, 9 lags"}
    assert covariance_name(one) == "HAC, 9, 8 lags; M: larger (IDM-LS, IDM-IV)"
    assert covariance_name({"idm-ls": "HAC, 9 lags"}) == "HAC, 9 lags"
