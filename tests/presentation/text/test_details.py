"""What `--full` prints is what the result holds."""

import pytest

from axisid import Identification, Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis


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


def test_correlation_law_and_instruments_are_told(result: Identification) -> None:
    text = result.summary(full=True)
    found = result.diagnosis
    assert f"{result['didim'].correlation[0, 1]:.3f}" in block(text, "Correlation, DIDIM")[2]
    assert f"{found.law.factors['kv']:.5g}" in "".join(block(text, "Control law"))
    assert f"{found.instruments.columns[0].conditional_f:.4g}" in block(text, "Instruments")[2]
    assert f"{found.alignment.best:.3f}" in "".join(block(text, "Alignment"))
    least_squares = found.differences["idm-ls less idm-iv"]["M"]
    assert f"{least_squares.difference:+.3g}" in "".join(block(text, "Estimates less another"))
