"""A comparison of candidates as a document."""

from dataclasses import asdict

from msgspec import UNSET

from axisid.estimation.parameters import Known
from axisid.estimation.studies import Candidate, Comparison, HeldOut
from axisid.presentation.schema import (
    WrittenCandidate,
    WrittenComparison,
    WrittenCriteria,
    WrittenHeldOut,
    WrittenHeldOutBlocks,
    WrittenKnown,
    WrittenNestedTest,
    WrittenParameterCheck,
)
from axisid.support.remedy import as_options

from .identification import (
    left_out,
    note_text,
    written_estimate,
    written_prefilter,
    written_record,
)


def written_comparison(comparison: Comparison) -> WrittenComparison:
    """Every candidate, how they were told apart, and which is recommended."""
    c = comparison
    return WrittenComparison(
        belief=c.belief,
        record=written_record(c.record),
        records=UNSET if len(c.records) == 1 else tuple(map(written_record, c.records)),
        known={each.name: _known(each) for each in c.known} or UNSET,
        set_aside={n: why.worded(as_options) for n, why in c.set_aside.items()} or UNSET,
        prefilter=written_prefilter(c.data.sampling),
        method=c.method,
        rows=len(c.candidates[0].estimate.y),
        held_out=WrittenHeldOutBlocks(blocks=c.blocks, gap_rows=c.gap),
        candidates=tuple(map(_candidate, c.candidates)),
        failures={name: why.worded(as_options) for name, why in c.failures.items()},
        tests=tuple(WrittenNestedTest(**asdict(test)) for test in c.tests),
        same=tuple(map(tuple, c.same)),
        recommended=c.recommended,
        tied=tuple(c.tied),
        reason=c.reason,
    )


def _known(known: Known) -> tuple[WrittenKnown, ...]:
    pairs = zip(known.values, known.deviations, strict=True)
    return tuple(WrittenKnown(value=value, sd=sd) for value, sd in pairs)


def _candidate(candidate: Candidate) -> WrittenCandidate:
    simulation = candidate.simulation
    return WrittenCandidate(
        name=candidate.name,
        axis=candidate.axis.axis.name,
        signature=candidate.axis.signature,
        left_out=left_out(candidate.axis),
        estimate=written_estimate(candidate.estimate),
        criteria=WrittenCriteria(**asdict(candidate.criteria)),
        held_out_equation=_held_out(candidate.equation),
        held_out_simulation=None if simulation is None else _held_out(simulation),
        no_simulation=note_text(candidate.reason),
        parameter_checks=tuple(WrittenParameterCheck(**asdict(c)) for c in candidate.checks),
    )


def _held_out(held_out: HeldOut) -> WrittenHeldOut:
    return WrittenHeldOut(
        error_percent=held_out.error_percent, squares_by_block=tuple(held_out.squares.tolist())
    )
