"""Blocks as HTML: all that is said, well formed, and nothing that is run."""

from html.parser import HTMLParser

import pytest

from axisid.presentation.blocks import (
    Block,
    CheckGroup,
    Checks,
    Column,
    Heading,
    Interval,
    Intervals,
    Listing,
    NotedText,
    Notes,
    Quantity,
    Sentence,
    Table,
    paragraph,
    text_columns,
)
from axisid.presentation.html import blocks_html, table_html

HOSTILE = "</td><script>alert(1)</script>\"'&"


class Elements(HTMLParser):
    """The elements of a text, each of which must be closed, and what is between them."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[str] = []
        self.opened: list[str] = []
        self.said: list[str] = []
        self.feed(text)
        self.close()
        assert not self.opened

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        del attrs
        self.tags.append(tag)
        self.opened.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        del attrs
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.opened.pop() == tag

    def handle_data(self, data: str) -> None:
        self.said.append(data)


@pytest.mark.parametrize(
    "block",
    [
        Heading(facts=((HOSTILE, HOSTILE),), title=HOSTILE),
        Table(columns=text_columns([HOSTILE]), rows=((HOSTILE,),), title=HOSTILE, said=(HOSTILE,)),
        Table(
            columns=(Column("a"), Column(HOSTILE, HOSTILE, parts=(HOSTILE, HOSTILE))),
            rows=(("b", Quantity(HOSTILE, HOSTILE, (HOSTILE,))),),
        ),
        Table(
            columns=(Column("a"), Column("b", kind="method")),
            rows=((NotedText(HOSTILE, HOSTILE, HOSTILE), HOSTILE),),
        ),
        Checks(judged=(CheckGroup("fail", (HOSTILE,), HOSTILE),), conclusion=HOSTILE),
        Notes((HOSTILE,)),
        paragraph(Sentence(lead=HOSTILE, text=HOSTILE), title=HOSTILE),
        Listing(title=HOSTILE, lines=(HOSTILE,)),
    ],
)
def test_no_text_becomes_an_element(block: Block) -> None:
    found = Elements(blocks_html((block,)))
    assert "script" not in found.tags
    assert "alert(1)" in "".join(found.said)


def test_facts_stay_as_they_are_written() -> None:
    html = blocks_html((Heading(facts=(("record", "a-1e-06.csv"), ("nothing", ""))),))
    assert html == "<dl><dt>record</dt><dd>a-1e-06.csv</dd></dl>"


def test_a_table_shows_a_quantity_as_one_cell_and_numbers_as_printed() -> None:
    table = Table(
        columns=(*text_columns(["", "unit"]), Column("ONE", "m/s^2", parts=("sd", "rel.", "more"))),
        rows=(("a-1", "kg m^2", Quantity("-1.5", "0.2", ("3 %",))), ("b", "", "-1e-09")),
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


def test_rows_that_share_a_cell_are_a_body_of_their_own() -> None:
    intervals = (Interval(1.0, 2.0, 3.0, "ls"), Interval(2.0, 3.0, 5.0, "iv"))
    drawn = Intervals(intervals, truth=2.5)
    table = Table(
        columns=(Column(""), Column("", kind="method"), Column("drawn", kind="intervals")),
        rows=(
            (NotedText("M", "kg", "mass"), "idm-ls", drawn),
            (None, "idm-iv", None),
            ("N", "a", ""),
        ),
    )
    html = blocks_html((table,))
    assert html.count("<tbody>") == 2
    assert '<th rowspan="2" scope="rowgroup">M <span class="unit">kg</span>' in html
    assert '<td class="method"><span class="swatch-iv">●</span> IDM-IV</td>' in html
    assert '<td class="intervals" rowspan="2"><svg' in html
    assert html.count("<circle") == 2
    assert html.count('class="truth"') == 1
    assert '<g class="ls"><line x1="6.0"' in html


def test_rows_are_one_body_or_each_a_body_on_request() -> None:
    table = Table(columns=text_columns(["a"]), rows=(("b",), ("c",)))
    assert table_html(table).count("<tbody>") == 1
    html = table_html(table, "parameters", grouped=True)
    assert html.startswith('<table class="parameters">')
    assert html.count("<tbody>") == 2
    assert table_html(Table(columns=text_columns(["a"]), rows=())).count("<tbody></tbody>") == 1


def test_intervals_without_a_width_are_not_drawn() -> None:
    for end in (1.0, float("inf"), float("nan")):
        drawn = Intervals((Interval(1.0, 1.0, end, "iv"),))
        table = Table(columns=(Column("a"), Column("b")), rows=(("M", drawn),))
        assert "<svg" not in blocks_html((table,))


def test_checks_have_signs_and_notes_their_numbers() -> None:
    judged = (
        CheckGroup("fail", ("one",), "two"),
        CheckGroup("not evaluated", ("three",), "four"),
        CheckGroup("pass", ("five", "six")),
    )
    html = blocks_html((Checks(judged=judged, conclusion="Believe it"), Notes(("said",))))
    assert html.startswith("<p>Believe it.</p><ul")
    assert ">✗</span> <span><b>One:</b> two.</span></li>" in html
    assert "<b>Three:</b> not evaluated: four." in html
    assert ">✓</span> <span>five, six</span></li>" in html
    assert html.endswith("<details><summary>Notes</summary><p>[1] said.</p></details>")


def test_sentences_and_listings_keep_their_leads_and_titles() -> None:
    told = paragraph(Sentence(lead="recommended: ", text="this"), "that", title="Title")
    assert blocks_html((told,)) == (
        "<p><b>Title</b></p><p><b>recommended:</b> this.</p><p>that.</p>"
    )
    listing = Listing(title="Title", lines=("a < b^2",))
    assert blocks_html((listing,)) == (
        "<p><b>Title</b></p><ul><li><code>a &lt; b^2</code></li></ul>"
    )
