"""An identification as a document: heading, tables, verdict and numbered notes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.estimates import CORRECTED, Value
from axisid.estimation.misspecification import JackknifeInterval
from axisid.estimation.unknowns import GAIN
from axisid.estimation.verdict_checks import KINDS, Check, by_weight, conclusion, lines_of
from axisid.modeling.declaration import known_text
from axisid.modeling.quantities import Parameter
from axisid.presentation.documents import (
    Cell,
    CheckGroup,
    Checks,
    Document,
    Heading,
    Interval,
    Intervals,
    Notes,
    Paragraph,
    Sentence,
    Status,
    TableBlock,
    TableColumn,
    decimals,
    text_columns,
    text_table,
    without_empty_last_column,
)
from axisid.presentation.result_files import SavedEstimate, SavedIdentification
from axisid.presentation.sentences import (
    conclusion_text,
    covariance_in_short,
    iid_text,
    shared_covariance_text,
)
from axisid.support.checks import is_nothing
from axisid.support.mappings import grouped
from axisid.support.settings import all_methods, setting
from axisid.support.wording import listed, or_dash, range_text

from .identification_details import (
    band_row,
    details_document,
    equation_error,
    iterations,
    moves_notes,
    physical_notes,
    places,
    quantity,
)
from .record import (
    force_told,
    records_facts,
    records_table,
    rows_text,
    set_aside_facts,
    several_notes,
    signals_text,
)


def saved_document(
    result: SavedIdentification,
    draws: int = 0,
    *,
    every: bool = False,
    full: bool = False,
) -> Document:
    """Return an identification as a document.

    By default it fits on a screen: heading, judged estimate, verdict, and a note on the rows.

    Parameters
    ----------
    result : SavedIdentification
    draws : int
        Number of draws from the distribution of each estimate; 0 for no table of draws.
    every : bool
        True to show all methods with notes.
    full : bool
        True to show also all diagnostics and checks.
    """
    drawn = () if is_nothing(draws) else (draws_table(result.estimates, draws),)
    if not (every or full):
        return (*_screen(result), *drawn)
    estimates, document = [*result.estimates.values()], result.document
    referred = _notes_of_columns(estimates)
    notes = [
        *referred,
        *_notes(estimates),
        *shared_remarks(estimates),
        *physical_notes(result.physical),
        *([f"Checks apply to the {document.judged.upper()} estimate."] * (len(estimates) > 1)),
        *plus_minus_notes(result.verdict),
        *_left_out_notes(result),
        *moves_notes(document),
        *several_notes(result),
        f"{rows_of(result)}{signals_text(result.signals)} Hash of the generated code: "
        f"{result.signature[:12]}.",
        *missing_notes({**result.skipped, **result.failed}, result.verdict),
    ]
    bands, truth = document.model_bands or {}, result.record.provenance.truth
    tables: list[TableBlock] = []
    for is_direct in (False, True):  # the inverse models first
        of_form = [each for each in estimates if each.is_direct == is_direct]
        # Two estimates next to each other are as wide as a terminal.
        pairs = [of_form[i : i + 2] for i in range(0, len(of_form), 2)]
        tables += [_estimates_table(pair, bands, truth) for pair in pairs]
    return (
        _heading(result),
        *tables,
        *_physical_tables(result),
        *((records_table(result),) if result.of_records else ()),
        verdict_block(result.verdict),
        Notes(tuple(notes), numbered=len(referred)),
        *drawn,
        *(details_document(result) if full else ()),
    )


def _screen(result: SavedIdentification) -> Document:
    """Return the document that fits on a screen: judged estimate, failed checks and rows.

    If a check fails, methods without an estimate are named without reasons, because the failed
    check explains them. Notes of the verdict are only named by their lines.
    """
    noted = dict.fromkeys(c.line for c in by_weight(result.verdict) if c.status == "note")
    missing = {**result.skipped, **result.failed}
    fails = any(check.status == "fail" for check in result.verdict)
    not_estimated = missing_notes(missing, result.verdict)
    if fails:
        not_estimated = [f"Not estimated: {', '.join(missing).upper()}."] if missing else []
    verdict = verdict_block(result.verdict)
    shown = all_methods()
    more = f"{'Add' if shown.startswith('-') else 'Call'} {shown} to print all methods"
    if noted:
        lines = "line" if len(noted) == 1 else "lines"
        names = listed([f'"{line}"' for line in noted])
        more += f", and the notes of the {lines} {names}"
    failed = [check for check in result.verdict if check.status == "fail"]
    texts = [
        *shared_remarks([result.preferred]),
        *_left_out_notes(result),
        *not_estimated,
        " ".join((_rows_in_short(result), *plus_minus_notes(failed), f"{more}.")),
    ]
    return (
        _heading(result),
        judged_table(result),
        *((records_table(result),) if result.of_records else ()),
        replace(verdict, judged=tuple(e for e in verdict.judged if e.status != "note")),
        Paragraph(sentences=tuple(Sentence(text=text) for text in texts)),
    )


def plus_minus_notes(checks: Iterable[Check]) -> list[str]:
    """Return a note on the numbers after ``+-`` in the sentences of checks, in a list.

    The list is empty if no sentence has such a number.
    """
    if any("+-" in check.meaning for check in checks):
        return ["The number after +- is one standard error."]
    return []


def _left_out_notes(result: SavedIdentification) -> list[str]:
    """Return a note on left-out parameters, in a list, if *missing terms* fails; else empty.

    A missing term is then declared already and only left out.
    """
    names = [*(result.document.left_out or {})]
    fails = any(c.name == "missing terms" and c.status == "fail" for c in result.verdict)
    if not (names and fails):
        return []
    parameters = "The declared parameter" if len(names) == 1 else "The declared parameters"
    verb = "is" if len(names) == 1 else "are"
    options = " or ".join(setting("leave_out", name) for name in names)
    return [
        f"{parameters} {', '.join(names)} {verb} left out of the model. If this is the missing "
        f"term, identify without {options}."
    ]


def _rows_in_short(result: SavedIdentification) -> str:
    """Return a sentence on the rows, the filter and the standard errors of the judged estimate."""
    judged, settings = result.preferred, result.sampling.filter.settings
    filtered = f"a {settings.cutoff:g} Hz low-pass"
    if settings.decimate > 1:
        filtered += f" and decimation by {settings.decimate}"
    covariance = covariance_in_short(judged.covariance_notes[judged.chosen])
    text = f"{judged.document.rows} rows after {filtered}. Standard errors: {covariance}."
    if gain := judged.gain_relative_sd:
        text += f" They exclude the uncertainty of the drive gain, {100 * gain:.3g} %."
    return text


def judged_table(result: SavedIdentification) -> TableBlock:
    """Return the table of the judged estimate, corrected for the bias of filter and noise.

    The estimate by IDM-LS is in a further column if a value of it lies outside the interval. So are
    the values in a model with the missing terms, if the model error changes a value noticeably.
    """
    judged = result.preferred
    least_squares = _least_squares(result)
    values = _judged_values(result)
    heads = [judged.method.upper(), "sd", "95 % interval", *(["IDM-LS"] if least_squares else [])]
    bands = (result.document.model_bands or {}).get(judged.method, {})
    larger_model = {
        name: text
        for name, value in values.items()
        if (text := _with_missing_terms(result, name, bands.get(name), decimals(value.deviation)))
    }
    rows: list[tuple[Cell, ...]] = []
    for name, value in values.items():
        digits = decimals(value.deviation)
        sd = interval = "-"
        if value.deviation:
            sd = f"{value.deviation:.{digits}f}"
            interval = " to ".join(f"{end:.{digits}f}" for end in value.interval)
        cells = [name, value.unit, f"{value.corrected:.{digits}f}", sd, interval]
        if least_squares:
            is_known = name in least_squares
            cells.append(f"{least_squares[name].value:.{digits}f}" if is_known else "")
        if larger_model:
            cells.append(larger_model.get(name, ""))
        remarks = _remarks(result, name, value, bands.get(name), has_larger=name in larger_model)
        rows.append((*cells, ", ".join(remarks)))
    more = ["missing terms added"] if larger_model else []
    table = TableBlock(
        columns=(
            *text_columns(["", "unit", *heads]),
            *(TableColumn(head, align="left") for head in (*more, "remark")),
        ),
        rows=tuple(rows),
        labels=2,
    )
    return without_empty_last_column(table)


def _judged_values(result: SavedIdentification) -> dict[str, Value]:
    """Return the values of the judged estimate by name, with calculated declared parameters."""
    values = {**result.preferred.parameters}
    physical = result.physical.get(result.preferred.method)
    if physical and physical.shows_more:
        values |= physical.parameters
    return values


def _least_squares(result: SavedIdentification) -> Mapping[str, Value]:
    """Return the estimate by IDM-LS, by parameter.

    It is empty if it is the judged estimate, if it is missing, or if all its values are within the
    intervals of the judged estimate.
    """
    estimate = result.estimates.get("idm-ls")
    if estimate is None or estimate is result.preferred:
        return {}
    judged = _judged_values(result)
    for name, value in estimate.parameters.items():
        low, high = judged[name].interval
        if not low <= value.value <= high:
            return estimate.parameters
    return {}


def _remarks(
    result: SavedIdentification,
    name: str,
    value: Value,
    band: JackknifeInterval | None,
    *,
    has_larger: bool,
) -> list[str]:
    """Return the remarks on one parameter: known values, bias and model error.

    Parameters
    ----------
    result : SavedIdentification
    name : str
    value : Value
        Value of the parameter by the judged method.
    band : JackknifeInterval or None
        Interval of the parameter with the model error, if it is known.
    has_larger : bool
        True if the table has the value with the missing terms; the model error is then left out.
    """
    digits = decimals(value.deviation)
    physical = result.physical.get(result.preferred.method)
    remarks = []
    if name == GAIN:
        remarks.append(f"declared {result.declared_gain:g}")
    for parameter in physical.known if physical else ():
        if parameter.name == name:
            known = f"known {known_text(parameter.known, parameter.known_sd)}"
            remarks.append(known if value.deviation else "fixed")
    if value.is_shifted:
        remarks.append(f"{value.value:.{digits}f} with bias")
    if band is not None and band.exceeds and not has_larger:
        remarks.append(f"model error: {range_text(*band.interval, ' to ')}")
    return remarks


def _with_missing_terms(
    result: SavedIdentification, name: str, band: JackknifeInterval | None, digits: int
) -> str:
    """Return the value of a parameter in the model with the missing terms that the verdict names.

    It has two values, forward and backward, for a parameter that differs between directions. It is
    empty if no terms are named, or if the model error of the parameter is not noticeable.

    Parameters
    ----------
    result : SavedIdentification
    name : str
        Name of the parameter.
    band : JackknifeInterval or None
        Interval that contains the model error; None if there is none.
    digits : int
        Number of decimal places.
    """
    with_terms = (result.document.with_missing_terms or {}).get(name, ())
    values = [f"{value:.{digits}f}" for value in with_terms]
    if len(values) == 2:
        return f"{values[0]} forward, {values[1]} backward"
    is_noticeable = band is not None and band.exceeds
    return values[0] if values and is_noticeable else ""


def rows_of(result: SavedIdentification) -> str:
    """Return a note on the rows of the regression: number, filters and source of the force."""
    first, *_ = result.estimates.values()
    force = force_told(
        result.drive,
        result.document.drive_remark or "",
        is_gain=not result.document.drive_force,
        measured="force" in result.record.provenance.columns,
    )
    samplings = [member.sampling for member in result.of_records] or [result.sampling]
    records = [member.record for member in result.of_records] or [result.record]
    return rows_text(
        samplings,
        first.document.rows,
        force,
        [record.motion or ("position",) for record in records],
    )


def _heading(result: SavedIdentification) -> Heading:
    """Return the heading: axis, records, an estimated drive time and true values."""
    record, parameters = result.record, result.declared_parameters
    axis = result.name
    if result.declared and result.declared.title:
        axis = f"{result.name}: {result.declared.title}"
    records = [member.record for member in result.of_records] or [record]
    units = {p.name: p.unit for p in parameters}
    # Only true values that all records have in common are shown.
    truth = record.provenance.truth
    for member in result.of_records:
        own = member.record.provenance.truth
        truth = {name: value for name, value in truth.items() if own.get(name) == value}
    number = drive = ""
    if len(records) > 1:
        number = f"{len(records)}, one set of parameters"
    found = result.drive_time
    if found:
        interval = range_text(1e3 * found.interval[0], 1e3 * found.interval[1], " to ")
        drive = (
            f"{found}, estimated, 95 % interval {interval} ms; the standard errors of the "
            "parameters include its uncertainty"
        )
    return Heading(
        facts={
            "axis": axis,
            "left out": result.left_out,
            "records": number,
            **records_facts(records, [member.known for member in result.of_records], units),
            **set_aside_facts(result.set_aside),
            "drive": drive,
            "truth": _truth(parameters, truth),
            "": _truth([] if result.of_records else result.combined, truth),
        }
    )


def _truth(parameters: Iterable[Parameter], truth: Mapping[str, float]) -> str:
    """Return the true values of parameters as text; empty without any."""
    return ", ".join(
        f"{p.name} = {truth[p.name]:g} {p.unit}" for p in parameters if p.name in truth
    )


def _estimates_table(
    estimates: Sequence[SavedEstimate],
    bands: Mapping[str, Mapping[str, JackknifeInterval]],
    truth: Mapping[str, float],
) -> TableBlock:
    """Return the table of the estimates of one model form (inverse or direct) side by side.

    Parameters
    ----------
    estimates : sequence of SavedEstimate
    bands : mapping of str to mapping of str to JackknifeInterval
        Intervals with the model error, by method and parameter.
    truth : mapping of str to float
        True values of a simulated record.
    """
    first, methods = estimates[0], [e.method for e in estimates]
    rows = _value_rows(
        {e.method: e.parameters for e in estimates},
        _labels(first.quantities),
        truth,
        [bands.get(method, {}) for method in methods],
    )
    rows += [
        *_value_rows(
            {e.method: e.ddm_parameters for e in estimates}, _labels(first.ddm_quantities), truth
        ),
        (
            *("equation error", "%"),
            *(or_dash(equation_error(e), ".4f") for e in estimates),
            "",
        ),
        (
            *("simulation error", "%"),
            *(or_dash(e.simulation_error_percent, ".4f") for e in estimates),
            "",
        ),
        ("rows", "", *(str(e.document.rows) for e in estimates), ""),
        ("condition number", "", *(f"{e.condition_number:.3f}" for e in estimates), ""),
        ("iterations (start)", "", *map(iterations, estimates), ""),
    ]
    return TableBlock(columns=_columns("", methods), rows=tuple(rows), labels=2)


def _physical_tables(result: SavedIdentification) -> list[TableBlock]:
    """Return a table of declared parameters that are calculated from base parameters.

    It shows the estimates by the inverse model if there are any, otherwise those by the direct
    model. The list is empty if no parameter has to be calculated.
    """
    by_method = {method: p for method, p in result.physical.items() if p.shows_more}
    inverse = [p for method, p in by_method.items() if not result.estimates[method].is_direct]
    shown = inverse or [*by_method.values()]
    if not shown:
        return []
    values = {physical.method: physical.parameters for physical in shown}
    rows = _value_rows(
        values, {name: name for name in shown[0].parameters}, result.record.provenance.truth
    )
    return [TableBlock(columns=_columns("physical parameters", values), rows=tuple(rows), labels=2)]


def _columns(head: str, methods: Iterable[str]) -> tuple[TableColumn, ...]:
    """Return the columns of a table of estimates by method, with drawn intervals at the end.

    `head` is the head of the first column, with the names of the parameters.
    """
    # The numbers refer to the notes of `_notes_of_columns`.
    parts = ("sd [1]", "rel. sd", "i.i.d. [2]")
    return (
        *text_columns([head, "unit"]),
        *(TableColumn(method.upper(), parts=parts, kind="method") for method in methods),
        TableColumn("intervals", align="left", kind="intervals"),
    )


def _labels(quantities: Iterable[Quantity]) -> dict[str, str]:
    """Return the label of each quantity by name: its name, and its formula if it has one."""
    return {q.name: f"{q.name} = {q.expression}" if q.expression else q.name for q in quantities}


def _value_rows(
    columns: Mapping[str, Mapping[str, Value]],
    labels: Mapping[str, str],
    truth: Mapping[str, float],
    bands: Sequence[Mapping[str, JackknifeInterval]] = (),
) -> list[tuple[Cell, ...]]:
    """Return table rows of parameters by method, with the intervals to be drawn.

    Parameters
    ----------
    columns : mapping of str to mapping of str to Value
        Values by method and parameter.
    labels : mapping of str to str
        Label of the row of each parameter.
    truth : mapping of str to float
        True values of a simulated record.
    bands : sequence of mapping of str to JackknifeInterval
        Intervals with the model error, by parameter, for each method; empty for no such rows.
    """
    rows: list[tuple[Cell, ...]] = []
    for name, label in labels.items():
        values = [column[name] for column in columns.values()]
        # The colour of an interval is that of the kind of estimator, which is the last part of the
        # name of its method: iv for idm-iv and ddm-iv, didim for didim.
        drawn = tuple(
            Interval(v.interval[0], v.corrected, v.interval[1], method.rsplit("-", 1)[-1])
            for method, v in zip(columns, values, strict=True)
        )
        rows.append(
            (label, values[0].unit, *map(quantity, values), Intervals(drawn, truth.get(name)))
        )
        # If the interval is not centred at the value, its centre has a row of its own.
        if any(v.is_shifted for v in values):
            texts = (
                "-" if v.filter_bias is None else f"{v.corrected:.{places(v)}f}" for v in values
            )
            rows.append((f"  {CORRECTED}", "", *texts, ""))
        if bands:
            rows += band_row(values, [column.get(name) for column in bands])
    return rows


def draws_table(estimates: Mapping[str, SavedEstimate], draws: int) -> TableBlock:
    """Return a table of intervals from random draws, next to those by the delta method.

    `draws` is the number of draws from the distribution of each estimate.
    """
    drawn = [
        (f"{method.upper()} {name}", value, estimate.propagate(name, draws=draws))
        for method, estimate in estimates.items()
        for name, value in estimate.parameters.items()
    ]
    lost, seed = max(summary.lost for *_, summary in drawn), drawn[-1][-1].seed
    excluded = f"; up to {lost} draws without a positive inertia are excluded" if lost else ""
    return text_table(
        ("", "unit", "median", "drawn 2.5 %", "97.5 %", "delta 2.5 %", "97.5 %"),
        (
            (
                label,
                value.unit,
                *(
                    f"{x:.{decimals(value.deviation)}f}"
                    for x in (summary.median, *summary.interval, *value.interval)
                ),
            )
            for label, value, summary in drawn
        ),
        labels=2,
        said=(
            f"{draws} draws from each estimate's distribution (seed {seed}), transformed exactly"
            f"{excluded}.",
        ),
    )


def _notes_of_columns(estimates: Sequence[SavedEstimate]) -> list[str]:
    """Return the notes [1] and [2] that the columns of `_columns` refer to."""
    chosen = estimates[0].chosen
    text = shared_covariance_text({e.method: e.covariance_notes[chosen] for e in estimates})
    published = iid_text(estimates[0].covariance_notes["iid"])
    return [f"sd and 95 % intervals: {text}.", f"i.i.d. sd: {published}."]


def _notes(estimates: Sequence[SavedEstimate]) -> list[str]:
    """Return the further notes on a table of estimates: gain, bias, errors and methods."""
    last, notes = estimates[-1], list[str]()
    if last.gain_relative_sd:
        by_gain = ", ".join(f"{n} +- {v.sd_gain:.3g} {v.unit}" for n, v in last.parameters.items())
        notes.append(
            f"The drive gain is known to {100 * last.gain_relative_sd:.3g} %. Its error scales all "
            f"parameters together and is not part of any sd: {by_gain} ({last.method.upper()})."
        )
    if any(v.is_shifted for e in estimates for v in e.parameters.values()):
        notes.append(
            f"{CORRECTED}: the value above minus the bias of filter and noise, which the replicas "
            "of note [1] show. The corrected value is the centre of the 95 % interval, and "
            "physical parameters are calculated from it."
        )
    if any(estimate.is_direct for estimate in estimates):
        notes.append("sd of physical parameters from a direct model: delta method.")
    notes.append(
        "y is the force (IDM) or the acceleration (DDM). The equation error is "
        "||y - X theta||/||y||; it does not measure the quality of an IV estimate on noisy data. "
        "The simulation error is ||y - y_simulated||/||y|| for the closed loop simulated with the "
        "estimate."
    )
    if any(estimate.iterates for estimate in estimates):
        notes.append(
            "Iterations: number of iterations, with their start in parentheses (LS: least squares, "
            "nominal: the nominal values)."
        )
    if any(estimate.by_output_error for estimate in estimates):
        notes.append(
            "DIDIM: least squares of the measured force on the regressor of the simulated closed "
            "loop, both with the same filter. Its equation error equals its simulation error and "
            "is printed once. It relies on the declared control law."
        )
    if {"idm-iv", "ddm-iv"} <= {e.method for e in estimates}:
        notes.append(
            "IDM-IV and DDM-IV solve the same equations with the same instruments. Their agreement "
            "is a self-test, not an independent check."
        )
    return notes


def shared_remarks(estimates: Iterable[SavedEstimate]) -> list[str]:
    """Return each remark on estimates once, after the names of the methods it applies to."""
    methods = grouped((remark, e.method) for e in estimates for remark in e.remarks)
    return [
        f"{', '.join(names).upper()}: {remark.removesuffix('.')}."
        for remark, names in methods.items()
    ]


def verdict_block(checks: Sequence[Check]) -> Checks:
    """Return the verdict: conclusion, checks that did not pass with sentences, passed checks.

    A line of the verdict has one or more checks. It passes if none of its checks is in another
    group.
    """
    # Failed checks come first, then notes, each by weight.
    ordered = by_weight(checks)
    statuses: tuple[Status, ...] = ("fail", "note")
    groups = [
        CheckGroup(status, (check.line,), check.meaning)
        for status in statuses
        for check in ordered
        if check.status == status
    ]
    # Checks that were not evaluated for the same reason share a group.
    groups += [
        CheckGroup("not evaluated", lines_of(names), why) for why, names in unmade(checks).items()
    ]
    # The remaining lines of these checks passed; they are in the order of `KINDS`.
    with_group = {line for group in groups for line in group.names}
    own = lines_of(check.name for check in checks)
    passed = tuple(
        line for line in lines_of((*KINDS, *own)) if line in own and line not in with_group
    )
    if passed:
        groups.append(CheckGroup("pass", passed))
    return Checks(judged=tuple(groups), conclusion=conclusion_text(conclusion(checks)))


def unmade(checks: Sequence[Check]) -> dict[str, list[str]]:
    """Return the names of checks that were not evaluated, by reason.

    Checks of a line of the verdict with a failed check or a note are excluded, because a line has
    one status.
    """
    judged = lines_of(check.name for check in checks if check.status in ("fail", "note"))
    return grouped(
        (each.meaning, each.name)
        for each in checks
        if each.status == "not evaluated" and each.line not in judged
    )


def missing_notes(missing: Mapping[str, str], checks: Sequence[Check] = ()) -> list[str]:
    """Return a note for each reason why methods have no estimate, with their names.

    A reason for which checks were not evaluated is not repeated, because it is in the verdict.
    """
    in_verdict = unmade(checks)
    methods = grouped(
        ("see the verdict" if why in in_verdict else why.removeprefix(f"{method}, "), method)
        for method, why in missing.items()
    )
    return [
        f"{', '.join(names).upper()} could not be estimated: {reason.removesuffix('.')}."
        for reason, names in methods.items()
    ]
