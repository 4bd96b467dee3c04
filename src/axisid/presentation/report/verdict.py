"""The verdict on top of the page."""

from collections.abc import Sequence
from html import escape

from axisid.estimation.diagnostics import Check, by_weight, conclusion
from axisid.presentation.html import prose_html

_SIGNS = {"pass": "✓", "note": "○", "fail": "✗", "not evaluated": "·"}
_CLASSES = {"pass": "pass", "note": "noted", "fail": "fail", "not evaluated": "missing"}
_ORDER = ("fail", "note", "not evaluated", "pass")

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
    ordered = sorted(by_weight(checks), key=lambda c: _ORDER.index(c.status))
    passed = [c for c in checks if c.status == "pass"]
    bars = "".join(
        f'<span class="{_CLASSES[c.status]}" title="{escape(c.name)}"></span>'
        for c in reversed(ordered)
    )
    items = _items([c for c in ordered if c.status == "fail"])
    others = _items([c for c in ordered if c.status in ("note", "not evaluated")])
    folded = (
        f'<details><summary>{_counted(checks)}</summary><ul class="checks">{others}</ul></details>'
        if others
        else ""
    )
    names = escape(", ".join(c.name for c in passed)) or "nothing"
    return (
        f'<section class="verdict" id="verdict"><h2>{prose_html(conclusion(checks))}</h2>'
        f'<div class="tally" aria-hidden="true">{bars}</div>'
        f'<p class="passed"><span class="sign pass">✓</span>{names}</p>'
        f'<ul class="checks">{items}</ul>{folded}'
        f"<details><summary>Every check with its figure and threshold</summary>{_table(ordered)}"
        f'</details><p class="note">The checks are of {escape(judged.upper())}. A failed check is '
        "a reason to look, not a gate.</p></section>"
    )


def _items(checks: Sequence[Check]) -> str:
    return "".join(
        f"<li>{_sign(c)}<span><b>{escape(c.name.capitalize())}:</b> {_sentence(c)}</span></li>"
        for c in checks
    )


def _counted(checks: Sequence[Check]) -> str:
    """How many checks are told apart because what is printed allows for them, or were not made."""
    counts = {status: sum(c.status == status for c in checks) for status in _ORDER}
    told = [f"{counts['note']} allowed for in these numbers"] if counts["note"] else []
    told += [f"{counts['not evaluated']} not evaluated"] if counts["not evaluated"] else []
    return f"Further checks: {', '.join(told)}"


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
