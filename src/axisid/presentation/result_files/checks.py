"""Checks of a verdict as plain data: written with their sentences and numbers, and read back."""

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Annotated, Any

from msgspec import UNSET, UnsetType

from axisid.estimation.findings import Finding, ReadFinding
from axisid.estimation.verdict_checks import Check, Status
from axisid.support.settings import settings_in_python

from .json_objects import JsonObject, about, plain, written_as


class WrittenCheck(JsonObject, frozen=True, kw_only=True):
    """One check of a result, see `Check`."""

    name: str
    status: Status
    meaning: Annotated[str, about("What was found and what can be done about it, as text.")]
    finding: Annotated[
        Mapping[str, Any] | UnsetType,
        about("What was found as data: its kind, and its numbers, names and units."),
    ] = UNSET
    figure: float | None = None
    threshold: float | None = None
    p_value: float | None = None
    source: str = ""
    leaves_open: bool = False


def written_checks(checks: Iterable[Check]) -> tuple[WrittenCheck, ...]:
    """Return checks as parts of a document; settings in sentences are spelled as in Python."""
    with settings_in_python():
        return tuple(
            written_as(WrittenCheck, check, finding=finding_data(check.finding)) for check in checks
        )


def read_checks(written: Iterable[WrittenCheck]) -> tuple[Check, ...]:
    """Return the checks of a document; their sentences are those of the file."""
    return tuple(
        Check(
            name=each.name,
            status=each.status,
            finding=ReadFinding(text=each.meaning, data=each.finding or {}),
            figure=each.figure,
            threshold=each.threshold,
            p_value=each.p_value,
            source=each.source,
            leaves_open=each.leaves_open,
        )
        for each in written
    )


def finding_data(finding: Finding) -> dict[str, Any] | UnsetType:
    """Return a finding as plain data: its kind, and its numbers, names and units.

    Findings inside it are written in the same way. Unset for a finding that was read from a file
    without data.
    """
    if isinstance(finding, ReadFinding):
        return dict(finding.data) or UNSET
    return plain(_with_kinds(finding))


def _with_kinds(value: object) -> Any:
    """Return a value as plain data, in which each finding has its class as member ``kind``."""
    if is_dataclass(value) and not isinstance(value, type):
        members = {field.name: _with_kinds(getattr(value, field.name)) for field in fields(value)}
        if isinstance(value, Finding):
            members["kind"] = type(value).__name__
        return members
    if isinstance(value, tuple):
        return [_with_kinds(each) for each in value]
    if isinstance(value, Mapping):
        return {key: _with_kinds(each) for key, each in value.items()}
    return value
