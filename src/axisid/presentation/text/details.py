"""Everything that was measured of a result, as text: what ``--full`` adds to the table."""

from collections.abc import Iterable, Mapping, Sequence

from axisid.estimation.diagnostics import (
    Alignment,
    Check,
    Diagnosis,
    Endogeneity,
    InstrumentTests,
    LawCheck,
)
from axisid.estimation.estimates import COVARIANCE_LABELS, Estimate, Value

from .tables import text_table, wrapped


def details_text(estimates: Mapping[str, Estimate], diagnosis: Diagnosis) -> str:
    """Intervals, correlations and every diagnostic, each with its figure and threshold."""
    judged = estimates[diagnosis.judged]
    label = COVARIANCE_LABELS[judged.chosen]
    blocks = [
        _block(f"95 % intervals, {label}, less the filter's own bias", _intervals(estimates)),
        _block(f"Correlation, {judged.method.upper()}, {label}", _correlation(judged)),
        _block("Excitation", _excitation(diagnosis)),
        _block("Control law", _law(diagnosis.law)),
        _block("Instruments", _instruments(judged, diagnosis.instruments)),
        _block(f"Durbin-Wu-Hausman, regression form, {label}", _endogeneity(judged, diagnosis)),
        _block("Alignment", _alignment(judged, diagnosis.alignment)),
        _block("Checks", _checks(diagnosis.verdict)),
    ]
    return "\n\n".join(blocks) + "\n"


def _block(title: str, text: str) -> str:
    return f"{title}\n{text}"


def _intervals(estimates: Mapping[str, Estimate]) -> str:
    header = ["", "unit", "2.5 %", "97.5 %", "sd HAC", "robust", "i.i.d.", "gain", "filter bias"]
    rows = [
        [f"{method.upper()} {name}", value.unit, *_figures(value)]
        for method, estimate in estimates.items()
        for name, value in (estimate.parameters | estimate.ddm_parameters).items()
    ]
    return text_table(header, rows)


def _figures(value: Value) -> list[str]:
    ends = [f"{end:.6g}" for end in value.interval]
    deviations = (value.sd_hac, value.sd_robust, value.sd, value.sd_gain)
    bias = "-" if value.filter_bias is None else f"{value.filter_bias:+.2g}"
    return [*ends, *(f"{sd:.3g}" for sd in deviations), bias]


def _correlation(estimate: Estimate) -> str:
    names = [q.name for q in estimate.quantities]
    rows = [
        [name, *(f"{r:.3f}" for r in row)]
        for name, row in zip(names, estimate.correlation, strict=True)
    ]
    return text_table(["", *names], rows)


def _excitation(diagnosis: Diagnosis) -> str:
    rows = [
        [e.name, f"{100 * e.share:.3g} %", f"{e.inflation:.3g}", ", ".join(e.alike) or "-"]
        for e in diagnosis.excitation
    ]
    return text_table(["", "of the force", "variance inflation", "nearly repeats"], rows)


def _law(law: LawCheck | str) -> str:
    if isinstance(law, str):
        return f"not checked: {law}"
    rows = [
        ["declared law leaves", _percent(law.residual_percent)],
        ["with factors of its own", _percent(law.fitted_residual_percent)],
        ["delay [samples]", str(law.delay)],
        *([f"factor of {name}", f"{factor:.5g}"] for name, factor in law.factors.items()),
    ]
    return text_table(["recorded control", ""], rows)


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g} %"


def _instruments(judged: Estimate, tests: InstrumentTests | None) -> str:
    if tests is None:
        return "none"
    names = [q.expression or q.name for q in judged.form.quantities]
    rows = [
        [name, f"{s.r_squared:.5f}", f"{s.shea:.5f}", f"{s.f:.4g}", f"{s.conditional_f:.4g}"]
        for name, s in zip(names, tests.columns, strict=True)
    ]
    table = text_table(["first stage", "R^2", "Shea", "F", "conditional F"], rows)
    return f"{table}\ncondition number of Z'X, unit columns: {tests.condition_number:.4g}"


def _endogeneity(judged: Estimate, diagnosis: Diagnosis) -> str:
    tested: Endogeneity | None = diagnosis.endogeneity
    if tested is None:
        return "not tested: it needs idm-iv, with instruments unlike the regressor"
    by = ", ".join(
        f"{q.name} {p:.2g}" if p == p else f"{q.name} -"  # NaN where the column has no residual
        for q, p in zip(judged.quantities, tested.by_parameter, strict=True)
    )
    return f"F = {tested.statistic:.4g}, p = {tested.p_value:.2g}; p by column: {by}"


def _alignment(judged: Estimate, alignment: Alignment | str) -> str:
    if isinstance(alignment, str):
        return f"not measured: {alignment}"
    by = "instruments" if alignment.by_instruments else "least squares"
    moved = ", ".join(
        f"{q.name} {slope:+.3g} {q.unit}"
        for q, slope in zip(judged.quantities, alignment.sensitivity, strict=True)
    )
    end = " (the end of the range)" if alignment.at_the_end else ""
    return wrapped(
        "",
        f"the force fits best {alignment.best:.3f} +- {alignment.deviation:.2g} samples earlier"
        f"{end}, by {by}; a sample of delay moves {moved}",
    )


def _checks(checks: Sequence[Check]) -> str:
    rows: Iterable[list[str]] = (
        [c.name, c.status, *(_number(x) for x in (c.figure, c.threshold, c.p_value))]
        for c in checks
    )
    return text_table(["", "status", "figure", "threshold", "p"], rows)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
