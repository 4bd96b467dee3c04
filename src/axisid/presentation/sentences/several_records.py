"""Sentences of checks that compare several records."""

from collections.abc import Sequence

from axisid.estimation.diagnostics import (
    CommonSamples,
    ComparedRecords,
    DifferingParameter,
    OddRecord,
    RepeatedSamples,
    UnidentifiedInRecord,
)
from axisid.support.settings import setting

from .dispatch import sentence
from .words import listed


@sentence.register
def repeated_samples(finding: RepeatedSamples) -> str:
    """Return which records share samples, and how much too small standard errors are."""
    pairs = [_common_samples(each) for each in finding.pairs]
    factor = finding.repetitions**0.5
    return (
        f"{'; '.join(pairs)}. Standard errors are up to {factor:.3g} times too small. Give each "
        "sample once"
    )


def _common_samples(common: CommonSamples) -> str:
    spans = [f"from {start:.6g} to {end:.6g} s" for start, end in common.spans]
    return (
        f"{common.names[0]} and {common.names[1]} have {common.samples} samples in common, "
        f"{spans[0]} of the first and {spans[1]} of the second"
    )


@sentence.register
def compared_records(finding: ComparedRecords) -> str:
    """Return whether the records agree, and what differs in which record."""
    unidentified = _unidentified(finding.unidentified)
    largest = f"{finding.largest_percent:.2g} % of the {finding.output} of a record"
    if finding.odd is None:
        return (
            "each record alone gives the same parameters within chance: the differences have "
            f"effects of at most {largest}{unidentified}"
        )
    difference = _odd_record(finding.odd)
    if not finding.odd.matters:
        return (
            f"{difference}. The difference is significant, but its effect is less than "
            f"{finding.least_percent:g} % of the {finding.output}; the differences of all records "
            f"have effects of at most {largest}{unidentified}"
        )
    names = tuple(each.name for each in finding.odd.parameters)
    known = setting("known", {"NAME": ("V1", "V2")})
    return (
        f"{difference}. The differences have effects of up to {largest}{unidentified}. The common "
        "estimates describe none of the records, and the other parameters may be wrong too. "
        f"Give known values per record, such as those of a declared payload, with {known}, or "
        f"estimate {listed(names)} per record with {setting('local', names)}"
    )


def _odd_record(odd: OddRecord) -> str:
    """Return the record that differs, with the parameters of both sides."""
    others, compared = "the other records", "the others"
    if odd.other is not None:
        others = compared = odd.other
    text = f"{odd.name} differs from {others}: {differing(odd.parameters, odd.name, compared)}"
    loads = [each.name for each in odd.parameters if each.is_load]
    if loads:
        text += f". Another load changes {listed(loads)} in this way"
    return text


def differing(parameters: Sequence[DifferingParameter], record: str, others: str) -> str:
    """Return each parameter with its estimate from a record and from others."""
    texts = []
    for each in parameters:
        own, common = f"{each.own:.4g} {each.unit}", f"{each.common:.4g} {each.unit}"
        error = f"{each.standard_error:.1g} {each.unit}"
        texts.append(
            f"{each.name} is {own.rstrip()} in {record} and {common.rstrip()} in {others} "
            f"(difference {each.own - each.common:+.2g} +- {error.rstrip()})"
        )
    return listed(texts)


def _unidentified(records: Sequence[UnidentifiedInRecord]) -> str:
    """Return the parameters that single records do not identify, in parentheses."""
    texts = []
    for each in records:
        parameters = listed(each.parameters) or "the parameters"
        texts.append(f"{each.record} alone does not identify {parameters}")
    return f" ({'; '.join(texts)})" if texts else ""
