"""Every result is shown by one hook: text, plain data, figures, notebooks."""

import pytest
from matplotlib.figure import Figure

from axisid import (
    Prefilter,
    compare,
    fit,
    friction_ladder,
    identify,
    load_axis,
    sweep,
    twin_record,
    validate,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.support.presentable import Presentable
from tests.refusals import refuses


@pytest.fixture(scope="module")
def record(emps2015: GeneratedAxis) -> Record:
    return twin_record(emps2015.axis)


@pytest.mark.slow
def test_every_result_has_text_plain_data_and_a_page(
    emps2015: GeneratedAxis, record: Record
) -> None:
    result = identify(emps2015, record, methods=["idm-ls"])
    results: list[Presentable] = [
        record,
        result,
        result.diagnosis,
        validate(result, record),
        fit(emps2015, record),
        sweep(emps2015, record, [40.0, 60.0], methods=["idm-ls"]),
        compare(friction_ladder(load_axis("emps2015")), record, Prefilter()),
    ]
    for shown in results:
        assert str(shown) == shown.summary() != repr(shown)
        assert shown.to_dict()
        assert "<table>" in shown._repr_html_()
    assert "pendulum" in load_axis("pendulum")._repr_html_()


@pytest.mark.slow
def test_figures_have_names(emps2015: GeneratedAxis, record: Record) -> None:
    result = identify(emps2015, record, methods=["idm-ls", "idm-iv"])
    for name in (
        *("record", "friction", "tracking", "force", "autocorrelation", "spectrum"),
        "repeats",
    ):
        assert isinstance(result.plot(name), Figure)
    assert isinstance(result["idm-iv"].plot("convergence"), Figure)
    assert isinstance(result.plot("force", method="idm-ls"), Figure)
    with refuses("figure", says="'colour'"):
        result.plot("colour")
    swept = sweep(emps2015, record, [60.0], methods=["idm-ls"])
    assert isinstance(swept.plot(), Figure)
    for shown in (swept, result["idm-iv"]):
        with refuses("figure"):
            shown.plot("sweep" if shown is swept else "force", method="ddm-ls")
    with refuses("result", says="'ddm-iv'"):
        result.plot("force", method="ddm-iv")
