"""Pages of axes, and numbers, signs and units as they are printed."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sympy
from matplotlib.mathtext import MathTextParser

from axisid import Axis, Parameter, derive, load_axis, newton
from axisid.elements import Drive
from axisid.presentation.documents import figure_text, readable_text
from axisid.presentation.documents.axis_page import FORMATS, axis_page
from axisid.presentation.documents.latex import symbol_latex, unit_latex
from tests.axes.bodies import J, body, energetic, m, rod, turn, x
from tests.axes.drives import braked

ROOT = Path(__file__).resolve().parents[3]
carried = Parameter("K", "kg")
waves = tuple(Parameter(f"a_{i}", "N", description=r"50 % of a #1 \ {cog} _ ^ ~") for i in range(9))

WIDE = newton(
    "wide",
    title="many terms & signs: 100 % {of} <it>",
    coordinate=x,
    parameters=(m, *waves),
    inertia=m,
    resistance=[a * sympy.sin(100 * i * x.symbol) ** 2 for i, a in enumerate(waves, 1)],
    drive=Drive(gain=1.0, unit="N m/rad", relative_sd=0.01),
)
MERGED = body(coordinate=x, inertia=m + 4 * carried, parameters=(m, carried), name="merged")
CRANK = energetic(inertia=2 * J * (1 + sympy.sin(turn.symbol) ** 2), parameters=(J,), name="crank")
ROD = rod()
AXES = [
    ROD,
    load_axis("emps"),
    load_axis(ROOT / "examples" / "pendulum.py"),
    WIDE,
    MERGED,
    CRANK,
]


def name(axis: Axis) -> str:
    return axis.name


@pytest.mark.parametrize("axis", AXES, ids=name)
def test_text_is_at_most_96_columns_wide_and_plain(axis: Axis) -> None:
    text = axis_page(derive(axis))
    assert max(map(len, text.splitlines())) <= 96
    assert not re.search(r"[\t\x1b]| $", text, re.MULTILINE)


@pytest.mark.parametrize("form", FORMATS)
def test_a_drive_that_is_no_gain_alone_shows_its_own_force(form: str) -> None:
    page = " ".join(
        axis_page(derive(braked(load_axis("emps2015"))), form).replace("\\", "").split()
    )
    assert "tau = drive_gain*control - 40*dq in N, the control in V, drive_gain = 35.15" in page
    assert "times the control" not in page


def environments(text: str) -> list[str]:
    """Formulas of the aligned blocks, balanced braces and environments on the way."""
    opened: list[str] = []
    for kind, environment in re.findall(r"\\(begin|end)\{([a-z*]+)\}", text):
        if kind == "begin":
            opened.append(environment)
        else:
            assert opened.pop() == environment
    assert opened == []
    bare = re.sub(r"\\[\\{}]", "", text)
    assert bare.count("{") == bare.count("}")
    assert text.count(r"\left") == text.count(r"\right")
    blocks = re.findall(r"\\begin\{align(?:ed|\*)\}\n(.*?)\n\\end", text, re.DOTALL)
    return [line for block in blocks for line in re.split(r" \\\\\n", block)]


@pytest.mark.slow
@pytest.mark.parametrize("form", ["latex", "markdown"])
@pytest.mark.parametrize("axis", AXES, ids=name)
def test_every_formula_typesets(axis: Axis, form: str) -> None:
    formulas = environments(axis_page(derive(axis), form))
    assert len(formulas) > 4
    parser = MathTextParser("path")
    for formula in formulas:
        assert formula.count("&") == 1
        parser.parse(f"${formula.replace('&', '')}$")


def test_the_latex_document_escapes_what_latex_reads() -> None:
    text = axis_page(derive(WIDE), "latex")
    assert (
        r"\section*{wide: many terms \& signs: 100 \% \{of\} \textless{}it\textgreater{}}" in text
    )
    assert (
        r"50 \% of a \#1 \textbackslash{} \{cog\} \_ \textasciicircum{} \textasciitilde{}" in text
    )
    assert text.startswith(r"\documentclass{article}")
    assert text.endswith("\\end{document}\n")


def test_velocity_and_acceleration_wear_dots_and_names_are_one_symbol() -> None:
    text = axis_page(derive(load_axis("emps2015")), "markdown")
    assert r"M\, \ddot{q} + F_{\mathrm{v}}\, \dot{q}" in text


@pytest.mark.parametrize(
    ("write", "plain", "printed"),
    [
        *(
            (readable_text, plain, printed)
            for plain, printed in (
                ("Ljung-Box 1.777e+04, less than 47.4", "Ljung-Box 17\u202f770, less than 47.4"),
                ("J by +1.2e-06 kg m^2", "J by +1.2 \u00d7 10⁻⁶ kg m²"),
                ("by -1.9e-05 N m/(rad/s)", "by \u22121.9 \u00d7 10⁻⁵ N m/(rad/s)"),
                ("(-0.25), 6.4e-03 m/s^2", "(\u22120.25), 0.0064 m/s²"),
                ("0.46 +- 0.04 or +-0.1", "0.46 ± 0.04 or ±0.1"),
                ("4.27e+07 %", "4.27 \u00d7 10⁷ %"),
            )
        ),
        # Names, options and formulas stay as they are.
        *(
            (readable_text, text, text)
            for text in (
                *("log-2.csv", "run_1e5", "--fix m=1.2+-0.01", "n/(n - k)"),
                *("IDM-IV", "1.2e3x", "2-3"),
            )
        ),
        (figure_text, 101.4, "101"),
        (figure_text, 99.96, "100"),
        (figure_text, 1034.0, "1034"),
        (figure_text, 2.34e7, "2.34e+07"),
        (symbol_latex, "Fvm", r"F_{\mathrm{vm}}"),
        (symbol_latex, "Xi", r"\Xi"),
        (symbol_latex, "fv", r"\mathit{fv}"),
        (symbol_latex, "tau0", r"\tau_{0}"),
        (symbol_latex, "J_motor_2", r"J_{\mathrm{motor},\,2}"),
        (symbol_latex, "xdot", r"\mathit{xdot}"),
        (unit_latex, "N m/s^2", r"\mathrm{N\,m/s^{2}}"),
        (unit_latex, "1/(kg m^2)", r"\mathrm{1/(kg\,m^{2})}"),
        (unit_latex, "s^(1/2)", r"\mathrm{s^{1/2}}"),
    ],
)
def test_numbers_names_and_units_are_printed_as_they_are_read(
    write: Callable[[Any], str], plain: object, printed: str
) -> None:
    assert write(plain) == printed
