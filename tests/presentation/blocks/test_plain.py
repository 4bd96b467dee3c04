"""Blocks as plain text: every line as a pipe gets it."""

import pytest

from axisid.presentation.blocks import (
    PAGE_WIDTH,
    Block,
    CheckGroup,
    Checks,
    Column,
    Document,
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


def test_what_is_drawn_and_what_reaches_down_is_left_out() -> None:
    drawn = Intervals((Interval(1.0, 2.0, 3.0, "ls"),))
    table = Table(
        columns=(Column("", align="left"), Column("how"), Column("interval")),
        rows=((NotedText("M", "kg", "mass"), "LS", drawn), (None, "IV", None)),
    )
    assert lines(table)[2:] == ["M [kg] (mass)   LS", "                IV"]


def test_letters_of_other_scripts_are_counted_as_letters() -> None:
    table = Table(columns=text_columns(["größe", "µ"]), rows=(("ä", "12"),))
    assert lines(table) == ["größe   µ", "---------", "ä      12"]


def test_checks_have_heads_and_a_conclusion_if_there_is_one() -> None:
    judged = (
        CheckGroup("fail", ("one",), LONG),
        CheckGroup("note", ("two",), "said"),
        CheckGroup("not evaluated", ("three", "four"), "since"),
        CheckGroup("pass", ("five", "six")),
    )
    found = lines(Checks(judged=judged, conclusion="Believe it."))
    assert found[:2] == ["verdict    Believe it.", ""]
    assert found[2].startswith("FAIL   one: words words")
    assert found[3].startswith("       words")
    assert found[-3:] == [
        "note   two: said",
        "-      three, four: not evaluated, since",
        "pass   five, six",
    ]
    assert lines(Checks(judged=judged[1:2])) == ["note   two: said"]


def test_notes_are_numbered_and_hang_behind_their_numbers() -> None:
    found = lines(Notes(tuple(["one"] * 9 + [LONG])))
    assert found[0] == "[1] one"
    assert found[9].startswith("[10] words")
    assert found[10].startswith("     words")


def test_sentences_are_filled_or_stay_on_one_line() -> None:
    filled, whole = lines(paragraph(LONG)), lines(paragraph(LONG, filled=False))
    assert len(filled) > len(whole) == 1
    assert max(map(len, filled)) <= PAGE_WIDTH
    found = lines(paragraph(Sentence(lead="so: ", text=LONG, hang=4), "next", title="Title"))
    assert found[0] == "Title"
    assert found[1].startswith("so: words")
    assert found[2].startswith("    words")
    assert found[-1] == "next"


def test_a_listing_breaks_no_word() -> None:
    formula = "x" * 120
    assert lines(Listing(title="Title", lines=("a  =  b", formula))) == [
        "Title",
        "  a  =  b",
        f"  {formula}",
    ]


def test_blocks_are_parted_by_blank_lines() -> None:
    document: Document = (paragraph("one"), Notes(()), paragraph("two"))
    assert plain_text(document) == "one\n\ntwo\n"


def test_a_row_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match="argument 2 is longer"):
        plain_text((Table(columns=text_columns(["a", "b"]), rows=(("c",),)),))
