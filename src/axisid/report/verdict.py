"""The verdict on top of the page."""

from collections.abc import Sequence
from html import escape

from axisid.estimation import Check

from .prose import prose_html

_SIGNS = {"pass": "✓", "fail": "✗", "not evaluated": "○"}
_CLASSES = {"pass": "pass", "fail": "fail", "not evaluated": "missing"}

_LARGE, _LARGER = 1e3, 1e6  # written without an exponent
_SURE = 1e-4


def verdict_html(checks: Sequence[Check], judged: str) -> str:
    """How many checks passed, each that did not in a sentence, and all of them in a table.

    Parameters
    ----------
    checks : sequence of Check
    judged : str
        The method they are of.
    """
    ordered = sorted(checks, key=lambda c: ("fail", "not evaluated", "pass").index(c.status))
    passed = [c for c in checks if c.status == "pass"]
    bars = "".join(
        f'<span class="{_CLASSES[c.status]}" title="{escape(c.name)}"></span>'
        for c in reversed(ordered)
    )
    items = "".join(
        f"<li>{_sign(c)}<span><b>{escape(c.name.capitalize())}:</b> {_sentence(c)}</span></li>"
        for c in ordered
        if c.status != "pass"
    )
    names = escape(", ".join(c.name for c in passed)) or "nothing"
    return (
        f'<section class="verdict" id="verdict"><h2>{_headline(checks)}</h2>'
        f'<div class="tally" aria-hidden="true">{bars}</div>'
        f'<p class="passed"><span class="sign pass">✓</span>{names}</p>'
        f'<ul class="checks">{items}</ul>'
        f"<details><summary>Every check with its figure and threshold</summary>{_table(ordered)}"
        f'</details><p class="note">The checks are of {escape(judged.upper())}. A failed check is '
        "a reason to look, not a gate.</p></section>"
    )


def _headline(checks: Sequence[Check]) -> str:
    counts = {status: sum(c.status == status for c in checks) for status in _SIGNS}
    made = counts["pass"] + counts["fail"]
    text = (
        f"All {made} checks passed"
        if not counts["fail"]
        else f"{counts['pass']} of {made} checks passed, {counts['fail']} to look at"
    )
    return text + (f", {counts['not evaluated']} not evaluated" if counts["not evaluated"] else "")


def _table(checks: Sequence[Check]) -> str:
    head = (
        '<thead><tr><th></th><th class="text">check</th><th>figure</th><th>threshold</th>'
        '<th>p-value</th><th class="text">of what, and whose threshold</th></tr></thead>'
    )
    rows = "".join(
        f'<tr><td>{_sign(c)}</td><td class="text">{escape(c.name)}</td><td>{_number(c.figure)}</td>'
        f"<td>{_number(c.threshold)}</td><td>{_p_value(c.p_value)}</td>"
        f'<td class="text">{escape(c.source)}</td></tr>'
        for c in checks
    )
    return f'<div class="scroll"><table>{head}<tbody>{rows}</tbody></table></div>'


def _sign(check: Check) -> str:
    return (
        f'<span class="sign {_CLASSES[check.status]}" title="{check.status}">'
        f"{_SIGNS[check.status]}</span>"
    )


def _number(value: float | None) -> str:
    if value is None:
        return ""
    text = f"{value:.0f}" if _LARGE <= abs(value) < _LARGER else f"{value:.3g}"
    return text.replace("-", "\u2212")


def _p_value(value: float | None) -> str:
    return "&lt; 0.0001" if value is not None and value < _SURE else _number(value)


def _sentence(check: Check) -> str:
    lead = "not evaluated: " if check.status == "not evaluated" else ""
    return prose_html(lead + check.meaning)
