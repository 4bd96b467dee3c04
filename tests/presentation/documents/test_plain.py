"""Blocks as plain text: every line as a pipe gets it."""

import pytest

from axisid.presentation.documents import (
    PAGE_WIDTH,
    Block,
    Heading,
    Interval,
    Intervals,
    QuantityCell,
    TableBlock,
    TableColumn,
    paragraph,
    plain_text,
    text_columns,
)

LONG = "words " * 30


def lines(*blocks: Block) -> list[str]:
    text = plain_text(blocks)
    assert text.endswith("\n")
    return text[:-1].split("\n")


def test_named_facts_hang_and_those_that_say_nothing_are_passed_over() -> None:
    heading = Heading(facts={"axis": LONG, "nothing": "", "": "more"}, title="Title")
    title, first, *hanging, last = lines(heading)
    assert title == "Title"
    assert first.startswith("axis       words")
    assert len(first) <= PAGE_WIDTH
    assert hanging
    assert all(line.startswith(" " * 11 + "words") for line in hanging)
    assert last == " " * 11 + "more"
    assert lines(Heading(facts={"nothing": ""}), paragraph("so")) == ["so"]


@pytest.mark.parametrize(
    ("table", "wanted"),
    [
        (  # its first column to the left, and a column for each part
            TableBlock(
                columns=(
                    *text_columns(["", "unit"]),
                    TableColumn("ONE", parts=("sd", "rel.")),
                    TableColumn("v", "m/s"),
                ),
                rows=(
                    ("M", "kg", QuantityCell("95.1", "0.2", ("3 %",)), "1"),
                    ("longer", "", "-", ""),
                ),
                title="Title",
                said=("Said of it.",),
            ),
            [
                "Title",
                "        unit   ONE   sd  rel.  v [m/s]",
                "--------------------------------------",
                "M         kg  95.1  0.2   3 %        1",
                "longer           -",
                "Said of it.",
            ],
        ),
        (  # without parts a quantity is one text
            TableBlock(
                columns=text_columns(["", "value"]),
                rows=(("a", QuantityCell("1.5", "0.2")), ("b", QuantityCell("1", ""))),
            ),
            ["        value", "-------------", "a  1.5 +- 0.2", "b           1"],
        ),
        (  # what is drawn is left out
            TableBlock(
                columns=(
                    TableColumn("", align="left"),
                    TableColumn("how"),
                    TableColumn("interval", kind="intervals"),
                ),
                rows=(("M", "LS", Intervals((Interval(1.0, 2.0, 3.0, "ls"),))),),
            ),
            ["   how", "------", "M   LS"],
        ),
        (  # letters of other scripts are counted as letters
            TableBlock(columns=text_columns(["größe", "µ"]), rows=(("ä", "12"),)),
            ["größe   µ", "---------", "ä      12"],
        ),
    ],
    ids=["parts", "one text", "drawn", "letters"],
)
def test_a_table_is_as_wide_as_its_texts(table: TableBlock, wanted: list[str]) -> None:
    assert lines(table) == wanted
