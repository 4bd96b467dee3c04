"""Blocks as HTML: all that is said, well formed, and nothing that is run."""

import pytest

from axisid.presentation.documents import (
    Block,
    CheckGroup,
    Checks,
    Heading,
    Interval,
    Intervals,
    Listing,
    Notes,
    QuantityCell,
    Sentence,
    TableBlock,
    TableColumn,
    blocks_html,
    paragraph,
    text_columns,
)
from tests.pages import Page

HOSTILE = "</td><script>alert(1)</script>\"'&"


@pytest.mark.parametrize(
    "block",
    [
        Heading(facts={HOSTILE: HOSTILE}, title=HOSTILE),
        TableBlock(
            columns=text_columns([HOSTILE]), rows=((HOSTILE,),), title=HOSTILE, said=(HOSTILE,)
        ),
        TableBlock(
            columns=(TableColumn("a"), TableColumn(HOSTILE, HOSTILE, parts=(HOSTILE, HOSTILE))),
            rows=(("b", QuantityCell(HOSTILE, HOSTILE, (HOSTILE,))),),
        ),
        TableBlock(
            columns=(TableColumn("a"), TableColumn(HOSTILE, kind="method")),
            rows=((HOSTILE, HOSTILE),),
        ),
        Checks(judged=(CheckGroup("fail", (HOSTILE,), HOSTILE),), conclusion=HOSTILE),
        Notes((HOSTILE,)),
        paragraph(Sentence(lead=HOSTILE, text=HOSTILE), title=HOSTILE),
        Listing(title=HOSTILE, lines=(HOSTILE,)),
    ],
)
def test_no_text_becomes_an_element(block: Block) -> None:
    found = Page(blocks_html((block,)))
    assert found.opened == found.tags("script") == []
    assert "alert(1)" in found.text


def test_a_table_shows_a_quantity_as_one_cell_and_numbers_as_printed() -> None:
    table = TableBlock(
        columns=(
            *text_columns(["", "unit"]),
            TableColumn("ONE", "m/s^2", parts=("sd", "rel.", "more")),
        ),
        rows=(("a-1", "kg m^2", QuantityCell("-1.5", "0.2", ("3 %",))), ("b", "", "-1e-09")),
        title="Title",
        said=("Said of it",),
    )
    assert blocks_html((table,)) == (
        "<table><caption>Title</caption><thead><tr>"
        '<th class="text"></th><th class="unit">unit</th><th>ONE [m/s²] ± sd</th></tr></thead>'
        '<tbody><tr><th class="text">a-1</th><td class="unit">kg m²</td>'
        '<td title="rel. 3 %">\u22121.5 ± 0.2</td></tr>'
        '<tr><th class="text">b</th><td class="unit"></td><td>\u22121 \u00d7 10⁻⁹</td></tr>'
        "</tbody></table>"
        '<p class="note">Said of it.</p>'
    )


@pytest.mark.parametrize("end", [1.0, float("inf"), float("nan")])
def test_intervals_without_a_width_are_not_drawn(end: float) -> None:
    drawn = Intervals((Interval(1.0, 1.0, end, "iv"),))
    table = TableBlock(columns=(TableColumn("a"), TableColumn("b")), rows=(("M", drawn),))
    assert "<svg" not in blocks_html((table,))
