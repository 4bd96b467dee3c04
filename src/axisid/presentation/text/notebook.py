"""Results in a notebook: compact tables and the verdict, as HTML without scripts or styles."""

from collections.abc import Sequence
from html import escape

from axisid.estimation.diagnostics import by_weight, conclusion
from axisid.estimation.estimates import Estimate, Value
from axisid.estimation.identification import Identification

from .quantity import number_with_sd

_MARKS = {"pass": "✓", "note": "○", "fail": "✗", "not evaluated": "-"}


def result_html(result: Identification) -> str:
    """Parameters by method with deviations, errors, and each check that did not pass."""
    estimates = list(result.estimates.values())
    head = "".join(f"<th>{escape(e.method.upper())}</th>" for e in estimates)
    rows = [
        _row(q.name, q.unit, [_cell(e.parameters[q.name]) for e in estimates])
        for q in result.axis.parameters
    ]
    rows += [_row(name, "%", cells) for name, cells in _errors(estimates).items()]
    verdict = result.verdict
    passed = sum(check.status == "pass" for check in verdict)
    listed = "".join(
        f"<li>{_MARKS[c.status]} <b>{escape(c.name)}</b>: {escape(c.meaning)}</li>"
        for c in by_weight(verdict)
        if c.status != "pass"
    )
    source = escape(f"{result.axis.axis.name}, {result.record.provenance.source}")
    return (
        f"<table><caption>{source}; ± standard deviation</caption>"
        f"<thead><tr><th></th><th></th>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
        f"<p>{escape(conclusion(verdict))} {passed} of {len(verdict)} checks passed.</p>"
        f"<ul>{listed}</ul>"
    )


def estimate_html(estimate: Estimate) -> str:
    """Every parameter with its deviation and interval, and the errors."""
    about = estimate.covariance_names[estimate.chosen]
    values = {**estimate.ddm_parameters, **estimate.parameters}
    rows = [_row(name, v.unit, [_cell(v), _interval(v)]) for name, v in values.items()]
    rows += [_row(name, "%", [*cells, ""]) for name, cells in _errors([estimate]).items()]
    return (
        f"<table><caption>{escape(estimate.method.upper())}; ± standard deviation: "
        f"{escape(about)}</caption><thead><tr><th></th><th></th><th>value</th>"
        f"<th>95 % interval</th></tr></thead><tbody>{''.join(rows)}</tbody></table>"
    )


def _row(name: str, unit: str, cells: Sequence[str]) -> str:
    filled = "".join(f"<td>{cell}</td>" for cell in cells)
    return f"<tr><th>{escape(name)}</th><td>{escape(unit)}</td>{filled}</tr>"


def _errors(estimates: Sequence[Estimate]) -> dict[str, list[str]]:
    return {
        "equation error": [_percent(e.equation_error_percent) for e in estimates],
        "simulation error": [_percent(e.simulation_error_percent) for e in estimates],
    }


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{error:.4g}"


def _cell(value: Value) -> str:
    number, deviation, *_ = number_with_sd(value)
    return f"{number} ± {deviation}"


def _interval(value: Value) -> str:
    low, high = value.interval
    return f"{low:.6g} … {high:.6g}"
