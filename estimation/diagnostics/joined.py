"""One check of each of several records as one check of all, which names the record that fails."""

from collections.abc import Sequence
from dataclasses import replace

from axisid.estimation.checks import Check, Status
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy

_WORST: tuple[Status, ...] = ("fail", "note", "pass")


def joined(
    found: Sequence[Check | Missing | None], records: Sequence[str]
) -> Check | Missing | None:
    """The worst of the checks, with the records that it is of.

    Parameters
    ----------
    found : sequence of Check, Missing or None
        By record, as a diagnostic gives them.
    records : sequence of str
        Their names.
    """
    made = [(n, each) for n, each in zip(records, found, strict=True) if isinstance(each, Check)]
    if not made:
        reasons = [each for each in found if isinstance(each, Missing)]
        return reasons[0] if reasons else None
    status = next(s for s in _WORST if any(each.status == s for _, each in made))
    worst = [(n, each) for n, each in made if each.status == status]
    first = max((each for _, each in worst), key=_distance)
    if status == "pass":
        return _of_all(first, found, records)
    told = [(n, each) for n, each in worst if each is first]
    same = [n for n, each in worst if each.meaning == first.meaning]
    others = [n for n, each in worst if n not in same]
    lead = " and ".join(same or [told[0][0]])
    also = "fails" if status == "fail" else "is noted"
    more = f"; it {also} of {_listed(others)} too" if others else ""
    return _worded(first, f"{lead}: ", more)


def _of_all(first: Check, found: Sequence[Check | Missing | None], records: Sequence[str]) -> Check:
    """A check that every record passes, or that could not be made of some."""
    missing = [n for n, each in zip(records, found, strict=True) if isinstance(each, Missing)]
    return _worded(first, "", f" (not evaluated of {_listed(missing)})") if missing else first


def _worded(check: Check, before: str, after: str) -> Check:
    note = check.note
    remedy = note.remedy
    if after:
        remedy = None if remedy is None else Remedy.of(remedy, after)
    said = Note(before + note.text + ("" if remedy else after), remedy)
    return replace(check, meaning=said.text, remedy=said.remedy)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _distance(check: Check) -> float:
    """How far a figure is beyond its threshold, whichever side is bad; 0 where it has none."""
    if check.figure is None or not check.threshold:
        return 0.0
    ratio = abs(check.figure / check.threshold)
    return max(ratio, 1 / ratio) if ratio else 0.0
