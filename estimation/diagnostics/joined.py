"""One check of each of several records as one check of all, which names the record that fails."""

from collections.abc import Sequence
from dataclasses import replace

from axisid.estimation.checks import Check, Status
from axisid.support.remedy import Note, Remedy

_WORST: tuple[Status, ...] = ("fail", "note", "pass")
_UNMADE: Status = "not evaluated"


def joined(found: Sequence[Check | None], records: Sequence[str]) -> Check | None:
    """The worst of the checks, with the records that it is of.

    Parameters
    ----------
    found : sequence of Check or None
        By record, as a diagnostic gives them.
    records : sequence of str
        Their names.
    """
    every = [(name, each) for name, each in zip(records, found, strict=True) if each is not None]
    made = [(name, each) for name, each in every if each.status != _UNMADE]
    if not made:
        return every[0][1] if every else None
    status = next(s for s in _WORST if any(each.status == s for _, each in made))
    worst = [(n, each) for n, each in made if each.status == status]
    first = max((each for _, each in worst), key=_distance)
    if status == "pass":
        unmade = [name for name, each in every if each.status == _UNMADE]
        return _worded(first, "", f" (not evaluated of {_listed(unmade)})") if unmade else first
    same = [n for n, each in worst if each.meaning == first.meaning]
    others = [n for n, each in worst if n not in same]
    also = "fails" if status == "fail" else "is noted"
    more = f"; it {also} of {_listed(others)} too" if others else ""
    return _worded(first, f"{' and '.join(same)}: ", more)


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
