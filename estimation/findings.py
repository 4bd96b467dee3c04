"""Findings: what a check measured or saw, as numbers, names and units.

In: nothing. Out: the base class of findings, and findings that any check may have. Knows nothing of
the subject of a check: a finding of one subject is defined next to the check that makes it.
`axisid.presentation.sentences` has its sentence.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from axisid.support.errors import plain_numbers
from axisid.support.presentable import sentence_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Base of all findings."""

    @property
    def sentence(self) -> str:
        """Return the sentence that tells a user of it, without a full stop at its end."""
        return plain_numbers(sentence_of(self))


@dataclass(frozen=True, slots=True, kw_only=True)
class Said(Finding):
    """A finding that has no numbers: a sentence alone.

    Attributes
    ----------
    text : str
        A reason why a check could not be made, or what a check of the user's own says.
    """

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultOfCheck(Finding):
    """A fault of the program, or of a user's own candidate, by which a check could not be made.

    Attributes
    ----------
    reason : str
    """

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadFinding(Finding):
    """A finding that was read from a file.

    Attributes
    ----------
    text : str
        Its sentence.
    data : mapping of str to Any
        Its kind and its numbers, names and units.
    """

    text: str
    data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeveralFindings(Finding):
    """Findings of one check that are told one after another.

    Attributes
    ----------
    findings : tuple of Finding
    """

    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FindingOfRecords(Finding):
    """A finding of some of several records.

    Attributes
    ----------
    finding : Finding
        Of the record that is farthest beyond the threshold.
    records : tuple of str
        Names of the records with the same finding.
    others : tuple of str
        Names of the records with the same status and another finding.
    fails : bool
        Whether the check fails there; otherwise it is a note.
    """

    finding: Finding
    records: tuple[str, ...]
    others: tuple[str, ...]
    fails: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FindingExceptFor(Finding):
    """A finding of those of several records for which the check could be made.

    Attributes
    ----------
    finding : Finding
    unmade : tuple of str
        Names of the records for which it could not be made.
    """

    finding: Finding
    unmade: tuple[str, ...]
