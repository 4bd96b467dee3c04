"""A fit in words: what was asked, what came of it, what to think of it."""

import pytest

from axisid import Record, fit
from axisid.codegen.artefacts import GeneratedAxis
from axisid.presentation.blocks import Quantity, Table
from axisid.presentation.text import output_fit_document


def _table(document: tuple[object, ...], place: int = 0) -> Table:
    return [block for block in document if isinstance(block, Table)][place]


@pytest.mark.slow
def test_every_parameter_has_a_row_with_what_was_asked_of_it(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = fit(
        emps2015, twin, bounds={"Fc": (None, 20.0)}, prior={"M": (100.0, 1.0)}, fixed={"Fv": 240.0}
    )
    rows = {row[0]: row for row in _table(output_fit_document(result)).rows}
    assert [row[-1] for row in rows.values()] == [
        "known 100 +- 1",
        "fixed",
        "at its upper bound [2]",
    ]
    assert [rows[name][3] for name in ("Fv", "Fc")] == ["-", "-"]
    assert str(rows["Fc"][5]).endswith(" to 20")


@pytest.mark.parametrize("output", ["control", "position"])
def test_values_have_the_digits_of_their_deviations(
    emps2015: GeneratedAxis, twin: Record, output: str
) -> None:
    result = fit(emps2015, twin, output)
    row = _table(output_fit_document(result)).rows[0]
    assert not isinstance(row[2], Quantity)
    assert float(str(row[2])) == pytest.approx(result["M"].value, abs=1e-4)
    assert float(str(row[3])) == pytest.approx(result["M"].deviation, abs=1e-4)
