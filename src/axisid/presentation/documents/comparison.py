"""A comparison of candidates as a document."""

from dataclasses import asdict
from typing import Any

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
    plain,
)
from axisid.support.arrays import finite_tree
from axisid.support.remedy import as_options

from .identification import (
    estimate_document,
    left_out,
    note_text,
    prefilter_document,
    record_document,
)


def comparison_dict(comparison: Comparison) -> dict[str, Any]:
    """The comparison as plain numbers and texts; what is not finite becomes None."""
    return dict(finite_tree(plain(comparison_document(comparison))))


def comparison_document(comparison: Comparison) -> WrittenComparison:
    """Every candidate, how they were told apart, and which is recommended."""
    c = comparison
    return WrittenComparison(
        record=record_document(c.record),
        records=UNSET if len(c.records) == 1 else tuple(map(record_document, c.records)),
        known={each.name: _known(each) for each in c.known} or UNSET,
        set_aside={n: why.worded(as_options) for n, why in c.set_aside.items()} or UNSET,
        prefilter=prefilter_document(c.data.sampling),
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
        estimate=estimate_document(candidate.estimate),
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
