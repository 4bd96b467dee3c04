"""An identification as text: heading, tables, verdict and numbered notes."""

import re
from collections.abc import Iterable, Mapping, Sequence

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.diagnostics import Check, by_weight, conclusion, shift
from axisid.estimation.estimates import Estimate, Physical, Value
from axisid.estimation.identification import Identification
from axisid.estimation.records import Record
from axisid.modeling.declaration import left_out_text
from axisid.modeling.quantities import Parameter
from axisid.presentation.formulas import decimals

from .details import details_text
from .physical import physical_notes
from .quantity import number_with_sd, places
from .record import record_lines, rows_text
from .tables import Row, heading_text, numbered, text_table, wrapped

_NOTICEABLE = 0.5  # deviations
_CORRECTED = "without filter bias"


def identification_text(result: Identification, draws: int = 0, *, full: bool = False) -> str:
    """Heading, one table for each model form, physical parameters, and numbered notes.

    See `Identification.summary`.
    """
    estimates, physical, diagnosis = [*result.estimates.values()], result.physical, result.diagnosis
    blocks = [_heading(result.axis, result.record)]
    for form in ("idm", "ddm"):
        of_form = [e for e in estimates if e.method.startswith(form)]
        if of_form:
            blocks.append(_estimates_table(of_form))
    blocks += _physical_table(list(physical.values()))
    blocks.append(_verdict(diagnosis.verdict))
    rows = rows_text(result.record, result.prefilter, len(estimates[0].y))
    made = f"{rows} Generated code {result.axis.signature[:12]}."
    missing = {**result.skipped, **result.failed}
    notes = [*_notes(estimates), *physical_notes(physical), made, *left_out_notes(missing)]
    blocks.append("\n".join(numbered(i, note) for i, note in enumerate(notes, 1)))
    drawn = f"\n{drawn_text(result.estimates, draws)}" if draws else ""
    details = f"\n{details_text(result.estimates, diagnosis)}" if full else ""
    return "\n\n".join(blocks) + "\n" + drawn + details


def _heading(axis: GeneratedAxis, record: Record) -> str:
    declared, source = axis.axis, record.provenance
    return heading_text(
        {
            "axis": declared.name + (f": {declared.title}" if declared.title else ""),
            "left out": left_out_text(axis.declared),
            **record_lines(record),
            "truth": _truth(axis.declared.parameters, source.truth),
            "": _truth([p for p, _ in axis.base.combined], source.truth),
        }
    )


def _truth(parameters: Iterable[Parameter], truth: Mapping[str, float]) -> str:
    return ", ".join(
        f"{p.name} = {truth[p.name]:g} {p.unit}" for p in parameters if p.name in truth
    )


def _estimates_table(estimates: Sequence[Estimate]) -> str:
    header = _header("", [e.method for e in estimates])
    first = estimates[0]
    rows = _value_rows([e.parameters for e in estimates], _labels(first.quantities))
    rows += _value_rows([e.ddm_parameters for e in estimates], _labels(first.ddm_quantities))
    rows.append(_row("equation error", "%", [f"{e.equation_error_percent:.4f}" for e in estimates]))
    rows.append(
        _row(
            "simulation error",
            "%",
            [
                "-" if e.simulation_error_percent is None else f"{e.simulation_error_percent:.4f}"
                for e in estimates
            ],
        )
    )
    rows.append(_row("rows", "", [str(len(e.y)) for e in estimates]))
    rows.append(_row("condition number", "", [f"{e.condition_number:.3f}" for e in estimates]))
    rows.append(
        _row("iterations", "", [str(len(e.iterates) - 1) if e.iterates else "-" for e in estimates])
    )
    return text_table(header, rows)


def _physical_table(found: Sequence[Physical]) -> list[str]:
    """Physical parameters that are no base parameters, if there are any, of one model form."""
    every = [physical for physical in found if physical.shows_more]
    shown = [physical for physical in every if physical.method.startswith("idm")] or every
    if not shown:
        return []
    header = _header("physical parameters", [physical.method for physical in shown])
    names = {name: name for name in shown[0].parameters}
    return [text_table(header, _value_rows([physical.parameters for physical in shown], names))]


def _header(what: str, methods: Iterable[str]) -> list[str]:
    header = [what, "unit"]
    for method in methods:
        header += [method.upper(), "sd [1]", "rel. sd", "i.i.d. [2]"]
    return header


def _labels(quantities: Iterable[Quantity]) -> dict[str, str]:
    return {q.name: f"{q.name} = {q.expression}" if q.expression else q.name for q in quantities}


def _value_rows(columns: Sequence[Mapping[str, Value]], labels: Mapping[str, str]) -> list[Row]:
    rows: list[Row] = []
    for name, label in labels.items():
        cells = [label, columns[0][name].unit]
        for column in columns:
            cells += number_with_sd(column[name])
        rows.append(cells)
        rows += _corrected_row([column[name] for column in columns])
    return rows


def _corrected_row(values: Sequence[Value]) -> list[Row]:
    """The centres of the intervals, where one is noticeably not the value above it."""
    if not any(shift(v.filter_bias, v.deviation) > _NOTICEABLE for v in values):
        return []
    numbers = ["-" if v.filter_bias is None else f"{v.corrected:.{places(v)}f}" for v in values]
    return [_row(f"  {_CORRECTED}", "", numbers)]


def drawn_text(estimates: Mapping[str, Estimate], draws: int) -> str:
    """A table of intervals from draws, beside those of the delta method."""
    rows: list[Row] = []
    lost, seed = 0, 0
    for method, estimate in estimates.items():
        for name, value in estimate.parameters.items():
            drawn = estimate.propagate(name, draws=draws)
            lost = max(lost, drawn.lost)
            seed = drawn.seed
            rows.append(
                [
                    f"{method.upper()} {name}",
                    value.unit,
                    *(
                        f"{x:.{decimals(value.deviation)}f}"
                        for x in (drawn.median, *drawn.interval, *value.interval)
                    ),
                ]
            )
    header = ["", "unit", "median", "drawn 2.5 %", "97.5 %", "delta 2.5 %", "97.5 %"]
    said = f"{draws} draws from each estimate's distribution (seed {seed}), mapped exactly"
    if lost:
        said += f"; up to {lost} gave no positive inertia and are left out"
    return f"{text_table(header, rows)}\n{said}.\n"


def _row(label: str, unit: str, cells: Sequence[str]) -> Row:
    return [label, unit, *(c for cell in cells for c in (cell, "", "", ""))]


def _notes(estimates: Sequence[Estimate]) -> list[str]:
    methods = [e.method for e in estimates]
    names = [e.covariance_names for e in estimates]
    chosen = estimates[0].chosen
    lags = dict.fromkeys(match for n in names for match in re.findall(r"(\d+) lags", n[chosen]))
    name = re.sub(r"\d+ lags", f"{', '.join(lags)} lags", names[0][chosen])
    allowed = (
        "are autocorrelated" if chosen == "hac" else "are autocorrelated, which HAC allows for"
    )
    notes = [
        f"sd and 95 % intervals: {name}. Residuals of filtered data {allowed}.",
        f"i.i.d. sd, as in the published tables: {names[0]['iid']}.",
    ]
    notes += _gain_notes(estimates[-1])
    notes += _filter_notes(estimates)
    if any(method.startswith("ddm") for method in methods):
        notes.append("sd of physical parameters from a direct model: delta method.")
    notes.append(
        "y is the force (IDM) or the acceleration (DDM). Equation error ||y - X theta||/||y||: no "
        "quality measure of an IV estimate on noisy data. Simulation error "
        "||y - y_simulated||/||y||: the closed loop simulated with the estimate."
    )
    if {"idm-iv", "ddm-iv"} <= set(methods):
        notes.append(
            "IDM-IV and DDM-IV solve the same equations with the same instruments; their agreement "
            "is a self-test, not a second opinion."
        )
    return notes + shared_remarks(estimates)


def shared_remarks(estimates: Iterable[Estimate]) -> list[str]:
    """Each remark once, with the methods that it is of."""
    shared: dict[str, list[str]] = {}
    for estimate in estimates:
        for remark in estimate.remarks:
            shared.setdefault(remark, []).append(estimate.method)
    return [f"{', '.join(of)}: {_sentence(remark)}" for remark, of in shared.items()]


def _filter_notes(estimates: Sequence[Estimate]) -> list[str]:
    """What the rows of corrected values are, if there are any."""
    values = [v for e in estimates for v in e.parameters.values()]
    if not any(_corrected_row([v]) for v in values):
        return []
    return [
        f"{_CORRECTED}: the value above without the prefilter's own bias, which is found on the "
        "loop simulated with the estimate. It is the centre of the 95 % interval, and what "
        "physical parameters are made of."
    ]


def _gain_notes(estimate: Estimate) -> list[str]:
    relative = estimate.gain_relative_sd
    if relative == 0:
        return []
    listed = ", ".join(
        f"{name} +- {value.sd_gain:.3g} {value.unit}" for name, value in estimate.parameters.items()
    )
    return [
        f"The drive gain is declared to {100 * relative:.3g} %; that moves all parameters together "
        f"and is in no sd of the table: {listed} ({estimate.method})."
    ]


def _verdict(checks: Sequence[Check]) -> str:
    """Whether to believe it, a sentence for each check that did not pass, and what passed."""
    ordered = by_weight(checks)
    lines = [wrapped("verdict    ", conclusion(checks)), ""]
    for status, head in (("fail", "FAIL   "), ("note", "note   ")):
        told = [c for c in ordered if c.status == status]
        lines += [wrapped(head, f"{check.name}: {check.meaning}") for check in told]
    skipped: dict[str, list[str]] = {}
    for check in checks:
        if check.status == "not evaluated":
            skipped.setdefault(check.meaning, []).append(check.name)
    lines += [
        wrapped("-      ", f"{', '.join(names)}: not evaluated, {why}")
        for why, names in skipped.items()
    ]
    passed = [check.name for check in checks if check.status == "pass"]
    lines += [wrapped("pass   ", ", ".join(passed))] if passed else []
    return "\n".join(lines)


def left_out_notes(missing: Mapping[str, str]) -> list[str]:
    """Each reason once, with the methods that are missing for it."""
    shared: dict[str, list[str]] = {}
    for method, reason in missing.items():
        shared.setdefault(reason.removeprefix(f"{method}, "), []).append(method)
    return [f"without {', '.join(of)}: {_sentence(reason)}" for reason, of in shared.items()]


def _sentence(text: str) -> str:
    return text if text.endswith(".") else f"{text}."


def failed(name: str, meaning: str) -> str:
    """A failed check, as in a verdict."""
    return wrapped("FAIL   ", f"{name}: {meaning}")
