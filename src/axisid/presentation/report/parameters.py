"""The parameters of the page: least squares beside instruments, with intervals to look at."""

from collections.abc import Mapping, Sequence
from html import escape

from axisid.codegen.artefacts import Quantity
from axisid.estimation.estimates import Estimate, Value
from axisid.estimation.identification import Identification
from axisid.estimation.studies import Validation
from axisid.presentation.formulas import decimals, readable_unit, significant, true_minus
from axisid.presentation.html import prose_html, table_html
from axisid.presentation.text import (
    drawn_table,
    left_out_notes,
    physical_notes,
    record_facts,
    shared_remarks,
)

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
        drawn = table_html(drawn_table(result.estimates, draws))
        parts.append(f"<details><summary>Intervals from draws</summary>{drawn}</details>")
    parts += [] if validation is None else [_validation(validation)]
    return "".join(parts)


def _table(result: Identification, estimates: Sequence[Estimate]) -> str:
    first = estimates[0]
    methods = [e.method for e in estimates]
    groups = [
        _group(
            q, dict(zip(methods, [e.parameters[q.name] for e in estimates], strict=True)), result
        )
        for q in first.quantities
    ]
    groups += [
        _group(
            q,
            dict(zip(methods, [e.ddm_parameters[q.name] for e in estimates], strict=True)),
            result,
        )
        for q in first.ddm_quantities
    ]
    return _parameter_table(groups) + _errors(estimates)


def _parameter_table(groups: Sequence[str]) -> str:
    """A row for each method, so that a page of any width has room for all columns."""
    heads = "<th>value</th><th>95 % interval</th><th>sd</th><th>rel. sd</th>"
    return (
        '<div class="scroll"><table class="parameters"><thead><tr><th></th>'
        f'<th class="method"></th>{heads}<th class="unit">intervals</th></tr></thead>'
        f"{''.join(groups)}</table></div>"
    )


def _physical(result: Identification) -> str:
    """Physical parameters that are no base parameters, if there are any."""
    every = {method: p for method, p in result.physical.items() if p.shows_more}
    shown = {m: p for m, p in every.items() if m.startswith("idm")} or every
    if not shown:
        return ""
    first = next(iter(shown.values()))
    groups = [
        _group(
            Quantity(name=name, unit=value.unit, expression=""),
            {method: p.parameters[name] for method, p in shown.items()},
            result,
        )
        for name, value in first.parameters.items()
    ]
    notes = "".join(f'<p class="note">{prose_html(note)}</p>' for note in physical_notes(shown))
    return f"<h3>Physical parameters</h3>{_parameter_table(groups)}{notes}"


def _method(method: str) -> str:
    kind = method.rsplit("-", 1)[-1]
    return f'<span class="swatch-{kind}">●</span> {escape(method.upper())}'


def _group(quantity: Quantity, values: Mapping[str, Value], result: Identification) -> str:
    """One parameter: its name and unit, and a row for each method."""
    unit = escape(readable_unit(quantity.unit))
    name = f'{escape(quantity.name)} <span class="unit">{unit}</span>'
    axis = result.axis
    described = {p.name: p.description for p in (*axis.declared.parameters, *axis.axis.parameters)}
    if about := described.get(quantity.name) or quantity.expression:
        name += f' <span class="note">{escape(about)}</span>'
    truth = result.record.provenance.truth.get(quantity.name)
    over = f' rowspan="{len(values)}"'
    lead = f'<th scope="rowgroup"{over}>{name}</th>'
    drawn = f'<td class="intervals"{over}>{_intervals(list(values.values()), truth)}</td>'
    rows = [
        f'<td class="method">{_method(method)}</td>{_cells(value)}'
        for method, value in values.items()
    ]
    rows[0] = f"{lead}{rows[0]}{drawn}"
    return f"<tbody>{''.join(f'<tr>{row}</tr>' for row in rows)}</tbody>"


def _cells(value: Value) -> str:
    low, high = value.interval
    places = decimals(value.deviation)
    return (
        f'<td class="value">{_number(value.corrected, places)}{_uncorrected(value, places)}</td>'
        f'<td class="range between">{_number(low, places)} … {_number(high, places)}</td>'
        f'<td class="range sd">{significant(value.deviation)}</td>'
        f'<td class="range relative">{_relative(value)}</td>'
    )


def _relative(value: Value) -> str:
    """Of the value, in percent, to two digits however small it is."""
    relative = value.relative_deviation_percent
    return f"{significant(relative)} %" if relative < _VAGUE else "-"


def _uncorrected(value: Value, places: int) -> str:
    """The estimator's own value, where it is another number than the centre of the interval."""
    centre, shown = _number(value.corrected, places), _number(value.value, places)
    return "" if centre == shown else f'<span class="note">{shown} as fitted</span>'


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
    """What is known of each estimate as a whole."""
    heads = "<th>equation error</th><th>simulation error</th><th>rows</th><th>iterations</th>"
    rows = "".join(
        f'<tr><td class="method">{_method(e.method)}</td>'
        f"<td>{_percent(e.equation_error_percent)}</td>"
        f"<td>{_percent(e.simulation_error_percent)}</td><td>{len(e.y)}</td>"
        f"<td>{len(e.iterates) - 1 if e.iterates else '-'}</td></tr>"
        for e in estimates
    )
    return (
        f'<div class="scroll"><table class="errors"><thead><tr><th></th>{heads}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _percent(error: float | None) -> str:
    return "-" if error is None else f"{significant(error, 3)} %"


def _notes(result: Identification) -> str:
    judged = result.judged
    notes = [
        "Intervals and sd: "
        f"{judged.covariance_names[judged.chosen]}. Residuals of filtered data are autocorrelated."
    ]
    if any(e.filter_bias is not None for e in result.estimates.values()):
        notes.append(
            "Values are without the prefilter's own bias, which is found on the loop simulated "
            "with the estimate; below them the value as fitted, where it is another."
        )
    if result.record.provenance.truth:
        notes.append("The dotted lines are the true values of the simulated record.")
    notes += shared_remarks(list(result.estimates.values()))
    notes += left_out_notes({**result.skipped, **result.failed})
    return "".join(f'<p class="note">{prose_html(note)}</p>' for note in notes)


def _validation(validation: Validation) -> str:
    heads = "".join(f"<th>{_method(v.method)}</th>" for v in validation)
    rows = "".join(
        f'<tr><td>{name}</td><td class="unit">{escape(readable_unit(unit))}</td>'
        + "".join(f"<td>{'-' if x is None else significant(x, 4)}</td>" for x in figures)
        + "</tr>"
        for (name, unit), figures in validation.errors.items()
    )
    told = record_facts(validation.record)
    # Names that a file brings stay as they are.
    facts = [f"On {told['record']}.", *(f"{told[k]}." for k in ("assumed", "repaired") if told[k])]
    sentences = [*map(escape, facts), *map(prose_html, validation.notes)]
    notes = "".join(f'<p class="note">{sentence}</p>' for sentence in sentences)
    return (
        "<h2>The estimates, frozen, on a second record</h2>"
        '<div class="scroll"><table><thead><tr><th></th><th class="unit">unit</th>'
        f"{heads}</tr></thead><tbody>{rows}</tbody></table></div>{notes}"
    )


def _number(value: float, places: int) -> str:
    return true_minus(f"{value:.{places}f}")
