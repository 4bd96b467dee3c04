"""What is printed: on a screen, in full, and of fits of outputs."""

import re
from pathlib import Path

import pytest

from axisid import (
    Identification,
    Prefilter,
    Record,
    fit,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.presentation.documents import QuantityCell, TableBlock
from axisid.presentation.text import output_fit_document
from axisid.presentation.text.record import local_notes
from tests.command_line import Run
from tests.unjudged import identify


@pytest.mark.slow
def test_emps_fits_on_a_screen(run: Run, emps_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.toml"
    file.write_text(f"log = {str(emps_file)!r}\nsample_period = 1e-3\n")
    code, out, _ = run("identify", "emps", file)
    lines = out.splitlines()
    assert code == 0
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 100


def test_values_are_the_centres_of_their_intervals_and_the_others_are_told_where(
    result: Identification,
) -> None:
    assert "Call summary(every=True) to print all" in " ".join(result.summary().split())
    (row,) = re.findall(r"(?m)^M +kg +(\S+) +\S+ +(\S+) to (\S+)", result.summary())
    value, low, high = map(float, row)
    assert value == pytest.approx((low + high) / 2, abs=1e-3)
    assert value == pytest.approx(result.preferred.parameters["M"].corrected, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("switch", ["--all", "--full"])
def test_every_method_stands_beside_the_others_where_that_is_asked_for(
    run: Run, switch: str
) -> None:
    short, long = (run("identify", "emps2015", *more)[1] for more in ((), (switch,)))
    assert "DIDIM" in short
    assert "DDM-IV" not in short
    assert {"IDM-LS", "IDM-IV", "DIDIM", "DDM-LS", "DDM-IV"} <= {*long.split()}


@pytest.mark.slow
def test_least_squares_stands_beside_what_it_is_off_by(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Reversals that are kept bias it by more than its interval."""
    kept = identify(emps2015, twin, Prefilter(reversals="keep"))
    assert "IDM-LS" in kept.summary()


def test_every_parameter_has_its_interval_and_deviations(result: Identification) -> None:
    rows = result.summary(full=True).partition("\n95 % intervals")[2].split("\n\n")[0].splitlines()
    for method, estimate in result.estimates.items():
        for name, value in (estimate.parameters | estimate.ddm_parameters).items():
            (row,) = (r for r in rows if r.startswith(f"{method.upper()} {name} "))
            cells = row.split()
            assert float(cells[-7]) == pytest.approx(value.interval[0], rel=1e-5)
            assert float(cells[-6]) == pytest.approx(value.interval[1], rel=1e-5)
            assert float(cells[-5]) == pytest.approx(value.sd_hac, rel=5e-3)
            assert float(cells[-3]) == pytest.approx(value.sd, rel=5e-3)


def test_what_each_record_has_for_itself_is_said_of_products_too() -> None:
    alone, product = local_notes({"c": ("c_1", "c_2"), "m": ("", "")})
    assert alone.startswith("c_1, c_2: c")
    assert product.startswith("m: one value per record")


def _table(document: tuple[object, ...], place: int = 0) -> TableBlock:
    return [block for block in document if isinstance(block, TableBlock)][place]


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
        "at its upper bound",
    ]
    assert [rows[name][3] for name in ("Fv", "Fc")] == ["-", "-"]
    assert float(str(rows["Fc"][4]).split(" to ")[1]) == 20


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_values_have_the_digits_of_their_deviations(
    emps2015: GeneratedAxis, twin: Record, output: str
) -> None:
    result = fit(emps2015, twin, output)
    row = _table(output_fit_document(result)).rows[0]
    assert not isinstance(row[2], QuantityCell)
    assert float(str(row[2])) == pytest.approx(result["M"].value, abs=result["M"].deviation / 10)
    assert float(str(row[3])) == pytest.approx(result["M"].deviation, rel=0.05)
