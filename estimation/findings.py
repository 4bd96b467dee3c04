"""Findings: the result of a check as numbers, names and units.

In: nothing. Out: the base class of findings, and findings that any check may have. Knows nothing of
the subject of a check: a finding of one subject is defined next to the check that makes it.
`axisid.presentation.sentences` makes the sentence of each finding.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from axisid.support.presentable import sentence_of
from axisid.support.wording import plain_numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Result of a check as numbers, names and units; the base class of all findings."""

    @property
    def sentence(self) -> str:
        """Return the sentence for the user, without a full stop at its end."""
        return plain_numbers(sentence_of(self))


@dataclass(frozen=True, slots=True, kw_only=True)
class Said(Finding):
    """A finding that is only a sentence, without numbers.

    Attributes
    ----------
    text : str
        Reason why a check could not be made, or the sentence of a user's own check.
    """

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultOfCheck(Finding):
    """A fault of the program, or of a user's own candidate, that prevented a check.

    Attributes
    ----------
    reason : str
        Sentence about the fault.
    """

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadFinding(Finding):
    """A finding that was read from a file.

    Attributes
    ----------
    text : str
        Sentence of the finding.
    data : mapping of str to Any
        Members of the finding by name: ``kind``, the name of its class, and its numbers, names and
        units.
    """

    text: str
    data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeveralFindings(Finding):
    """Several findings of one check.

    Attributes
    ----------
    findings : tuple of Finding
        The findings, in the order in which they are reported.
    """

    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FindingOfRecords(Finding):
    """Finding of a check that was made for several records and did not pass for all of them.

    Attributes
    ----------
    finding : Finding
        Finding of the record that is farthest beyond the threshold.
    records : tuple of str
        Names of the records with the same finding.
    others : tuple of str
        Names of the records with the same status but another finding.
    fails : bool
        Whether the check fails for these records; otherwise it is a note.
    """

    finding: Finding
    records: tuple[str, ...]
    others: tuple[str, ...]
    fails: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FindingExceptFor(Finding):
    """Finding of a check that passed for some records and could not be made for others.

    Attributes
    ----------
    finding : Finding
        Finding of the record whose figure is farthest from its threshold.
    unmade : tuple of str
        Names of the records for which the check could not be made.
    """

    finding: Finding
    unmade: tuple[str, ...]
