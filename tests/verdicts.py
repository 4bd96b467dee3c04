"""Checks of a verdict, by their names."""

from typing import TypeVar

from axisid import Identification
from axisid.estimation.findings import Finding, FindingOfRecords
from axisid.estimation.output_error import OutputFit
from axisid.estimation.verdict_checks import Check


def checks_of(result: Identification | OutputFit) -> dict[str, Check]:
    return {check.name: check for check in result.checks}


def statuses(result: Identification | OutputFit) -> dict[str, str]:
    return {check.name: check.status for check in result.checks}


def meaning_of(result: Identification | OutputFit, name: str, status: str = "fail") -> str:
    """What a check says, which has to have a status."""
    check = checks_of(result)[name]
    assert check.status == status, check.meaning
    return check.meaning


Kind = TypeVar("Kind", bound=Finding)


def finding_of(check: object, kind: type[Kind]) -> Kind:
    """The finding of a check, which is of a kind; of several records that of the worst."""
    assert isinstance(check, Check), check
    found = check.finding
    if isinstance(found, FindingOfRecords):
        found = found.finding
    assert isinstance(found, kind), found
    return found
