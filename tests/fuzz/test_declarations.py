"""Declarations with anything in them are derived, shown and built, or refused in words."""

from pathlib import Path

import pytest

from axisid import build, derive, load_axis
from axisid.presentation.formulas.axis_page import FORMATS, axis_page
from tests.fuzz.cases import Fuzz, WrongError
from tests.fuzz.declarations import changed_declaration, declared, smaller_declarations


def _use(text: str, file: Path) -> None:
    """What `show` and every command after it make of a declaration."""
    file.write_text(text, encoding="utf-8")
    axis = load_axis(file)
    model = derive(axis)
    for form in FORMATS:
        page = axis_page(model, form)
        if "Traceback" in page or "object at 0x" in page:
            raise WrongError(f"page: {page}")
    build(axis, native=False)


@pytest.mark.slow
def test_changed_declarations_are_used_or_refused(tmp_path: Path) -> None:
    Fuzz(
        name="declarations",
        count=120,
        draw=changed_declaration,
        check=lambda text: _use(text, tmp_path / "axis.toml"),
        smaller=smaller_declarations,
        shown=str,
    ).run()


@pytest.mark.slow
def test_declarations_in_order_are_used(tmp_path: Path) -> None:
    def check(text: str) -> None:
        try:
            _use(text, tmp_path / "axis.toml")
        except ValueError as error:
            raise WrongError(f"refused: {error}") from error

    Fuzz(
        name="sound declarations",
        count=10,
        draw=declared,
        check=check,
        smaller=lambda _: (),
        shown=str,
    ).run()
