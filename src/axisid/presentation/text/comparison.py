"""A comparison of candidates as a document."""

import math
from collections.abc import Sequence

from axisid.estimation.diagnostics import within_bounds
from axisid.estimation.estimates import NotSimulated, Value
from axisid.estimation.model_selection import Candidate, Comparison
from axisid.estimation.thresholds import SIGNIFICANCE_LEVEL
from axisid.estimation.verdict_checks import Check
from axisid.modeling.declaration import left_out_text
from axisid.presentation.documents import (
    Cell,
    Document,
    Heading,
    Paragraph,
    QuantityCell,
    Sentence,
    TableBlock,
    decimals,
    paragraph,
    text_table,
)
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.wording import or_dash

from .record import force_told, records_facts, rows_text, set_aside_facts

_SMALLEST_P = 1e-16


def comparison_document(c: Comparison) -> Document:
    """Return a comparison as a document.

    It has estimates, errors and tests of the candidates, the recommendation, and the common rows.
    """
    nested = text_table(
        ("nested model", "restrictions", "Wald/q, HAC", "p"),
        (
            (
                f"{t.smaller} in {t.larger}",
                str(t.restrictions),
                or_dash(t.wald, ".4g"),
                _p(t.wald_p),
            )
            for t in c.tests
        ),
    )
    return (
        _heading(c),
        text_table(
            ["estimate +- sd", "unit", *(e.name for e in c.candidates)],
            (
                (name, unit, *(_short(e.estimate.parameters.get(name)) for e in c.candidates))
                for name, unit in {
                    q.name: q.unit for e in c.candidates for q in e.estimate.quantities
                }.items()
            ),
            labels=2,
        ),
        _errors(c.candidates),
        *((nested,) if c.tests else ()),
        Paragraph(
            sentences=(
                *(
                    Sentence(text=f"{t.smaller} in {t.larger} is not tested: {t.not_tested}.")
                    for t in c.tests
                    if t.not_tested
                ),
                *(
                    Sentence(
                        text=f"{t.larger} does not fit this record significantly better than "
                        f"{t.smaller} (Wald p = {_p(t.wald_p)})."
                    )
                    for t in c.tests
                    if t.wald_p is not None and t.wald_p >= SIGNIFICANCE_LEVEL.value
                ),
                *_remarks(c),
            )
        ),
        paragraph(
            Sentence(lead="recommended: ", text=f"{c.recommended or 'none'}; {c.reason}.", hang=4)
        ),
        paragraph(_rows(c)),
    )


def _heading(c: Comparison) -> Heading:
    """Return the heading of a comparison: parameters left out, records and method."""
    known = [{name: each[i] for name, each in c.known.items()} for i in range(len(c.records))]
    units = {p.name: p.unit for p in c.problem.axis.declared.parameters}
    return Heading(
        facts={
            "left out": _left_out(c.candidates),
            **records_facts(c.records, known, units),
            **set_aside_facts(c.set_aside),
            "columns": "",
            "method": f"{c.method.upper()} on the same rows for all candidates; {c.blocks} blocks "
            f"held out, with a gap of {c.gap} rows on both sides",
        }
    )


def _left_out(candidates: Sequence[Candidate]) -> str:
    """Return the parameters left out, as text; with the candidates' names if they differ."""
    texts = {c.name: left_out_text(c.axis.declared) for c in candidates}
    if len({*texts.values()}) == 1:
        return texts[candidates[0].name]
    return "; ".join(f"{text} in {name}" for name, text in texts.items() if text)


def _short(value: Value | None) -> Cell:
    """Return a value and its standard error, to two digits of the error; a dash without one."""
    if value is None:
        return "-"
    places = decimals(value.deviation)
    return QuantityCell(f"{value.value:.{places}f}", f"{value.deviation:.{places}f}")


def _errors(candidates: Sequence[Candidate]) -> TableBlock:
    """Return the table of the candidates' errors and information criteria."""
    least = {name: min(getattr(c.criteria, name) for c in candidates) for name in ("aic", "bic")}
    return text_table(
        ("candidate", "k", "equation %", "held out %", "simulation %", "dAIC", "dBIC"),
        (
            (
                c.name,
                str(c.size),
                or_dash(c.estimate.equation_error_percent, ".4f"),
                or_dash(c.equation.error_percent, ".4f"),
                or_dash(c.estimate.simulation_error_percent, ".4f"),
                *(
                    f"{above:.1f}" if math.isfinite(above) else "-"
                    for above in (getattr(c.criteria, name) - low for name, low in least.items())
                ),
            )
            for c in candidates
        ),
    )


def _p(value: float | None) -> str:
    """Return a p-value as text; a dash without one."""
    if value is None or math.isnan(value):
        return "-"
    return "<1e-16" if value < _SMALLEST_P else f"{value:.2g}"


def _remarks(c: Comparison) -> list[Sentence]:
    """Return sentences on failed bounds, the control law, excluded candidates and limits."""
    first, *others = c.candidates
    return [
        *(
            Sentence(text=f"{each.name}: {check.meaning}.")
            for each in c.candidates
            for check in [within_bounds(each.estimate, explained_by_others=each.name not in c.tied)]
            if isinstance(check, Check) and check.status == "fail"
        ),
        *(
            []
            if isinstance(c.law, Missing) or c.law.passed
            else [Sentence(text=f"Do not use these results: {c.law.sentence}.")]
        ),
        *(Sentence(text=f"{name} is excluded: {why}") for name, why in c.failures.items()),
        *(
            Sentence(text=f"no simulation of {', '.join(of)}: {why}")
            for why, of in grouped(
                (str(e.estimate.simulated), e.name)
                for e in c.candidates
                if isinstance(e.estimate.simulated, NotSimulated)
            ).items()
        ),
        *(
            Sentence(
                text=f"On these rows, {a} and {b} are the same model with different parameters."
            )
            for a, b in c.same
        ),
        *(
            Sentence(
                text=f"{e.name} and {first.name} have different control laws, so their simulation "
                "errors also contain this difference."
            )
            for e in others
            if e.axis.axis.control != first.axis.axis.control
        ),
    ]


def _rows(c: Comparison) -> str:
    """Return a note on how the records became the common rows."""
    drive, measured = c.candidates[0].axis.axis.drive, c.record.force is not None
    return rows_text(
        [data.sampling for data in c.problem.data],
        len(c.candidates[0].estimate.y),
        force_told(drive, drive.remark, is_gain=drive.is_gain, measured=measured),
        [data.record.motion for data in c.problem.data],
    )
