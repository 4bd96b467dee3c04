"""An identification as a document: heading, tables, verdict and numbered notes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.estimates import CORRECTED, COVARIANCES, Value
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
)
from axisid.presentation.result_files import SavedEstimate, SavedIdentification
from axisid.presentation.sentences import (
    conclusion_text,
    covariance_in_short,
    covariance_text,
    shared_covariance_text,
)
from axisid.support.checks import is_nothing
from axisid.support.mappings import grouped
from axisid.support.settings import all_methods
from axisid.support.wording import or_dash, range_text

from .identification_details import (
    band_row,
    details_document,
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

    By default it has what fits on a screen: the judged estimate, the verdict and the rows.

    Parameters
    ----------
    result : SavedIdentification
    draws : int
        Number of draws from the distribution of each estimate; 0 for no table of draws.
    every : bool
        Whether to show all methods with notes.
    full : bool
        Whether to show all methods, notes, diagnostics and checks.
    """
    drawn = () if is_nothing(draws) else (draws_table(result.estimates, draws),)
    if not (every or full):
        return (*_screen(result), *drawn)
    estimates, document = [*result.estimates.values()], result.document
    notes = [
        *_notes(estimates),
        *shared_remarks(estimates),
        *physical_notes(result.physical),
        *([f"Checks apply to the {document.judged.upper()} estimate."] * (len(estimates) > 1)),
        *moves_notes(document),
        *several_notes(result),
        f"{rows_of(result)}{signals_text(result.signals)} Generated code {result.signature[:12]}.",
        *missing_notes({**result.skipped, **result.failed}, result.verdict),
    ]
    return (
        _heading(result),
        *(
            _estimates_table(beside, document.model_bands or {}, result.record.provenance.truth)
            # Two of a form are as wide as a terminal; those of the inverse model first.
            for form in ([e for e in estimates if e.is_direct == way] for way in (False, True))
            for beside in (form[i : i + 2] for i in range(0, len(form), 2))
        ),
        *_physical_tables(result),
        *((records_table(result),) if result.of_records else ()),
        verdict_block(result.verdict),
        Notes(tuple(notes)),
        *drawn,
        *(details_document(result) if full else ()),
    )


def _screen(result: SavedIdentification) -> Document:
    """Return heading, judged estimate, failed checks and rows: what fits on a screen.

    If a check fails, methods without an estimate are named without reasons, because the failed
    check explains them.
    """
    noted = [check.line for check in by_weight(result.verdict) if check.status == "note"]
    missing = {**result.skipped, **result.failed}
    fails = any(check.status == "fail" for check in result.verdict)
    without = (
        [f"Not estimated: {', '.join(missing).upper()}."] * bool(missing)
        if fails
        else missing_notes(missing, result.verdict)
    )
    verdict = verdict_block(result.verdict)
    more = "For all methods"
    if noted:
        more += f" and the notes on {', '.join(dict.fromkeys(noted))}"
    return (
        _heading(result),
        judged_table(result),
        *((records_table(result),) if result.of_records else ()),
        replace(verdict, judged=tuple(e for e in verdict.judged if e.status != "note")),
        Paragraph(
            sentences=(
                *(Sentence(text=each) for each in shared_remarks([result.preferred])),
                *(Sentence(text=each) for each in without),
                Sentence(text=f"{_rows_in_short(result)} {more}: {all_methods()}."),
            )
        ),
    )


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

    The estimate by IDM-LS is in a further column if a value of it lies outside the interval.
    """
    judged, plain = result.preferred, result.estimates.get("idm-ls")
    bands = (result.document.model_bands or {}).get(judged.method, {})
    revised = result.document.with_missing_terms or {}
    physical = result.physical.get(judged.method)
    beside = {} if plain is None or plain is judged else plain.parameters
    more = physical.parameters if physical and physical.shows_more else {}
    values = {**judged.parameters, **more}
    # Omit IDM-LS if all its values are within the intervals of the judged estimate.
    if all(low <= beside[n].value <= high for n in beside for low, high in [values[n].interval]):
        beside = {}
    rows = (
        (
            name,
            value.unit,
            f"{value.corrected:.{digits}f}",
            f"{value.deviation:.{digits}f}" if value.deviation else "-",
            " to ".join(f"{end:.{digits}f}" for end in value.interval) if value.deviation else "-",
            *([f"{beside[name].value:.{digits}f}" if name in beside else ""] * bool(beside)),
            ", ".join(
                [
                    *([f"declared {result.declared_gain:g}"] if name == GAIN else []),
                    *(
                        f"known {known_text(p.known, p.known_sd)}" if value.deviation else "fixed"
                        for p in (physical.known if physical else ())
                        if p.name == name
                    ),
                    *([f"{value.value:.{digits}f} with bias"] * value.is_shifted),
                    *_model_remark(bands.get(name), revised.get(name, ()), digits),
                ]
            ),
        )
        for name, value in values.items()
        for digits in [decimals(value.deviation)]
    )
    heads = [judged.method.upper(), "sd", "95 % interval", *(["IDM-LS"] if beside else [])]
    return TableBlock(
        columns=(*text_columns(["", "unit", *heads]), TableColumn("remark", align="left")),
        rows=tuple(rows),
        labels=2,
    )


def _model_remark(
    band: JackknifeInterval | None, revised: Sequence[float], digits: int
) -> list[str]:
    """Return a remark on one parameter under model error, in a list; empty without a remark.

    It is the value with the missing terms, or the interval with the model error.

    Parameters
    ----------
    band : JackknifeInterval or None
        Interval with the model error; None if there is none.
    revised : sequence of float
        Value with the terms that the verdict names, or values forward and backward; empty if no
        terms are named.
    digits : int
        Number of decimal places.
    """
    values = [f"{value:.{digits}f}" for value in revised]
    if len(values) == 2:
        return [f"{values[0]} forward, {values[1]} backward"]
    if band is None or not band.exceeds:
        return []
    if values:
        return [f"{values[0]} with missing terms"]
    return [f"model error: {range_text(*band.interval, ' to ')}"]


def rows_of(result: SavedIdentification) -> str:
    """Return a note on how the records became rows."""
    first, *_ = result.estimates.values()
    force = force_told(
        result.drive,
        result.document.drive_remark or "",
        is_gain=not result.document.drive_force,
        measured="force" in result.record.provenance.columns,
    )
    samplings = [of_one.sampling for of_one in result.of_records] or [result.sampling]
    records = [of_one.record for of_one in result.of_records] or [result.record]
    return rows_text(
        samplings,
        first.document.rows,
        force,
        [record.motion or ("position",) for record in records],
    )


def _heading(result: SavedIdentification) -> Heading:
    """Return the heading: axis, records, an estimated drive time and true values."""
    record, parameters, combined = result.record, result.declared_parameters, result.combined
    truth, title = record.provenance.truth, result.declared.title if result.declared else ""
    records = [of_one.record for of_one in result.of_records] or [record]
    units, found = {p.name: p.unit for p in parameters}, result.drive_time
    for of_one in result.of_records:  # true values common to all records
        own = of_one.record.provenance.truth
        truth = {name: value for name, value in truth.items() if own.get(name) == value}
    return Heading(
        facts={
            "axis": result.name + (f": {title}" if title else ""),
            "left out": result.left_out,
            "records": f"{len(records)}, one set of parameters" * (len(records) > 1),
            **records_facts(records, [of_one.known for of_one in result.of_records], units),
            **set_aside_facts(result.set_aside),
            "drive": f"{found}, estimated, 95 % interval "
            f"{range_text(1e3 * found.interval[0], 1e3 * found.interval[1], ' to ')} ms; its "
            "uncertainty is included in the standard errors of the parameters"
            if found
            else "",
            "truth": _truth(parameters, truth),
            "": _truth([] if result.of_records else combined, truth),
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
    """Return the table of the estimates of one model form side by side.

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
        # DIDIM regresses on the simulated motion: its equation error is its simulation error.
        (
            *("equation error", "%"),
            *(
                or_dash(None if e.by_output_error else e.equation_error_percent, ".4f")
                for e in estimates
            ),
            "",
        ),
        (
            *("simulation error", "%"),
            *(or_dash(e.simulation_error_percent, ".4f") for e in estimates),
            "",
        ),
        ("rows", "", *(str(e.document.rows) for e in estimates), ""),
        ("condition number", "", *(f"{e.condition_number:.3f}" for e in estimates), ""),
        ("iterations", "", *map(iterations, estimates), ""),
    ]
    return TableBlock(columns=_columns("", methods), rows=tuple(rows), labels=2)


def _physical_tables(result: SavedIdentification) -> list[TableBlock]:
    """Return a table of declared parameters that are calculated from base parameters.

    It shows the inverse models if there are any, otherwise the direct ones; empty if no parameter
    has to be calculated.
    """
    every = {method: p for method, p in result.physical.items() if p.shows_more}
    inverse = [p for m, p in every.items() if not result.estimates[m].is_direct]
    shown = inverse or [*every.values()]
    if not shown:
        return []
    values = {physical.method: physical.parameters for physical in shown}
    rows = _value_rows(
        values, {name: name for name in shown[0].parameters}, result.record.provenance.truth
    )
    return [TableBlock(columns=_columns("physical parameters", values), rows=tuple(rows), labels=2)]


def _columns(what: str, methods: Iterable[str]) -> tuple[TableColumn, ...]:
    """Return the columns of a table of estimates by method, with drawn intervals at the end."""
    parts = ("sd [1]", "rel. sd", "i.i.d. [2]")  # shown if the table has room
    return (
        *text_columns([what, "unit"]),
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
        beside = [column[name] for column in columns.values()]
        drawn = tuple(
            Interval(v.interval[0], v.corrected, v.interval[1], method.rsplit("-", 1)[-1])
            for method, v in zip(columns, beside, strict=True)
        )
        rows.append(
            (label, beside[0].unit, *map(quantity, beside), Intervals(drawn, truth.get(name)))
        )
        if any(v.is_shifted for v in beside):  # the interval's centre is not the value above it
            texts = (
                "-" if v.filter_bias is None else f"{v.corrected:.{places(v)}f}" for v in beside
            )
            rows.append((f"  {CORRECTED}", "", *texts, ""))
        if bands:
            rows += band_row(beside, [column.get(name) for column in bands])
    return rows


def draws_table(estimates: Mapping[str, SavedEstimate], draws: int) -> TableBlock:
    """Return a table of intervals from `draws` random draws, next to those by the delta method."""
    drawn = [
        (f"{method.upper()} {name}", value, estimate.propagate(name, draws=draws))
        for method, estimate in estimates.items()
        for name, value in estimate.parameters.items()
    ]
    lost, seed = max(summary.lost for *_, summary in drawn), drawn[-1][-1].seed
    left_out = f"; up to {lost} without a positive inertia are excluded" * bool(lost)
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
            f"{left_out}.",
        ),
    )


def _notes(estimates: Sequence[SavedEstimate]) -> list[str]:
    """Return the notes of a table of estimates."""
    chosen, last = estimates[0].chosen, estimates[-1]
    name = shared_covariance_text({e.method: e.covariance_notes[chosen] for e in estimates})
    published = covariance_text(estimates[0].covariance_notes["iid"])
    allowed = "" if COVARIANCES[chosen].allows_autocorrelation else ", which HAC allows for"
    notes = [
        f"sd and 95 % intervals: {name}. Residuals of filtered data are autocorrelated{allowed}.",
        f"i.i.d. sd, as in the published tables: {published}.",
    ]
    if last.gain_relative_sd:
        by_gain = ", ".join(f"{n} +- {v.sd_gain:.3g} {v.unit}" for n, v in last.parameters.items())
        notes.append(
            f"The drive gain is known to {100 * last.gain_relative_sd:.3g} %. Its error scales all "
            f"parameters together and is not part of any sd: {by_gain} ({last.method.upper()})."
        )
    if any(v.is_shifted for e in estimates for v in e.parameters.values()):
        notes.append(
            f"{CORRECTED}: the value above minus the bias of filter and noise, which the replicas "
            "of [1] show. It is the centre of the 95 % interval, and physical parameters are "
            "calculated from it."
        )
    if any(estimate.is_direct for estimate in estimates):
        notes.append("sd of physical parameters from a direct model: delta method.")
    notes.append(
        "y is the force (IDM) or the acceleration (DDM). Equation error ||y - X theta||/||y||: it "
        "does not measure the quality of an IV estimate on noisy data. Simulation error "
        "||y - y_simulated||/||y||: of the closed loop simulated with the estimate."
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
    shared = grouped((said, e.method) for e in estimates for said in e.remarks)
    return [
        f"{', '.join(of).upper()}: {remark.removesuffix('.')}." for remark, of in shared.items()
    ]


def verdict_block(checks: Sequence[Check]) -> Checks:
    """Return the verdict: conclusion, checks that did not pass with sentences, passed checks."""
    ordered = by_weight(checks)
    statuses: tuple[Status, ...] = ("fail", "note")
    judged = [
        *(
            CheckGroup(status, (check.line,), check.meaning)
            for status in statuses
            for check in ordered
            if check.status == status
        ),
        *(
            CheckGroup("not evaluated", lines_of(names), why)
            for why, names in unmade(checks).items()
        ),
    ]
    told = {line for group in judged for line in group.names}
    own = lines_of(check.name for check in checks)
    passed = tuple(line for line in lines_of((*KINDS, *own)) if line in own and line not in told)
    judged += [CheckGroup("pass", passed)] if passed else []
    return Checks(judged=tuple(judged), conclusion=conclusion_text(conclusion(checks)))


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
    shared = grouped(
        ("see the verdict" if why in in_verdict else why.removeprefix(f"{method}, "), method)
        for method, why in missing.items()
    )
    return [
        f"{', '.join(of).upper()} not estimated: {reason.removesuffix('.')}."
        for reason, of in shared.items()
    ]
