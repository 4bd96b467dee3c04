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
    """Return the records that share samples, and the factor by which standard errors are small.

    Samples that are used r times make standard errors up to sqrt(r) times too small.
    """
    pairs = [_common_samples(each) for each in finding.pairs]
    factor = finding.repetitions**0.5
    return (
        f"{'; '.join(pairs)}. Standard errors are up to {factor:.3g} times too small. Use each "
        "sample only once"
    )


def _common_samples(common: CommonSamples) -> str:
    """Return the number and the times of the samples that two records have in common."""
    spans = [f"from {start:.6g} to {end:.6g} s" for start, end in common.spans]
    return (
        f"{common.names[0]} and {common.names[1]} have {common.samples} samples in common, "
        f"{spans[0]} of the first and {spans[1]} of the second"
    )


@sentence.register
def compared_records(finding: ComparedRecords) -> str:
    """Return the parameters that differ in one record, their effect, and the instruction.

    If the records agree, it is the largest effect of their differences.
    """
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
            f"{finding.least_percent:g} % of the {finding.output}. The differences of all records "
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
    """Return the record that differs, with its parameters and those of the other records.

    If one record is compared with one other, `odd.other` is its name; otherwise it is None.
    """
    others = "the other records"
    if odd.other is not None:
        others = odd.other
    text = f"{odd.name} differs from {others}: {differing(odd.parameters, odd.name, others)}"
    loads = [each.name for each in odd.parameters if each.is_load]
    if loads:
        text += f". Another load changes {listed(loads)} in this way"
    return text


def differing(parameters: Sequence[DifferingParameter], record: str, others: str) -> str:
    """Return each parameter with its estimates from a record and from others, and the difference.

    `record` and `others` are the names of the compared records in the sentence.
    """
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
    """Return the parameters that single records do not identify, in parentheses.

    It is empty if there are none.
    """
    texts = []
    for each in records:
        parameters = listed(each.parameters) or "the parameters"
        texts.append(f"{each.record} alone does not identify {parameters}")
    return f" ({'; '.join(texts)})" if texts else ""
