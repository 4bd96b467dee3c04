"""The verdict on top of the page."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import by_weight, conclusion
from axisid.presentation.html import (
    STATUS_CLASSES,
    checks_html,
    prose_html,
    sign_html,
    table_html,
)
from axisid.presentation.text import checks_table, verdict_block
from axisid.support.remedy import Wording, as_arguments

_ORDER = ("fail", "note", "not evaluated", "pass")


def verdict_html(checks: Sequence[Check], judged: str, wording: Wording = as_arguments) -> str:
    """How many checks passed, each that did not in a sentence, and all of them in a table.

    Parameters
    ----------
    checks : sequence of Check
    judged : str
        The method they are of.
    wording : callable
        How settings are told.
    """
    ordered = sorted(by_weight(checks), key=lambda c: _ORDER.index(c.status))
    bars = "".join(
        f'<span class="{STATUS_CLASSES[c.status]}" title="{escape(c.name)}"></span>'
        for c in reversed(ordered)
    )
    groups = verdict_block(checks, wording).judged
    passed = next((each.names for each in groups if each.status == "pass"), ("nothing",))
    items = checks_html(tuple(each for each in groups if each.status == "fail"))
    others = tuple(each for each in groups if each.status in ("note", "not evaluated"))
    folded = (
        f"<details><summary>{_counted(checks)}</summary>{checks_html(others)}</details>"
        if others
        else ""
    )
    names = escape(", ".join(passed))
    table = replace(checks_table(ordered, sources=True), title="")
    return (
        f'<section class="verdict" id="verdict"><h2>{prose_html(conclusion(checks))}</h2>'
        f'<div class="tally" aria-hidden="true">{bars}</div>'
        f'<p class="passed">{sign_html("pass")}{names}</p>'
        f"{items}{folded}"
        "<details><summary>Every check with its figure and threshold</summary>"
        f'<div class="scroll">{table_html(table)}</div>'
        f'</details><p class="note">The checks are of {escape(judged.upper())}. A failed check is '
        "a reason to look, not a gate.</p></section>"
    )


def _counted(checks: Sequence[Check]) -> str:
    """How many checks are told apart because what is printed allows for them, or were not made."""
    counts = {status: sum(c.status == status for c in checks) for status in _ORDER}
    counted = [f"{counts['note']} allowed for in these numbers"] if counts["note"] else []
    counted += [f"{counts['not evaluated']} not evaluated"] if counts["not evaluated"] else []
    return f"Further checks: {', '.join(counted)}"
