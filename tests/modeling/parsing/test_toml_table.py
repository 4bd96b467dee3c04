"""A TOML file is refused before its parser would take too long, whatever it nests."""

import tracemalloc
from pathlib import Path

import pytest

from axisid.modeling.parsing import toml_document
from axisid.support.errors import RunFileError
from tests.refusals import refuses

LONG = 10_000
MOST_BYTES = 5_000_000


@pytest.mark.parametrize(
    "text",
    [
        ".".join(["a"] * LONG) + " = 1",
        "[" + ".".join(["a"] * LONG) + "]",
        "[[" + " . ".join(["a"] * LONG) + "]]",
        ".".join(['"a"'] * LONG) + " = 1",
        ".".join(["'a b'", "c"] * 20) + " = 1",
        "x = { " + ".".join(["a"] * LONG) + " = 1 }",
        'x = "a"\n' + ".".join(["a"] * 40) + " = 'b'",
        "x = " + "[" * LONG + "]" * LONG,
        "x = " + "{a=" * LONG + "1" + "}" * LONG,
    ],
)
def test_what_is_nested_too_deeply_is_refused_at_once(tmp_path: Path, text: str) -> None:
    file = tmp_path / "run.toml"
    file.write_text(text)
    tracemalloc.start()
    try:
        with refuses("run-file", says="nested too deeply"):
            toml_document(file, RunFileError)
        assert tracemalloc.get_traced_memory()[1] < MOST_BYTES
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("quotes", ['"', "'", '"""', "'''"])
def test_texts_and_comments_may_have_any_number_of_dots(tmp_path: Path, quotes: str) -> None:
    file, dots = tmp_path / "run.toml", "a." * 100
    file.write_text(
        f"# {dots}\nlog = {quotes}{dots}{quotes} # {dots}\nrates = [1.5, 2.5]\na.b.c = 1"
    )
    found = toml_document(file, RunFileError)
    assert found == {"log": dots, "rates": [1.5, 2.5], "a": {"b": {"c": 1}}}
