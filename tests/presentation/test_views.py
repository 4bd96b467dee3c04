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
from axisid.presentation import views
from axisid.presentation.blocks import plain_text
from axisid.presentation.html import blocks_html
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
        validate(result, record),
        fit(emps2015, record),
        sweep(emps2015, record, [40.0, 60.0], methods=["idm-ls"]),
        compare(friction_ladder(load_axis("emps2015")), record, Prefilter()),
    ]
    for shown in results:
        assert str(shown) == shown.summary() != repr(shown)
        assert shown.to_dict()
        assert "<table>" in shown._repr_html_()


def test_every_kind_of_result_has_its_row() -> None:
    kinds = {kind.__name__ for kind in Presentable.__subclasses__()}
    assert len(kinds) == 15
    for view in (views.as_blocks, views.as_document):
        assert kinds <= {kind.__name__ for kind in view.registry}


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
    with refuses("unknown-figure", says="'colour'; choose from record, friction"):
        result.plot("colour")
    with refuses("unknown-figure", says="Record has no figure 'force'"):
        record.plot("force")
    swept = sweep(emps2015, record, [60.0], methods=["idm-ls"])
    assert isinstance(swept.plot(), Figure)
    for shown in (swept, result["idm-iv"]):
        with refuses("no-method-to-choose"):
            shown.plot("sweep" if shown is swept else "force", method="ddm-ls")
    with refuses("no-such-estimate", says="'ddm-iv'"):
        result.plot("force", method="ddm-iv")


def test_text_and_pages_are_made_of_the_same_blocks(
    emps2015: GeneratedAxis, record: Record
) -> None:
    result = identify(emps2015, record, methods=["idm-ls"])
    assert plain_text(views.as_blocks(result, full=True)) == result.summary(full=True)
    assert blocks_html(views.as_blocks(result)) == result._repr_html_()
    assert str(result["idm-ls"]) == repr(result["idm-ls"])
    assert "95 % interval" in result["idm-ls"]._repr_html_()
