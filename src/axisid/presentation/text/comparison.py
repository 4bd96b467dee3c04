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
    """Return a comparison of candidate models as a document.

    It has estimates, errors and tests of the candidates, the recommendation, and the common rows.
    """
    tests = (_wald_tests(c),) if c.tests else ()
    return (
        _heading(c),
        _estimates(c.candidates),
        _errors(c.candidates),
        *tests,
        Paragraph(sentences=(*_test_sentences(c), *_remarks(c))),
        paragraph(
            Sentence(lead="recommended: ", text=f"{c.recommended or 'none'}; {c.reason}.", hang=4)
        ),
        paragraph(_rows(c)),
    )


def _estimates(candidates: Sequence[Candidate]) -> TableBlock:
    """Return the table of the estimates with standard errors, one column for each candidate."""
    units = {q.name: q.unit for each in candidates for q in each.estimate.quantities}
    return text_table(
        ["estimate +- sd", "unit", *(each.name for each in candidates)],
        (
            (name, unit, *(_short(each.estimate.parameters.get(name)) for each in candidates))
            for name, unit in units.items()
        ),
        labels=2,
    )


def _wald_tests(c: Comparison) -> TableBlock:
    """Return the table of the Wald tests: each smaller model within a larger one."""
    return text_table(
        ("nested model", "restrictions q", "Wald/q, HAC", "p"),
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


def _test_sentences(c: Comparison) -> list[Sentence]:
    """Return sentences on the models that are not tested, and on tests that are not significant."""
    sentences = [
        Sentence(text=f"{t.smaller} in {t.larger} is not tested: {t.not_tested}.")
        for t in c.tests
        if t.not_tested
    ]
    for t in c.tests:
        if t.wald_p is not None and t.wald_p >= SIGNIFICANCE_LEVEL.value:
            text = (
                f"{t.larger} does not fit this record significantly better than {t.smaller} "
                f"(Wald p = {_p(t.wald_p)})."
            )
            sentences.append(Sentence(text=text))
    return sentences


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
            f"are held out in turn, with a gap of {c.gap} rows on both sides",
        }
    )


def _left_out(candidates: Sequence[Candidate]) -> str:
    """Return the parameters left out, as text; with the candidates' names if they differ."""
    texts = {c.name: left_out_text(c.axis.declared) for c in candidates}
    if len({*texts.values()}) == 1:
        return texts[candidates[0].name]
    return "; ".join(f"{text} in {name}" for name, text in texts.items() if text)


def _short(value: Value | None) -> Cell:
    """Return a value and its standard error, rounded to two digits of the standard error.

    It is a dash for None, if the candidate does not have the parameter.
    """
    if value is None:
        return "-"
    places = decimals(value.deviation)
    return QuantityCell(f"{value.value:.{places}f}", f"{value.deviation:.{places}f}")


def _errors(candidates: Sequence[Candidate]) -> TableBlock:
    """Return the table of the candidates' errors and information criteria.

    The criteria are minus the smallest of all candidates.
    """
    smallest = {
        name: min(getattr(each.criteria, name) for each in candidates) for name in ("aic", "bic")
    }
    rows = []
    for each in candidates:
        above = [getattr(each.criteria, name) - least for name, least in smallest.items()]
        rows.append(
            (
                each.name,
                str(each.size),
                or_dash(each.estimate.equation_error_percent, ".4f"),
                or_dash(each.equation.error_percent, ".4f"),
                or_dash(each.estimate.simulation_error_percent, ".4f"),
                *(f"{value:.1f}" if math.isfinite(value) else "-" for value in above),
            )
        )
    return text_table(
        (
            *("candidate", "parameters", "equation [%]", "held out [%]", "simulation [%]"),
            *("dAIC", "dBIC"),
        ),
        rows,
        title=f"Errors in % of the {candidates[0].estimate.form.left} (rms), and criteria minus "
        "the smallest",
    )


def _p(value: float | None) -> str:
    """Return a p-value as text; a dash for None or NaN."""
    if value is None or math.isnan(value):
        return "-"
    return "<1e-16" if value < _SMALLEST_P else f"{value:.2g}"


def _remarks(c: Comparison) -> list[Sentence]:
    """Return sentences on the limits of the comparison, one for each finding.

    They are on failed bounds, the control law, excluded candidates, missing simulations, equal
    models and different control laws, in this order.
    """
    texts = []
    for each in c.candidates:
        bounds = within_bounds(each.estimate, explained_by_others=each.name not in c.tied)
        if isinstance(bounds, Check) and bounds.status == "fail":
            texts.append(f"{each.name}: {bounds.meaning}.")
    if not (isinstance(c.law, Missing) or c.law.passed):
        texts.append(f"Do not use these results: {c.law.sentence}.")
    texts += [f"{name} is excluded: {why}" for name, why in c.failures.items()]
    not_simulated = grouped(
        (str(each.estimate.simulated), each.name)
        for each in c.candidates
        if isinstance(each.estimate.simulated, NotSimulated)
    )
    texts += [f"No simulation of {', '.join(names)}: {why}" for why, names in not_simulated.items()]
    texts += [
        f"On these rows, {a} and {b} are the same model with different parameters."
        for a, b in c.same
    ]
    first, *others = c.candidates
    texts += [
        f"{each.name} and {first.name} have different control laws, so their simulation errors "
        "also contain this difference."
        for each in others
        if each.axis.axis.control != first.axis.axis.control
    ]
    return [Sentence(text=text) for text in texts]


def _rows(c: Comparison) -> str:
    """Return a note on how the records became the common rows."""
    drive, is_measured = c.candidates[0].axis.axis.drive, c.record.force is not None
    return rows_text(
        [data.sampling for data in c.problem.data],
        len(c.candidates[0].estimate.y),
        force_told(drive, drive.remark, is_gain=drive.is_gain, measured=is_measured),
        [data.record.motion for data in c.problem.data],
    )
