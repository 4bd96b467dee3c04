"""A single estimate as a document, notes on model error, and all diagnostics of a result."""

from collections.abc import Mapping, Sequence

from axisid.estimation.diagnostics import ColumnComparison, HausmanTest, InstrumentTests
from axisid.estimation.estimates import COVARIANCES, Physical, Value
from axisid.estimation.misspecification import JackknifeInterval, LackOfFit
from axisid.estimation.verdict_checks import Check
from axisid.modeling.declaration import known_text
from axisid.presentation.documents import (
    Cell,
    Document,
    Paragraph,
    QuantityCell,
    TableBlock,
    TableColumn,
    decimals,
    figure_text,
    paragraph,
    text_columns,
    text_table,
)
from axisid.presentation.result_files import (
    SavedEstimate,
    SavedIdentification,
    WrittenAlignment,
    WrittenIdentification,
    WrittenLawCheck,
    WrittenMember,
    read_checks,
)
from axisid.support.mappings import grouped
from axisid.support.wording import or_dash, range_text

#: Smallest and largest relative standard error that is printed as a number, percent.
_SMALL, _VAGUE = 0.01, 1e4

#: Names of the start of an iteration.
_STARTS = {"least-squares": "LS", "nominal": "nominal"}
_MODEL_ERROR = "sd by model error"


def saved_estimate_document(estimate: SavedEstimate) -> Document:
    """Return a table of an estimate: parameters with standard errors and intervals, and errors."""
    values = {**estimate.ddm_parameters, **estimate.parameters}
    errors = {
        "equation error": equation_error(estimate),
        "simulation error": estimate.simulation_error_percent,
    }
    return (
        TableBlock(
            columns=(
                *text_columns(["", "unit"]),
                TableColumn("value", parts=("sd", "rel. sd", "i.i.d.")),
                TableColumn("95 % interval"),
            ),
            rows=(
                *(
                    (name, v.unit, quantity(v), range_text(*v.interval, " … ", digits=6))
                    for name, v in values.items()
                ),
                *((name, "%", or_dash(error, ".4g"), "") for name, error in errors.items()),
            ),
            labels=2,
            title=f"{estimate.method.upper()}; sd: {estimate.covariance_names[estimate.chosen]}",
        ),
    )


def equation_error(estimate: SavedEstimate) -> float | None:
    """Return the equation error in percent; None for DIDIM.

    DIDIM regresses on the simulated motion, so its equation error is its simulation error.
    """
    return None if estimate.by_output_error else estimate.equation_error_percent


def iterations(estimate: SavedEstimate) -> str:
    """Return the number of iterations and the start: ``3 (LS)``; a dash for least squares."""
    if not estimate.iterates:
        return "-"
    count = str(len(estimate.iterates) - 1)
    return f"{count} ({_STARTS[estimate.started]})" if estimate.started else count


def quantity(value: Value) -> QuantityCell:
    """Return a value with its standard errors as a table cell.

    All have the same number of decimal places. The further texts of the cell are the relative and
    the i.i.d. standard error.
    """
    digits = places(value)
    relative = value.relative_deviation_percent
    if not relative < _VAGUE:  # also if it is not a number
        percent = f">{_VAGUE - 1:.0f} %"
    elif relative >= _SMALL:
        percent = f"{relative:.2f} %"
    else:
        percent = f"{relative:.1g} %"
    return QuantityCell(
        f"{value.value:.{digits}f}",
        f"{value.deviation:.{digits}f}",
        (percent, f"{value.sd:.{digits}f}"),
    )


def places(value: Value) -> int:
    """Return the number of decimal places that shows four digits of the i.i.d. standard error.

    It is at least four.
    """
    return decimals(value.sd, digits=4, least=4)


def band_row(
    values: Sequence[Value], bands: Sequence[JackknifeInterval | None]
) -> list[tuple[Cell, ...]]:
    """Return a table row of the standard errors that contain the model error, in a list.

    The list is empty if none of them is noticeably larger than the standard error by noise alone.

    Parameters
    ----------
    values : sequence of Value
        The parameter by each method.
    bands : sequence of JackknifeInterval or None
        Its interval with the model error by each method; None if there is none.
    """
    if not any(band is not None and band.exceeds for band in bands):
        return []
    cells: list[Cell] = []
    for value, band in zip(values, bands, strict=True):
        if not band:
            cells.append("-")
            continue
        relative = f"{100 * band.deviation / abs(value.value):.2f} %" if value.value else "-"
        cells.append(QuantityCell("", f"{band.deviation:.{places(value)}f}", (relative, "")))
    return [(f"  {_MODEL_ERROR}", "", *cells, "")]


def moves_notes(document: WrittenIdentification) -> list[str]:
    """Return notes on the repeating residual and on intervals with the model error, if any."""
    notes = [_repeats(document.lack_of_fit)] if document.lack_of_fit else []
    bands, judged = document.model_bands or {}, document.judged
    if not any(band.exceeds for by_parameter in bands.values() for band in by_parameter.values()):
        return notes
    listed = "; ".join(
        f"{name} {range_text(*band.interval, ' to ')} ({band.groups} groups by {band.by})"
        for name, band in bands.get(judged, {}).items()
        if band.exceeds
    )
    notes.append(
        f"{_MODEL_ERROR}: standard error of a parameter from its scatter over parts of the motion "
        "(jackknife). It contains the model error, which repeats with the motion. The sd above it "
        "assumes that the residual averages out over time, as noise does."
    )
    if listed:
        notes.append(
            f"95 % intervals of {judged.upper()} that contain the model error: {listed}. They are "
            "wider than the 95 % intervals from the sd, which cover noise only. Use them while the "
            "model leaves part of the force unexplained."
        )
    return notes


def _repeats(found: LackOfFit) -> str:
    """Return a note on the share of the residual that repeats with the reference."""
    every = "" if found.period is None else f" every {found.period:.4g} s"
    return (
        f"The reference repeats{every}. Residuals of up to {found.times} repeats are compared at "
        f"the same phase of the motion ({found.rows} rows). In these rows "
        f"{100 * max(found.share, 0.0):.0f} +- {100 * found.deviation:.1g} % of the power of the "
        "residual repeats with the motion; the rest is noise."
    )


def physical_notes(found: Mapping[str, Physical]) -> list[str]:
    """Return notes on declared parameters that are calculated from base parameters.

    The list is empty if all declared parameters are estimated directly. A note that applies to some
    methods only begins with their names.

    Parameters
    ----------
    found : mapping of str to Physical
        Calculated parameters by method.
    """
    sentences: list[tuple[str, str]] = []  # each with its method
    for method, physical in found.items():
        for text in physical.undetermined:
            fix = " (fix NAME=VALUE+-SD)" if text.endswith(" known") else ""
            sentences.append((f"{text}{fix}", method))
        sentences += [(text, method) for text in physical.remarks]
    notes = []
    if any(physical.shows_more for physical in found.values()):
        notes.append(_calculation(next(iter(found.values()))))
    for text, methods in grouped(sentences).items():
        if len(methods) == len(found):
            notes.append(f"{text}.")
        else:
            notes.append(f"{', '.join(methods).upper()}: {text}.")
    return notes


def _calculation(physical: Physical) -> str:
    """Return a note on the calculation of declared parameters from estimates and known values."""
    known = ", ".join(
        f"{p.name} = {known_text(p.known, p.known_sd)} {p.unit}" for p in physical.known
    )
    to_known = weighting = ""
    if known:
        to_known = f", and to the known values {known}"
        weighting = (
            " If the record identifies a known parameter too, both values are weighted by their "
            "uncertainty, and the other parameters change through their correlation with it."
        )
    return (
        "Physical parameters: minimum distance to the estimates above minus their bias, weighted "
        f"by their covariance{to_known}.{weighting}"
    )


def details_document(result: SavedIdentification) -> Document:
    """Return tables of intervals, correlations and all diagnostics, and last the table of checks.

    Correlations and excitation are those of the judged estimate.
    """
    preferred, found = result.preferred, result.document
    label, names = COVARIANCES[preferred.chosen].label, [q.name for q in preferred.quantities]
    return (
        _intervals(
            f"95 % intervals, {label}, minus the bias of filter and noise", result.estimates
        ),
        text_table(
            ["", *names],
            (
                [name, *(f"{r:.3f}" for r in row)]
                for name, row in zip(names, preferred.correlation, strict=True)
            ),
            title=f"Correlation, {preferred.method.upper()}, {label}",
        ),
        text_table(
            ("", "share of the force", "variance inflation", "nearly collinear with"),
            (
                (
                    *(name, f"{figure_text(100 * e.share)} %", f"{e.inflation:.3g}"),
                    ", ".join(e.alike) or "-",
                )
                for name, e in found.excitation.items()
            ),
            title="Excitation",
            said=(
                "share of the force: rms of the part of the force by this parameter, relative to "
                "the force (rms). The parts partly cancel, so the shares do not sum to 100 %.",
            ),
        ),
        _by_record(found.records) if found.records else _law(found.law_check),
        _instruments(preferred, found.instruments),
        _differences(found.differences or {}, {q.name: q.unit for q in preferred.quantities}),
        _alignment(preferred, found.alignment),
        *_motions(found.measured_motion or {}),
        checks_table(read_checks(found.verdict)),
    )


def _intervals(title: str, estimates: Mapping[str, SavedEstimate]) -> TableBlock:
    """Return a table of the 95 % interval and all standard errors of each parameter and method.

    The last columns have the standard error by the drive gain, and the bias.
    """
    labels = [f"sd {model.label}" for model in COVARIANCES.values()]
    return text_table(
        ["", "unit", "2.5 %", "97.5 %", *labels, "sd gain", "bias"],
        (
            [
                *(f"{method.upper()} {name}", value.unit),
                *(f"{end:.6g}" for end in value.interval),
                *(f"{value.deviations[covariance]:.3g}" for covariance in COVARIANCES),
                *(f"{value.sd_gain:.3g}", or_dash(value.filter_bias, "+.2g")),
            ]
            for method, estimate in estimates.items()
            for name, value in (estimate.parameters | estimate.ddm_parameters).items()
        ),
        labels=2,
        title=title,
        said=(
            "sd HAC, sd robust, sd i.i.d.: standard error from three estimates of the "
            "covariance. robust: consistent for heteroscedasticity only. i.i.d.: for independent "
            "residuals of equal variance.",
            "sd gain: standard error by the uncertainty of the drive gain, which no other sd "
            "contains. bias: of filter and noise.",
        ),
    )


def _law(law: WrittenLawCheck) -> TableBlock | Paragraph:
    """Return a table of the check of the control law, or the reason why it was not evaluated."""
    title = "Control law"
    if law.passed is None:
        return paragraph(law.meaning, title=title)
    rows = [
        ["residual of the declared law (rms, of the control)", _percent(law.residual_percent)],
        [
            "residual with fitted factors (rms, of the control)",
            _percent(law.fitted_residual_percent),
        ],
        ["delay [samples]", str(law.delay)],
        *([f"factor of {name}", f"{factor:.5g}"] for name, factor in (law.factors or {}).items()),
    ]
    return text_table(["comparison with the recorded control", "value"], rows, title=title)


def _by_record(records: Sequence[WrittenMember]) -> TableBlock:
    """Return a table of residual and delay of the law, and of the delay of the force, by record."""
    rows = []
    for i, each in enumerate(records, 1):
        law, alignment = each.law_check, each.alignment
        residual = law_delay = force_delay = "-"
        if law.passed is not None:
            residual, law_delay = _percent(law.residual_percent), str(law.delay)
        if alignment.best is not None:
            force_delay = f"{alignment.best:.3f} +- {alignment.deviation:.2g}"
        rows.append([f"record {i}", residual, law_delay, force_delay])
    return text_table(
        ("", "residual of the law", "delay of the law [samples]", "delay of the force [samples]"),
        rows,
        title="Control law and force by record: rms residual relative to the control, and delays",
    )


def _percent(value: object) -> str:
    """Return a number in percent as text; a dash for any other value, such as None or UNSET."""
    return f"{figure_text(value)} %" if isinstance(value, float) else "-"


def _instruments(preferred: SavedEstimate, tests: InstrumentTests | None) -> TableBlock | Paragraph:
    """Return a table of the first stages of the instruments, by column of the regressor.

    Without instruments it is a paragraph.
    """
    title = "Instruments"
    if tests is None:
        return paragraph("no instruments", title=title)
    regressed = preferred.ddm_quantities or preferred.quantities
    return text_table(
        ("first stage", "R^2", "Shea's partial R^2", "F", "conditional F"),
        (
            [q.label, f"{s.r_squared:.5f}", f"{s.shea:.5f}", f"{s.f:.4g}", f"{s.conditional_f:.4g}"]
            for q, s in zip(regressed, tests.columns, strict=True)
        ),
        title=title,
        said=(
            f"Condition number of Z'X with columns of unit length: {tests.condition_number:.4g}.",
        ),
    )


def _differences(
    differences: Mapping[str, Mapping[str, HausmanTest]], units: Mapping[str, str]
) -> TableBlock | Paragraph:
    """Return a table of the differences between estimators with Hausman tests.

    Parameters
    ----------
    differences : mapping of str to mapping of str to HausmanTest
        Tests by pair of methods and by parameter.
    units : mapping of str to str
        Units of the parameters.
    """
    title = "Differences between estimators (Hausman test, HAC)"
    if not differences:
        return paragraph(
            "not tested: no two estimators use the same rows, or instruments are weak", title=title
        )
    return text_table(
        ("", "unit", "difference", "sd", "in sd of the second method", "p", "joint p"),
        (
            (
                f"{_difference_label(pair)} {name}",
                units[name],
                f"{each.difference:+.3g}",
                f"{each.deviation:.2g}",
                f"{each.shift:.2g}",
                f"{each.p_value:.2g}",
                f"{each.joint_p_value:.2g}",
            )
            for pair, by_parameter in differences.items()
            for name, each in by_parameter.items()
        ),
        labels=2,
        title=title,
    )


def _difference_label(pair: str) -> str:
    """Return the label of a pair: ``idm-iv less didim`` becomes ``IDM-IV minus DIDIM``."""
    return " minus ".join(method.upper() for method in pair.split(" less "))


def _alignment(preferred: SavedEstimate, alignment: WrittenAlignment) -> Paragraph:
    """Return sentences on the delay of the force relative to the motion, and on its effect."""
    title = "Alignment"
    if alignment.best is None:
        return paragraph(f"The delay was not measured: {alignment.reason}", title=title)
    by = "instrumental variables" if alignment.by_instruments else "least squares"
    units = {q.name: q.unit for q in preferred.quantities}
    changes = ", ".join(
        f"{name} by {slope:+.3g} {units.get(name, '')}".rstrip()
        for name, slope in (alignment.sensitivity or {}).items()
    )
    end = " (the end of the search range)" if alignment.at_the_end else ""
    return paragraph(
        f"The force acts {alignment.best:.3f} +- {alignment.deviation:.2g} samples{end} after it "
        f"is recorded, estimated by {by}. A delay of one sample changes {changes}.",
        title=title,
    )


def _motions(found: Mapping[str, ColumnComparison]) -> Document:
    """Return a table of measured velocity and acceleration; empty if they are not measured.

    Each is compared with the differentiated position: its factor, delay, offset and residual.

    Parameters
    ----------
    found : mapping of str to ColumnComparison
        Comparison by role.
    """
    rows = [
        (
            role,
            f"{each.factor:.5g} +- {each.factor_deviation:.1g}",
            f"{each.delay:.3f} +- {each.delay_deviation:.1g}",
            f"{each.offset:+.3g} +- {each.offset_deviation:.1g}",
            f"{each.left_percent:.3g}",
        )
        for role, each in found.items()
    ]
    table = text_table(
        ["", "factor", "delay [samples]", "offset [SI]", "residual [%]"],
        rows,
        title="Measured motion compared with the differentiated position",
    )
    return (table,) if rows else ()


def checks_table(checks: Sequence[Check], *, sources: bool = False) -> TableBlock:
    """Return a table of every check with its status, value and threshold.

    `sources` adds a column with the meaning of the value and the source of the threshold.
    """
    columns = [*text_columns(["", "status", "value", "threshold", "p"])]
    if sources:
        head = "meaning of the value, and source of the threshold"
        columns.append(TableColumn(head, align="left"))
    rows = []
    for check in checks:
        figures = (check.figure, check.threshold, check.p_value)
        row = [check.name, check.status, *(or_dash(figure, ".3g") for figure in figures)]
        if sources:
            row.append(check.source)
        rows.append(tuple(row))
    return TableBlock(columns=tuple(columns), rows=tuple(rows), title="Checks")
