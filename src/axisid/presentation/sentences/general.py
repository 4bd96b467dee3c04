"""Sentences of findings that any check may have."""

from axisid.estimation.findings import (
    FaultOfCheck,
    FindingExceptFor,
    FindingOfRecords,
    ReadFinding,
    Said,
    SeveralFindings,
)

from .dispatch import sentence
from .words import listed, one_after_another


@sentence.register
def said(finding: Said) -> str:
    """Return the text of a finding that has only a text."""
    return finding.text


@sentence.register
def fault(finding: FaultOfCheck) -> str:
    """Return the reason why a check could not be evaluated because of a fault of the program."""
    return finding.reason


@sentence.register
def read(finding: ReadFinding) -> str:
    """Return the sentence of a finding that was read from a file."""
    return finding.text


@sentence.register
def several(finding: SeveralFindings) -> str:
    """Return the sentences of several findings, one after another."""
    return one_after_another([sentence(each) for each in finding.findings])


@sentence.register
def of_records(finding: FindingOfRecords) -> str:
    """Return the sentence of the worst record, with the names of the other records concerned."""
    text = f"{listed(finding.records)}: {sentence(finding.finding)}"
    if not finding.others:
        return text
    if finding.fails:
        return f"{text}. The check fails for {listed(finding.others)} too"
    return f"{text}. There is a note on {listed(finding.others)} too"


@sentence.register
def except_for(finding: FindingExceptFor) -> str:
    """Return the sentence of a finding, with the names of the records that were not checked."""
    return f"{sentence(finding.finding)} (not evaluated for {listed(finding.unmade)})"
