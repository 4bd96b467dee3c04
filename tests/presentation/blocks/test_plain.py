"""Blocks as plain text: every line as a pipe gets it."""

from axisid.presentation.blocks import (
    PAGE_WIDTH,
    Block,
    Column,
    Heading,
    Interval,
    Intervals,
    Quantity,
    Table,
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
    heading = Heading(facts=(("axis", LONG), ("nothing", ""), ("", "more")), title="Title")
    title, first, *hanging, last = lines(heading)
    assert title == "Title"
    assert first.startswith("axis       words")
    assert len(first) <= PAGE_WIDTH
    assert hanging
    assert all(line.startswith(" " * 11 + "words") for line in hanging)
    assert last == " " * 11 + "more"
    assert lines(Heading(facts=(("nothing", ""),)), paragraph("so")) == ["so"]


def test_a_table_has_its_first_column_left_and_a_column_for_each_part() -> None:
    table = Table(
        columns=(
            *text_columns(["", "unit"]),
            Column("ONE", parts=("sd", "rel.")),
            Column("v", "m/s"),
        ),
        rows=(
            ("M", "kg", Quantity("95.1", "0.2", ("3 %",)), "1"),
            ("longer", "", "-", ""),
        ),
        title="Title",
        said=("Said of it.",),
    )
    assert lines(table) == [
        "Title",
        "        unit   ONE   sd  rel.  v [m/s]",
        "--------------------------------------",
        "M         kg  95.1  0.2   3 %        1",
        "longer           -",
        "Said of it.",
    ]


def test_without_parts_a_quantity_is_one_text() -> None:
    table = Table(
        columns=text_columns(["", "value"]),
        rows=(("a", Quantity("1.5", "0.2")), ("b", Quantity("1", ""))),
    )
    assert lines(table)[2:] == ["a  1.5 +- 0.2", "b           1"]


def test_what_is_drawn_is_left_out() -> None:
    drawn = Intervals((Interval(1.0, 2.0, 3.0, "ls"),))
    heads = (Column("", align="left"), Column("how"), Column("interval", kind="intervals"))
    assert lines(Table(columns=heads, rows=(("M", "LS", drawn),)))[2:] == ["M   LS"]


def test_letters_of_other_scripts_are_counted_as_letters() -> None:
    table = Table(columns=text_columns(["größe", "µ"]), rows=(("ä", "12"),))
    assert lines(table) == ["größe   µ", "---------", "ä      12"]
