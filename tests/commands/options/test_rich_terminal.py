"""Blocks on a terminal: the words of plain text, in colours and within its width."""

import io

import click
import pytest
from rich.cells import cell_len

from axisid import Identification, Record, derive, load_axis, sweep
from axisid.commands.options.rich_terminal import print_dressed
from axisid.presentation.documents import (
    Block,
    CheckGroup,
    Checks,
    Document,
    Heading,
    Listing,
    Notes,
    QuantityCell,
    Sentence,
    TableBlock,
    TableColumn,
    paragraph,
    plain_text,
    text_columns,
)
from axisid.presentation.documents.axis_page import axis_document
from axisid.presentation.views import as_blocks

LONG = "words " * 30


def dressed(document: Document, width: int, *, coloured: bool = True) -> str:
    stream = io.StringIO()
    print_dressed(document, stream, width, coloured=coloured)
    return stream.getvalue()


def fitted(document: Document, width: int) -> list[str]:
    return dressed(document, width, coloured=False).splitlines()


def words(text: str) -> set[str]:
    return {word for word in text.split() if {*word} != {"-"}}


def methods(*heads: str) -> TableBlock:
    """A table of two rows for each of the methods."""
    return TableBlock(
        columns=(
            *text_columns(["", "unit"]),
            *(TableColumn(head, parts=("sd",)) for head in heads),
        ),
        rows=tuple(
            (name, unit, *(QuantityCell(f"{i}.5", f"0.{i}") for i, _ in enumerate(heads)))
            for name, unit in (("M", "kg"), ("long name", "N"))
        ),
        labels=2,
    )


@pytest.mark.parametrize(
    "block",
    [
        Heading(facts={"axis": LONG, "nothing": "", "": "more"}, title="Title"),
        methods("ONE", "TWO"),
        TableBlock(columns=text_columns(["a", "b"]), rows=(("c", "d"),), title=LONG, said=(LONG,)),
        Checks(judged=(CheckGroup("fail", ("one", "two"), LONG), CheckGroup("pass", ("three",)))),
        Checks(judged=(CheckGroup("not evaluated", ("one",), "since"),), conclusion=LONG),
        Notes(("one", LONG)),
        paragraph(LONG, Sentence(lead="so: ", text=LONG, hang=4), title="Title"),
        paragraph("one", Sentence(text="two", filled=False)),
        Listing(title="Title", lines=("a  = b", LONG)),
    ],
)
def test_on_a_wide_terminal_every_block_is_as_in_plain_text(block: Block) -> None:
    assert click.unstyle(dressed((block, block), 120)) == plain_text((block, block))
    for width in (30, 60):
        lines = fitted((block,), width)
        assert max(map(len, lines)) <= width
        assert words(plain_text((block,))) <= words("\n".join(lines))


@pytest.mark.slow
@pytest.mark.parametrize("width", [60, 80, 100])
def test_a_narrow_terminal_gets_every_word_within_its_width(
    result: Identification, twin: Record, width: int
) -> None:
    swept = sweep(result.axis, twin, [40.0, 60.0])
    documents = [as_blocks(result, full=True), as_blocks(swept), as_blocks(twin)]
    documents += [axis_document(derive(load_axis("emps")))]
    for document in documents:
        lines = fitted(document, width)
        assert max(map(len, lines)) <= width
        assert words(plain_text(document)) <= words("\n".join(lines))


@pytest.mark.parametrize(
    ("document", "width", "lines"),
    [
        (  # a table is broken between the columns of two methods
            (methods("FIRST METHOD", "SECOND METHOD"), paragraph("and so on")),
            42,
            [
                "           unit  FIRST METHOD   sd",
                "----------------------------------",
                "M            kg           0.5  0.0",
                "long name     N           0.5  0.0",
                "",
                "           unit  SECOND METHOD   sd",
                "-----------------------------------",
                "M            kg            1.5  0.1",
                "long name     N            1.5  0.1",
                "",
                "and so on",
            ],
        ),
        (  # what looks like markup is text
            (paragraph("[bold]x[/bold] :smile:"),),
            80,
            ["[bold]x[/bold] :smile:"],
        ),
        (  # wide letters take two columns
            (
                TableBlock(
                    columns=text_columns(["", "value"]), rows=(("日本", "1"), ("name", "22"))
                ),
            ),
            40,
            ["      value", "-----------", "日本      1", "name     22"],
        ),
    ],
    ids=["broken", "markup", "wide"],
)
def test_what_a_terminal_shows(document: Document, width: int, lines: list[str]) -> None:
    assert fitted(document, width) == lines


def test_wide_letters_take_two_columns() -> None:
    title = Heading(facts={"axis": "日本語のタイトル " * 8})
    table = TableBlock(columns=text_columns(["", "value"]), rows=(("日本", "1"), ("name", "22")))
    for width in (40, 60):
        lines = fitted((title, table), width)
        assert max(map(cell_len, lines)) <= width
        assert "".join(lines).count("日本語のタイトル") == 8


def test_a_word_that_is_wider_than_the_terminal_is_folded() -> None:
    lines = fitted((paragraph("x" * 70),), 30)
    assert [len(line) for line in lines] == [30, 30, 10]
    assert fitted((methods("ONE"),), 1) == fitted((methods("ONE"),), 20)
