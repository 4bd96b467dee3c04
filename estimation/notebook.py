"""A result in a notebook: a compact table and the verdict, as HTML without scripts or styles."""

from html import escape
from typing import TYPE_CHECKING

from .summary import number_with_sd

if TYPE_CHECKING:
    from .results import Identification

_MARKS = {"pass": "✓", "fail": "✗", "not evaluated": "-"}


def result_html(result: "Identification") -> str:
    """Parameters by method with deviations, errors, and each check that did not pass."""
    estimates = list(result.estimates.values())
    head = "".join(f"<th>{escape(e.method.upper())}</th>" for e in estimates)
    rows = [
        f"<tr><th>{escape(q.name)}</th><td>{escape(q.unit)}</td>"
        + "".join(_cell(*number_with_sd(e.parameters[q.name])[:2]) for e in estimates)
        + "</tr>"
        for q in result.axis.parameters
    ]
    errors: dict[str, list[float | None]] = {
        "equation error": [e.equation_error_percent for e in estimates],
        "simulation error": [e.simulation_error_percent for e in estimates],
    }
    rows += [
        f"<tr><th>{name}</th><td>%</td>"
        + "".join(f"<td>{_percent(v)}</td>" for v in values)
        + "</tr>"
        for name, values in errors.items()
    ]
    verdict = result.verdict
    passed = sum(check.status == "pass" for check in verdict)
    listed = "".join(
        f"<li>{_MARKS[c.status]} <b>{escape(c.name)}</b>: {escape(c.meaning)}</li>"
        for c in verdict
        if c.status != "pass"
    )
    source = escape(f"{result.axis.axis.name}, {result.record.provenance.source}")
    return (
        f"<table><caption>{source}; ± standard deviation</caption>"
        f"<thead><tr><th></th><th></th>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
        f"<p>{passed} of {len(verdict)} checks passed.</p><ul>{listed}</ul>"
    )


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{error:.4g}"


def _cell(value: str, deviation: str) -> str:
    return f"<td>{value} ± {deviation}</td>"
