"""Everything that was measured of a result: what ``--full`` adds to the tables."""

from collections.abc import Iterable, Mapping, Sequence

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Alignment, ColumnComparison, Diagnosis, InstrumentTests
from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.estimates import COVARIANCES, Value
from axisid.presentation.blocks import (
    Column,
    Document,
    Paragraph,
    Table,
    paragraph,
    text_columns,
)
from axisid.presentation.formulas import figure_text
from axisid.presentation.saved import SavedEstimate
from axisid.support.missing import Missing
from axisid.support.number_text import or_dash


def details_document(estimates: Mapping[str, SavedEstimate], diagnosis: Diagnosis) -> Document:
    """Intervals, correlations and every diagnostic, each with its figure and threshold."""
    preferred = estimates[diagnosis.preferred]
    label = COVARIANCES[preferred.chosen].label
    return (
        _intervals(f"95 % intervals, {label}, less the bias of filter and noise", estimates),
        _correlation(f"Correlation, {preferred.method.upper()}, {label}", preferred),
        _excitation(diagnosis),
        *((_by_record(diagnosis),) if diagnosis.records else (_law(diagnosis.law),)),
        _instruments(preferred, diagnosis.instruments),
        _differences(diagnosis, {q.name: q.unit for q in preferred.quantities}),
        _alignment(preferred, diagnosis.alignment),
        *_motions(diagnosis.motions),
        checks_table(diagnosis.verdict),
    )


def _table(
    title: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    labels: int = 1,
    said: tuple[str, ...] = (),
) -> Table:
    texts = tuple(tuple(row) for row in rows)
    return Table(columns=text_columns(heads), rows=texts, labels=labels, title=title, said=said)


def _intervals(title: str, estimates: Mapping[str, SavedEstimate]) -> Table:
    labels = [model.label for model in COVARIANCES.values()]
    labels[0] = f"sd {labels[0]}"
    header = ["", "unit", "2.5 %", "97.5 %", *labels, "gain", "bias"]
    rows = (
        [f"{method.upper()} {name}", value.unit, *_figures(value)]
        for method, estimate in estimates.items()
        for name, value in (estimate.parameters | estimate.ddm_parameters).items()
    )
    return _table(title, header, rows, labels=2)


def _figures(value: Value) -> list[str]:
    ends = [f"{end:.6g}" for end in value.interval]
    deviations = (*(value.deviations[name] for name in COVARIANCES), value.sd_gain)
    bias = or_dash(value.filter_bias, "+.2g")
    return [*ends, *(f"{sd:.3g}" for sd in deviations), bias]


def _correlation(title: str, estimate: SavedEstimate) -> Table:
    names = [q.name for q in estimate.quantities]
    rows = (
        [name, *(f"{r:.3f}" for r in row)]
        for name, row in zip(names, estimate.correlation, strict=True)
    )
    return _table(title, ["", *names], rows)


def _excitation(diagnosis: Diagnosis) -> Table:
    rows = (
        [e.name, f"{figure_text(100 * e.share)} %", f"{e.inflation:.3g}", ", ".join(e.alike) or "-"]
        for e in diagnosis.excitation
    )
    heads = ("", "of the force", "variance inflation", "nearly repeats")
    return _table("Excitation", heads, rows)


def _law(law: LawCheck | Missing) -> Table | Paragraph:
    title = "Control law"
    if isinstance(law, Missing):
        why = law.reason
        return paragraph(f"not checked: {why}", title=title, filled=False)
    rows = [
        ["declared law leaves", _percent(law.residual_percent)],
        ["with factors of its own", _percent(law.fitted_residual_percent)],
        ["delay [samples]", str(law.delay)],
        *([f"factor of {name}", f"{factor:.5g}"] for name, factor in law.factors.items()),
    ]
    return _table(title, ["recorded control", ""], rows)


def _by_record(diagnosis: Diagnosis) -> Table:
    """The control law and the delay of the force, record by record."""
    rows = []
    for i, of_one in enumerate(diagnosis.records, 1):
        law, alignment = of_one.law, of_one.alignment
        text = (
            ("-", "-")
            if isinstance(law, Missing)
            else (_percent(law.residual_percent), str(law.delay))
        )
        best = (
            "-"
            if isinstance(alignment, Missing)
            else (f"{alignment.best:.3f} +- {alignment.deviation:.2g}")
        )
        rows.append([f"record {i}", *text, best])
    heads = ("", "declared law leaves", "delay [samples]", "force fits best earlier by [samples]")
    return _table("By record", heads, rows)


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{figure_text(value)} %"


def _instruments(preferred: SavedEstimate, tests: InstrumentTests | None) -> Table | Paragraph:
    title = "Instruments"
    if tests is None:
        return paragraph("none", title=title)
    names = [q.label for q in preferred.form.quantities]
    rows = (
        [name, f"{s.r_squared:.5f}", f"{s.shea:.5f}", f"{s.f:.4g}", f"{s.conditional_f:.4g}"]
        for name, s in zip(names, tests.columns, strict=True)
    )
    said = f"condition number of Z'X, unit columns: {tests.condition_number:.4g}"
    heads = ("first stage", "R^2", "Shea", "F", "conditional F")
    return _table(title, heads, rows, said=(said,))


def _differences(diagnosis: Diagnosis, units: Mapping[str, str]) -> Table | Paragraph:
    title = "Estimates less another, Hausman, HAC"
    if not diagnosis.differences:
        return paragraph(
            "not tested: no two are of the same rows, or instruments are weak", title=title
        )
    heads = ("", "unit", "difference", "sd of it", "in sd of the other", "p", "p of all")
    rows = (
        (
            f"{pair} {name}",
            units[name],
            f"{each.difference:+.3g}",
            f"{each.deviation:.2g}",
            f"{each.shift:.2g}",
            f"{each.p_value:.2g}",
            f"{each.joint_p_value:.2g}",
        )
        for pair, of_one in diagnosis.differences.items()
        for name, each in of_one.items()
    )
    return _table(title, heads, rows, labels=2)


def _alignment(preferred: SavedEstimate, alignment: Alignment | Missing) -> Paragraph:
    title = "Alignment"
    if isinstance(alignment, Missing):
        why = alignment.reason
        return paragraph(f"not measured: {why}", title=title, filled=False)
    by = "instruments" if alignment.by_instruments else "least squares"
    units = {q.name: q.unit for q in preferred.quantities}
    units |= dict(zip(alignment.names, alignment.units, strict=True))
    moved = ", ".join(
        f"{name} {slope:+.3g} {units.get(name, '')}".rstrip()
        for name, slope in zip(alignment.names, alignment.sensitivity, strict=True)
    )
    end = " (the end of the range)" if alignment.at_the_end else ""
    return paragraph(
        f"the force fits best {alignment.best:.3f} +- {alignment.deviation:.2g} samples earlier"
        f"{end}, by {by}; a sample of delay moves {moved}",
        title=title,
    )


def _motions(found: Mapping[str, ColumnComparison | Missing]) -> Document:
    """Measured velocity and acceleration beside what is differentiated; none without them."""
    rows = [
        (
            role,
            f"{m.factor:.5g} +- {m.factor_deviation:.1g}",
            f"{m.delay:.3f} +- {m.delay_deviation:.1g}",
            f"{m.offset:+.3g} +- {m.offset_deviation:.1g}",
            f"{m.left_percent:.3g}",
        )
        for role, m in found.items()
        if not isinstance(m, Missing)
    ]
    if not rows:
        return ()
    heads = ["", "factor", "samples late", "constant, SI", "left, %"]
    return (_table("Measured motion beside what is differentiated", heads, rows),)


def checks_table(checks: Sequence[Check], *, sources: bool = False) -> Table:
    """Every check with its figure and threshold, and on request of what, and whose threshold."""
    rows = (
        (
            *(
                c.name,
                c.status,
                or_dash(c.figure, ".3g"),
                or_dash(c.threshold, ".3g"),
                or_dash(c.p_value, ".3g"),
            ),
            *((c.source,) if sources else ()),
        )
        for c in checks
    )
    columns = text_columns(["", "status", "figure", "threshold", "p"])
    columns += (Column("of what, and whose threshold", align="left"),) if sources else ()
    return Table(columns=columns, rows=tuple(rows), title="Checks")
