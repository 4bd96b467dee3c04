"""The verdict on top of the page, and its parameters with intervals to look at."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape

from axisid.codegen.artefacts import Quantity
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import by_weight, conclusion
from axisid.estimation.estimates import CORRECTED, Value
from axisid.estimation.lack_of_fit import JackknifeInterval
from axisid.estimation.studies import Validation
from axisid.presentation.blocks import Cell, Column, Interval, Intervals, NotedText, Table
from axisid.presentation.formulas import decimals, significant, true_minus
from axisid.presentation.html import (
    STATUS_CLASSES,
    checks_html,
    method_kind,
    prose_html,
    sign_html,
    table_html,
)
from axisid.presentation.saved import SavedEstimate, SavedIdentification
from axisid.presentation.text import (
    checks_table,
    iterations,
    missing_notes,
    moves_notes,
    physical_notes,
    preferred_physical,
    record_facts,
    records_table,
    shared_remarks,
    validation_table,
    verdict_block,
)

_STATUSES = ("fail", "note", "not evaluated", "pass")
_ABOUT = {False: "Inverse model", True: "Direct model"}
_VAGUE = 1e4  # % from which a relative deviation says nothing
_COLUMNS = (
    Column("", align="left"),
    Column("", kind="method"),
    Column("value", kind="value"),
    Column("95 % interval", kind="range between"),
    Column("sd", kind="range sd"),
    Column("rel. sd", kind="range relative"),
    Column("intervals", align="left", kind="intervals"),
)
_ERRORS = (
    Column("", kind="method"),
    *map(Column, ("equation error", "simulation error", "rows", "iterations")),
)


def verdict_html(checks: Sequence[Check], judged: str) -> str:
    """How many checks passed, each that did not in a sentence, and all of them in a table.

    Parameters
    ----------
    checks : sequence of Check
    judged : str
        The method they are of.
    """
    ordered = sorted(by_weight(checks), key=lambda c: _STATUSES.index(c.status))
    bars = "".join(
        f'<span class="{STATUS_CLASSES[c.status]}" title="{escape(c.name)}"></span>'
        for c in reversed(ordered)
    )
    groups = verdict_block(checks).judged
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
    counts = {status: sum(c.status == status for c in checks) for status in _STATUSES}
    counted = [f"{counts['note']} allowed for in these numbers"] if counts["note"] else []
    counted += [f"{counts['not evaluated']} not evaluated"] if counts["not evaluated"] else []
    return f"Further checks: {', '.join(counted)}"


def parameters_html(
    result: SavedIdentification,
    described: Mapping[str, str],
    validations: Sequence[Validation] = (),
) -> str:
    """Tables of the inverse model, of the direct one, of further records.

    `described` has what a parameter is, in words, by its name, where that was declared.
    """
    tables = {
        direct: [e for e in result.estimates.values() if e.is_direct == direct] for direct in _ABOUT
    }
    shown = [form for form, of_form in tables.items() if of_form]
    parts = [_of_form(result, described, tables[form]) for form in shown[:1]]
    if result.of_records:
        parts.append(f"<h3>The records</h3>{_scrolled(records_table(result))}")
    parts += [_notes(result), _physical(result, described)]
    parts += [
        f"<details><summary>{_ABOUT[form]}: its own parameters, and the physical ones mapped from "
        f"them</summary>{_of_form(result, described, tables[form])}</details>"
        for form in shown[1:]
    ]
    parts += [_validation(each) for each in validations]
    return "".join(parts)


def _scrolled(table: Table, css: str = "") -> str:
    """A table that may be wider than the page, and what is said of it."""
    html = table_html(table, css, grouped=css == "parameters")
    return f'<div class="scroll">{html}</div>{_note_lines(table.said)}'


def _note_lines(notes: Sequence[str]) -> str:
    return "".join(f'<p class="note">{prose_html(note)}</p>' for note in notes)


def _of_form(
    result: SavedIdentification, described: Mapping[str, str], estimates: Sequence[SavedEstimate]
) -> str:
    first = estimates[0]
    groups = [(q, {e.method: e.parameters[q.name] for e in estimates}) for q in first.quantities]
    groups += [
        (q, {e.method: e.ddm_parameters[q.name] for e in estimates}) for q in first.ddm_quantities
    ]
    values = parameters_table(result, described, groups, over_moves=True)
    tables = (values, "parameters"), (errors_table(estimates), "errors")
    return "".join(_scrolled(table, css) for table, css in tables)


def _physical(result: SavedIdentification, described: Mapping[str, str]) -> str:
    """Physical parameters that are no base parameters, if there are any."""
    shown = preferred_physical(result)
    if not shown:
        return ""
    first = next(iter(shown.values()))
    groups = [
        (
            Quantity(name=name, unit=value.unit, expression=""),
            {method: p.parameters[name] for method, p in shown.items()},
        )
        for name, value in first.parameters.items()
    ]
    table = _scrolled(parameters_table(result, described, groups), "parameters")
    return f"<h3>Physical parameters</h3>{table}{_note_lines(physical_notes(shown))}"


def parameters_table(
    result: SavedIdentification,
    described: Mapping[str, str],
    groups: Sequence[tuple[Quantity, Mapping[str, Value]]],
    *,
    over_moves: bool = False,
) -> Table:
    """A row for each method, so that a page of any width has room for all columns.

    Parameters
    ----------
    result : SavedIdentification
    described : mapping of str to str
        What each is, in words.
    groups : sequence of (Quantity, mapping of str to Value)
        Each parameter with its values by method.
    over_moves : bool
        Whether deviations of the model's error stand behind those that they exceed, and what noise
        has moved a value by behind its interval.
    """
    rows: list[tuple[Cell, ...]] = []
    for quantity, values in groups:
        about = described.get(quantity.name) or quantity.expression
        name = NotedText(quantity.name, quantity.unit, about)
        drawn = _intervals(values, result.record.provenance.truth.get(quantity.name))
        for i, (method, value) in enumerate(values.items()):
            ends = (None, None) if i else (name, drawn)
            bands = result.diagnosis.bands.get(method, {}) if over_moves else {}
            rows.append((ends[0], method, *_cells(value, bands.get(quantity.name)), ends[1]))
    return Table(columns=_COLUMNS, rows=tuple(rows))


def _cells(value: Value, band: JackknifeInterval | None = None) -> tuple[Cell, ...]:
    """Value, interval, deviation and relative deviation.

    The interval's centre is a note where it is noticeably another number, as in the text.
    """
    digits = decimals(value.deviation)
    low, high = (_number(end, digits) for end in value.interval)
    centre, fitted = _number(value.corrected, digits), _number(value.value, digits)
    relative = value.relative_deviation_percent
    return (
        NotedText(fitted, note=f"{centre} {CORRECTED}" if value.is_shifted else ""),
        f"{low} … {high}",
        significant(value.deviation) if band is None or not band.exceeds else _both(value, band),
        f"{significant(relative)} %" if relative < _VAGUE else "-",
    )


def _both(value: Value, band: JackknifeInterval) -> NotedText:
    """The deviation, and that of the model's error behind it."""
    return NotedText(significant(value.deviation), note=f"{significant(band.deviation)} over moves")


def _intervals(values: Mapping[str, Value], truth: float | None) -> Intervals:
    """In the order of the methods."""
    intervals = (
        Interval(value.interval[0], value.corrected, value.interval[1], method_kind(method))
        for method, value in values.items()
    )
    return Intervals(tuple(intervals), truth)


def errors_table(estimates: Sequence[SavedEstimate]) -> Table:
    """What is known of each estimate as a whole."""
    rows = (
        (
            e.method,
            _percent(None if e.by_output_error else e.equation_error_percent),
            _percent(e.simulation_error_percent),
            str(e.document.rows),
            iterations(e),
        )
        for e in estimates
    )
    return Table(columns=_ERRORS, rows=tuple(rows))


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{significant(error, 3)} %"


def _notes(result: SavedIdentification) -> str:
    preferred = result.preferred
    notes = [
        "Intervals and sd: "
        f"{preferred.covariance_names[preferred.chosen]}. Residuals of filtered data are "
        "autocorrelated."
    ]
    if any(e.filter_bias is not None for e in result.estimates.values()):
        notes.append(
            "Intervals are less what filter and noise move the estimates by, as twins tell; below "
            "a value what it is less that, where that is another."
        )
    if result.record.provenance.truth:
        notes.append("The dotted lines are the true values of the simulated record.")
    notes += moves_notes(result.diagnosis)
    notes += shared_remarks(list(result.estimates.values()))
    notes += missing_notes({**result.skipped, **result.failed}, result.diagnosis.verdict)
    return _note_lines(notes)


def _validation(validation: Validation) -> str:
    heading = record_facts(validation.record)
    # Names that a file brings stay as they are.
    facts = [
        f"On {heading['record']}.",
        *(f"{heading[k]}." for k in ("assumed", "repaired") if heading[k]),
    ]
    about = "".join(f'<p class="note">{escape(fact)}</p>' for fact in facts)
    table = _scrolled(validation_table(validation))
    return f"<h2>The estimates, frozen, on a second record</h2>{about}{table}"


def _number(value: float, places: int) -> str:
    return true_minus(f"{value:.{places}f}")
