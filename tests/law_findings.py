"""Findings of a control law compared with a record."""

from typing import TypeVar

from axisid.estimation import LawAgreement
from axisid.estimation.diagnostics.control_law import FoundByReading, LawRepair, RepairedLaw
from axisid.estimation.findings import Finding

Kind = TypeVar("Kind", bound=Finding)
RepairKind = TypeVar("RepairKind", bound=LawRepair)


def law_finding_of(law: object, kind: type[Kind]) -> Kind:
    """The finding of a comparison, which is of a kind, whatever samples the law read."""
    assert isinstance(law, LawAgreement), law
    found = law.finding
    if isinstance(found, FoundByReading):
        found = found.finding
    assert isinstance(found, kind), found
    return found


def repair_of_law(law: object, kind: type[RepairKind]) -> RepairKind:
    """What makes a law fit, which is of a kind."""
    repair = law_finding_of(law, RepairedLaw).repair
    assert isinstance(repair, kind), repair
    return repair
