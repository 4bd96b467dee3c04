"""A comparison of candidates as a document."""

import math
from collections.abc import Sequence
from types import MappingProxyType

from axisid.estimation.diagnostic_checks import Check
from axisid.estimation.diagnostics import within_bounds
from axisid.estimation.estimates import Value
from axisid.estimation.model_validation import Candidate, Comparison, ParameterSignificance
from axisid.estimation.thresholds import SIGNIFICANCE_LEVEL
from axisid.modeling.declaration import left_out_text
from axisid.presentation.documents import (
    Cell,
    Document,
    Heading,
    Notes,
    Paragraph,
    QuantityCell,
    Sentence,
    TableBlock,
    decimals,
    paragraph,
    text_table,
)
from axisid.support.errors import Missing, or_dash
from axisid.support.mappings import grouped

from .estimate import quantity
from .record import force_told, records_facts, rows_text, set_aside_facts

_ABREAST = 4  # candidates in one table
_SMALLEST_P = 1e-16
#: What to blame for values beyond their bounds where another candidate explains more.
_LACKING = "its parameters take up what it lacks, which other candidates have"
#: What the notes, by number, add where a candidate is partially linear.
_OF_NONLINEAR = MappingProxyType(
    {
        2: "Of a partially linear model, a block's estimate is one linearised step from the whole "
        "record's, so that its held-out error is a little too small; nonlinear parameters are kept "
        "within their bounds before the loop is simulated with them.",
        4: "No test where the larger model estimates a nonlinear parameter that means nothing "
        "where the smaller one holds: there it is fitted to noise, and neither statistic is F "
        "distributed. The criteria count it as any other, and overrate it. Go by the held-out "
        "error.",
        5: "Nonlinear parameters are not judged. Where one would mean nothing with another at "
        "zero, that other one carries information if the held-out error is larger without both by "
        "more than one standard error.",
    }
)


def comparison_document(c: Comparison) -> Document:
    """Heading, estimates, errors, tests, the recommendation and notes."""
    return (
        _heading(c),
        *(
            text_table(
                ["estimate +- sd [1]", "unit", *(e.name for e in abreast)],
                (
                    (name, unit, *(_short(e.estimate.parameters.get(name)) for e in abreast))
                    for name, unit in {
                        q.name: q.unit for e in abreast for q in e.estimate.quantities
                    }.items()
                ),
                labels=2,
            )
            for i in range(0, len(c.candidates), _ABREAST)
            for abreast in [c.candidates[i : i + _ABREAST]]
        ),
        _errors(c.candidates),
        *((_tests(c),) if c.tests else ()),
        Paragraph(
            sentences=(
                *_uninformed(c.candidates),
                *_untested(c),
                *(
                    Sentence(
                        text=f"{t.larger} says no more than {t.smaller} on this record (Wald p = "
                        f"{_p(t.wald_p)})."
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
        Notes(tuple(_notes(c))),
    )


def _heading(c: Comparison) -> Heading:
    known = [{name: each[i] for name, each in c.known.items()} for i in range(len(c.records))]
    units = {p.name: p.unit for p in c.problem.axis.declared.parameters}
    facts = {
        "left out": _left_out(c.candidates),
        **records_facts(c.records, known, units),
        **set_aside_facts(c.set_aside),
        "columns": "",
        "method": f"{c.method.upper()}; the same rows for all [7]; {c.blocks} blocks held out, a "
        f"gap of {c.gap} rows on both sides",
    }
    return Heading(facts=tuple(facts.items()))


def _left_out(candidates: Sequence[Candidate]) -> str:
    """What stands for the parameters that were left out, and of which candidates if not all."""
    texts = {c.name: left_out_text(c.axis.declared) for c in candidates}
    if len({*texts.values()}) == 1:
        return texts[candidates[0].name]
    return "; ".join(f"{text} of {name}" for name, text in texts.items() if text)


def _short(value: Value | None) -> Cell:
    """The digits that two digits of the deviation warrant."""
    if value is None:
        return "-"
    shown = quantity(value)
    number, spread = float(shown.value), float(shown.deviation)
    places = decimals(spread)
    return QuantityCell(f"{number:.{places}f}", f"{spread:.{places}f}")


def _errors(candidates: Sequence[Candidate]) -> TableBlock:
    least = {
        name: min(getattr(c.criteria, name) for c in candidates) for name in ("aic", "bic", "tic")
    }
    return text_table(
        (
            *("candidate", "k [2]", "equation %", "held out %", "simul. %", "held out %"),
            *("dAIC [3]", "dBIC [3]", "dTIC [4]"),
        ),
        (
            (
                c.name,
                str(c.size),
                or_dash(c.estimate.equation_error_percent, ".4f"),
                or_dash(c.equation.error_percent, ".4f"),
                or_dash(c.estimate.simulation_error_percent, ".4f"),
                or_dash(None if c.simulation is None else c.simulation.error_percent, ".4f"),
                *(
                    f"{above:.1f}" if math.isfinite(above) else "-"
                    for above in (getattr(c.criteria, name) - low for name, low in least.items())
                ),
            )
            for c in candidates
        ),
    )


def _tests(c: Comparison) -> TableBlock:
    """Every nested pair, classical and robust."""
    return text_table(
        ("nested model", "restrictions", "F [3]", "p", "Wald/q, HAC [4]", "p"),
        (
            (
                f"{t.smaller} in {t.larger}",
                str(t.restrictions),
                or_dash(t.f, ".4g"),
                _p(t.f_p),
                or_dash(t.wald, ".4g"),
                _p(t.wald_p),
            )
            for t in c.tests
        ),
    )


def _p(value: float | None) -> str:
    if value is None or math.isnan(value):
        return "-"
    return "<1e-16" if value < _SMALLEST_P else f"{value:.2g}"


def _uninformed(candidates: Sequence[Candidate]) -> list[Sentence]:
    """A sentence for each parameter that the record does not need."""
    tested = "" if all(c.axis.is_linear for c in candidates) else "linear "
    return [
        Sentence(text=f"{check.name} of {c.name} carries no information: {_why(check, c)} [5].")
        for c in candidates
        for check in c.checks
        if check.informed is False
    ] or [Sentence(text=f"Every {tested}parameter of every candidate carries information [5].")]


def _untested(c: Comparison) -> list[Sentence]:
    """A sentence for each pair and each parameter that no test judges."""
    return [
        *(
            Sentence(text=f"{t.smaller} in {t.larger} is not tested: {t.not_tested} [4].")
            for t in c.tests
            if t.not_tested
        ),
        *(
            Sentence(text=f"{check.name} of {each.name} is not judged: {check.not_tested} [5].")
            for each in c.candidates
            for check in each.checks
            if check.informed is None
        ),
    ]


def _why(check: ParameterSignificance, candidate: Candidate) -> str:
    zero = f"it may be zero (HAC p = {_p(check.p_value)})"
    if check.without_percent is None:
        return zero
    errors = (
        f"the held-out error is {check.without_percent:.5g} % without it, "
        f"{candidate.equation.error_percent:.5g} % with it"
    )
    if check.p_value is None:
        return errors
    if check.p_value >= SIGNIFICANCE_LEVEL.value:
        return f"{zero}; {errors}"
    return f"{errors}, though zero is rejected (HAC p = {_p(check.p_value)})"


def _remarks(c: Comparison) -> list[Sentence]:
    """Bounds and control laws that do not hold, what kept a candidate out, and what disagrees."""
    shared = grouped((e.reason, e.name) for e in c.candidates if e.reason)
    simulated = [(e.simulation.error_percent, e.name) for e in c.candidates if e.simulation]
    least = min(simulated)[1] if simulated else None
    first, *others = c.candidates
    return [
        *(
            Sentence(text=f"{each.name}: {check.meaning}.")
            for each in c.candidates
            for check in [within_bounds(each.estimate, None if each.name in c.tied else _LACKING)]
            if isinstance(check, Check) and check.status == "fail"
        ),
        *(
            []
            if isinstance(c.law, Missing) or c.law.passed
            else [Sentence(text=f"Believe nothing before this is mended: {c.law.sentence}.")]
        ),
        *(Sentence(text=f"{name} is left out: {why}") for name, why in c.failures.items()),
        *(
            Sentence(text=f"{a} and {b} are the same model in different parameters, on these rows.")
            for a, b in c.same
        ),
        *(Sentence(text=f"no simulation of {', '.join(of)}: {why}") for why, of in shared.items()),
        *(
            Sentence(
                text=f"{e.name} and {first.name} have different control laws, so their simulation "
                "errors compare these too."
            )
            for e in others
            if e.axis.axis.control != first.axis.axis.control
        ),
        *(
            []
            if least in (None, c.recommended, *c.tied)
            else [Sentence(text=f"The held-out simulation error is smallest for {least}.")]
        ),
    ]


def _notes(c: Comparison) -> list[str]:
    drive, measured = c.candidates[0].axis.axis.drive, c.record.force is not None
    force = force_told(drive, drive.remark, is_gain=drive.is_gain, measured=measured)
    instruments = (
        " Instruments are those of the loop simulated with all rows' estimate."
        if any(each.estimate.Z is not None for each in c.candidates)
        else ""
    )
    notes = [
        "sd: HAC, for autocorrelated residuals, as in identify.",
        "k parameters. Equation error ||y - X theta||/||y|| of the force; simulation error: of "
        "the simulated loop. Held out: each block by the estimate from the others, without the "
        f"rows next to it, which share samples with it through the filters.{instruments}",
        "AIC, BIC and F: classical, of least squares, for independent rows. Rows of filtered data "
        "are not independent, so these overrate every further parameter: shown for comparison with "
        "publications.",
        "Believe these: the Wald test of the same restriction with the HAC covariance (over its q "
        "restrictions; p by Hotelling's T^2 with the effective degrees of freedom), and Takeuchi's "
        "criterion TIC, AIC with the penalty 2 tr(V_iid^-1 V_hac) in place of 2 k. d: above the "
        "smallest. Where residuals stay alike for long, the Wald test still rejects too often: a "
        "true model in 1 of 5 at the worst.",
        "A parameter carries no information where the HAC test does not reject zero at 5 %, or "
        "where the held-out error is no larger without it.",
        "Recommended: of the candidates whose held-out equation error is within one standard error "
        "(of its excess over the smallest, by block) and 1.1 times the smallest, or 1.01 times the "
        "smallest whatever the blocks say, the one with the fewest parameters.",
        rows_text(
            [data.sampling for data in c.problem.data],
            len(c.candidates[0].estimate.y),
            force,
            [data.record.motion for data in c.problem.data],
        ),
    ]
    if any(not each.axis.is_linear for each in c.candidates):
        for i, addition in _OF_NONLINEAR.items():
            notes[i - 1] += f" {addition}"
    return notes
