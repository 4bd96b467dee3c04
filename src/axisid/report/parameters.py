"""The parameters of the page: least squares beside instruments, with intervals to look at."""

import math
from collections.abc import Sequence
from html import escape

from axisid.codegen import Quantity
from axisid.estimation import Estimate, Identification, Validation, Value
from axisid.estimation.physical_text import physical_notes
from axisid.estimation.summary import drawn_text, record_lines
from axisid.estimation.typeset import readable_unit

_ABOUT = {"idm": "Inverse model", "ddm": "Direct model"}
_WIDTH, _HEIGHT, _EDGE = 170.0, 26.0, 6.0
_VAGUE = 1e4  # % from which a relative deviation says nothing


def parameters_html(
    result: Identification, validation: Validation | None = None, draws: int = 0
) -> str:
    """Tables of the inverse model, of the direct one and draws on request, of a second record."""
    tables = {
        form: [e for e in result.estimates.values() if e.method.startswith(form)] for form in _ABOUT
    }
    shown = [form for form, of_form in tables.items() if of_form]
    parts = [_table(result, tables[form]) for form in shown[:1]]
    parts += [_notes(result), _physical(result)]
    parts += [
        f"<details><summary>{_ABOUT[form]}: its own parameters, and the physical ones mapped from "
        f"them</summary>{_table(result, tables[form])}</details>"
        for form in shown[1:]
    ]
    if draws:
        drawn = escape(drawn_text(result.estimates, draws))
        parts.append(
            f"<details><summary>Intervals from draws</summary><pre>{drawn}</pre></details>"
        )
    parts += [] if validation is None else [_validation(validation)]
    return "".join(parts)


def _table(result: Identification, estimates: Sequence[Estimate]) -> str:
    groups = "".join(f'<th colspan="3">{_method(e.method)}</th>' for e in estimates)
    heads = "<th>value</th><th>95 % interval</th><th>sd</th>" * len(estimates)
    first = estimates[0]
    rows = [_row(q, [e.parameters[q.name] for e in estimates], result) for q in first.quantities]
    rows += [
        _row(q, [e.ddm_parameters[q.name] for e in estimates], result) for q in first.ddm_quantities
    ]
    top = f'<tr><th></th><th class="unit">unit</th>{heads}<th class="unit">intervals</th></tr>'
    return (
        f'<div class="scroll"><table><thead><tr><th></th><th></th>{groups}<th></th></tr>{top}'
        f"</thead><tbody>{''.join(rows)}{_errors(estimates)}</tbody></table></div>"
    )


def _physical(result: Identification) -> str:
    """Physical parameters that are no base parameters, if there are any."""
    every = {method: p for method, p in result.physical.items() if p.shows_more}
    shown = {m: p for m, p in every.items() if m.startswith("idm")} or every
    if not shown:
        return ""
    groups = "".join(f'<th colspan="3">{_method(method)}</th>' for method in shown)
    heads = "<th>value</th><th>95 % interval</th><th>sd</th>" * len(shown)
    first = next(iter(shown.values()))
    rows = [
        _row(
            Quantity(name=name, unit=value.unit, expression=""),
            [p.parameters[name] for p in shown.values()],
            result,
        )
        for name, value in first.parameters.items()
    ]
    top = f'<tr><th></th><th class="unit">unit</th>{heads}<th class="unit">intervals</th></tr>'
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in physical_notes(shown))
    return (
        '<h3>Physical parameters</h3><div class="scroll"><table><thead>'
        f"<tr><th></th><th></th>{groups}<th></th></tr>{top}</thead>"
        f"<tbody>{''.join(rows)}</tbody></table></div>{notes}"
    )


def _method(method: str) -> str:
    kind = method.rsplit("-", 1)[-1]
    return f'<span class="swatch-{kind}">●</span> {escape(method.upper())}'


def _row(quantity: Quantity, values: Sequence[Value], result: Identification) -> str:
    name = escape(quantity.name)
    axis = result.axis
    described = {p.name: p.description for p in (*axis.declared.parameters, *axis.axis.parameters)}
    if about := described.get(quantity.name) or quantity.expression:
        name += f' <span class="note">{escape(about)}</span>'
    places = max(map(_places, values))
    cells = "".join(_cells(value, places) for value in values)
    truth = result.record.provenance.truth.get(quantity.name)
    unit = escape(readable_unit(quantity.unit))
    return (
        f'<tr><th scope="row">{name}</th><td class="unit">{unit}</td>{cells}'
        f'<td class="intervals">{_intervals(values, truth)}</td></tr>'
    )


def _places(value: Value) -> int:
    """Decimal places that show two digits of the deviation."""
    if not 0 < value.deviation < math.inf:
        return 4
    return min(max(0, 1 - math.floor(math.log10(value.deviation))), 12)


def _cells(value: Value, places: int) -> str:
    low, high = value.interval
    relative = value.relative_deviation_percent
    percent = f"{relative:.2f} %" if relative < _VAGUE else "-"
    return (
        f'<td class="value">{_number(value.value, places)}{_corrected(value, places)}</td>'
        f'<td class="range">{_number(low, places)} … {_number(high, places)}</td>'
        f'<td class="range">{percent}</td>'
    )


def _corrected(value: Value, places: int) -> str:
    """The centre of the interval, where it is another number than the value."""
    centre, shown = _number(value.corrected, places), _number(value.value, places)
    return "" if centre == shown else f'<span class="note">{centre} corrected</span>'


def _intervals(values: Sequence[Value], truth: float | None) -> str:
    """Intervals on one scale; least squares above instruments, the truth dotted."""
    ends = [end for value in values for end in value.interval]
    ends += [] if truth is None else [truth]
    low, span = min(ends), max(ends) - min(ends)
    if not 0 < span < float("inf"):
        return ""

    def place(x: float) -> str:
        return f"{_EDGE + (x - low) / span * (_WIDTH - 2 * _EDGE):.1f}"

    marks = ""
    if truth is not None:
        marks += f'<line class="truth" x1="{place(truth)}" x2="{place(truth)}" y1="1" y2="25"/>'
    kinds = ("ls", "iv") if len(values) > 1 else ("iv",)
    for i, (value, kind) in enumerate(zip(values, kinds, strict=True), 1):
        y = _HEIGHT * i / (len(values) + 1)
        first, last = map(place, value.interval)
        marks += (
            f'<g class="{kind}"><line x1="{first}" x2="{last}" y1="{y:.1f}" y2="{y:.1f}"/>'
            f'<circle cx="{place(value.corrected)}" cy="{y:.1f}" r="3"/></g>'
        )
    size = f'viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}"'
    return f'<svg class="interval" {size} role="img" aria-label="intervals">{marks}</svg>'


def _errors(estimates: Sequence[Estimate]) -> str:
    lines = {
        "equation error": ("%", [f"{e.equation_error_percent:.3f}" for e in estimates]),
        "simulation error": ("%", [_percent(e.simulation_error_percent) for e in estimates]),
        "rows": ("", [str(len(e.y)) for e in estimates]),
        "iterations": ("", [str(len(e.iterates) - 1) if e.iterates else "-" for e in estimates]),
    }
    rows: list[str] = []
    for name, (unit, cells) in lines.items():
        shown = "".join(f"<td>{cell}</td><td></td><td></td>" for cell in cells)
        group = "" if rows else ' class="first-of-group"'
        rows.append(f'<tr{group}><td>{name}</td><td class="unit">{unit}</td>{shown}<td></td></tr>')
    return "".join(rows)


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{error:.3f}"


def _notes(result: Identification) -> str:
    judged = result.judged
    notes = [
        "Intervals and sd: "
        f"{judged.covariance_names[judged.chosen]}. Residuals of filtered data are autocorrelated."
    ]
    if any(e.filter_bias is not None for e in result.estimates.values()):
        notes.append(
            "Corrected, and the centre of the interval: the value less the prefilter's own bias, "
            "found on the loop simulated with the estimate."
        )
    if result.record.provenance.truth:
        notes.append("The dotted lines are the true values of the simulated record.")
    remarks: dict[str, list[str]] = {}
    for estimate in result.estimates.values():
        for remark in estimate.remarks:
            remarks.setdefault(remark, []).append(estimate.method.upper())
    notes += [f"{', '.join(of)}: {remark}." for remark, of in remarks.items()]
    missing = {**result.skipped, **result.failed}
    notes += [f"Without {method.upper()}: {reason}" for method, reason in missing.items()]
    return "".join(f'<p class="note">{escape(note)}</p>' for note in notes)


def _validation(validation: Validation) -> str:
    heads = "".join(f"<th>{_method(v.method)}</th>" for v in validation)
    rows = "".join(
        f'<tr><td>{name}</td><td class="unit">{unit}</td>'
        + "".join(f"<td>{'-' if x is None else f'{x:.4g}'}</td>" for x in figures)
        + "</tr>"
        for (name, unit), figures in validation.errors.items()
    )
    told = record_lines(validation.record)
    facts = [f"On {told['record']}.", *(f"{told[k]}." for k in ("assumed", "repaired") if told[k])]
    facts += [f"{note}." for note in validation.notes]
    notes = "".join(f'<p class="note">{escape(fact)}</p>' for fact in facts)
    return (
        "<h2>The estimates, frozen, on a second record</h2>"
        '<div class="scroll"><table><thead><tr><th></th><th class="unit">unit</th>'
        f"{heads}</tr></thead><tbody>{rows}</tbody></table></div>{notes}"
    )


def _number(value: float, places: int) -> str:
    return f"{value:.{places}f}".replace("-", "\u2212")
