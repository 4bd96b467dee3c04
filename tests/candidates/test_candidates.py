"""A term of a user's own is looked for, named with its size, and told where it is none."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import (
    Constant,
    build,
    fit,
    load_axis,
    twin_record,
)
from axisid.candidates import TERMS, Along, Term
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.model_error_checks import MissingTerms
from axisid.estimation.misspecification import MissingTerm
from axisid.estimation.records import Record
from axisid.support.arrays import Array
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of, meaning_of


def _cubic(motion: Along, _: Array) -> Array:
    return motion.reduce((motion.position + motion.middle) ** 3)[:, None, None]


CUBIC = Term(
    kind="cubic",
    what="a spring that hardens",
    declare="declare offset(kc*{q}**3)",
    unit="{force}/{unit}^3",
    columns=_cubic,
)


@pytest.fixture(scope="module")
def hardening() -> tuple[GeneratedAxis, Record]:
    """The axis, and a twin on a spring that it does not declare."""
    axis = load_axis("emps2015")
    hard = Constant(1e5, "N/m^3", "hard") * axis.coordinate.symbol**3
    return build(axis), twin_record(build(replace(axis, force=axis.force + hard)))


@pytest.mark.slow
@pytest.mark.parametrize("by", ["identify", "fit"])
def test_it_is_named_with_what_to_declare(
    hardening: tuple[GeneratedAxis, Record], by: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(TERMS, "cubic", CUBIC)
    result = identify(*hardening, methods=["idm-iv"]) if by == "identify" else fit(*hardening)
    assert result.belief != "believed"
    check = checks_of(result)["missing terms"]
    first = finding_of(check, MissingTerms).found[0]
    assert isinstance(first, MissingTerm)
    assert (first.term.what, first.term.declare) == (CUBIC.what, CUBIC.declare)
    assert (first.unit, first.coordinate) == ("N/m^3", "q")
    assert first.size == pytest.approx(1e5, rel=0.02)
    assert "declare offset(kc*q**3)" in check.meaning.lower()


def _raises(motion: Along, _: Array) -> Array:
    return motion.reduce(1 / np.zeros(0)[[0]])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"columns": lambda motion, _: np.ones(len(motion.place))}, "shape"),
        ({"columns": lambda motion, _: np.nan * _cubic(motion, _)}, "not all below 1e"),
        ({"columns": lambda motion, _: 1e200 * _cubic(motion, _)}, "not all below 1e"),
        ({"columns": lambda motion, _: np.ones((len(motion.place), 1, 40))}, "1 to 31 columns"),
        ({"columns": _raises}, "IndexError"),
        ({"between": lambda grid, _: grid[9]}, "IndexError"),
    ],
)
def test_one_of_wrong_columns_is_told_and_costs_no_estimate(
    hardening: tuple[GeneratedAxis, Record],
    monkeypatch: pytest.MonkeyPatch,
    changed: dict[str, Any],
    said: str,
) -> None:
    monkeypatch.setitem(TERMS, "cubic", replace(CUBIC, **changed))
    result = identify(*hardening, methods=["idm-iv"])
    meaning = meaning_of(result, "missing terms")
    assert "the candidate 'cubic'" in meaning
    assert said in meaning
    assert result.belief == "with care"
    assert result["idm-iv"].physical.all()


def test_texts_that_cannot_be_filled_in_are_refused() -> None:
    for wrong in ({"what": "{nope}"}, {"unit": "{force"}, {"declare": "{}"}):
        with refuses("candidate", "cubic"):
            replace(CUBIC, **wrong)  # type: ignore[arg-type]
