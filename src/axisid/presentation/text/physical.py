"""Physical parameters in the summary's notes: what they rest on, and which do not follow."""

from collections.abc import Mapping

from axisid.modeling.declaration import known_text
from axisid.presentation.saved import SavedPhysical
from axisid.support.remedy import Note, Remedy, Setting, Wording

_FIX = Remedy.of(" (", Setting("fix", "NAME=VALUE+-SD"), ")")


def physical_notes(found: Mapping[str, SavedPhysical], wording: Wording) -> list[str]:
    """Notes of a table; none where the estimates are of the physical parameters already."""
    if not found:
        return []
    notes = []
    if any(physical.shows_more for physical in found.values()):
        notes.append(_how(next(iter(found.values()))))
    said: dict[str, list[str]] = {}
    for method, physical in found.items():
        fixable = (_fixable(sentence).worded(wording) for sentence in physical.undetermined)
        for sentence in (*fixable, *physical.remarks):
            said.setdefault(sentence, []).append(method)
    return notes + [
        f"{sentence}." if len(methods) == len(found) else f"{', '.join(methods)}: {sentence}."
        for sentence, methods in said.items()
    ]


def _fixable(sentence: str) -> Note:
    return Note(sentence, _FIX if sentence.endswith(" known") else None)


def _how(physical: SavedPhysical) -> str:
    known = ", ".join(f"{p.name} = {known_text(p)} {p.unit}" for p in physical.base.known)
    fixed = f", and to {known}, declared as known" if known else ""
    more = (
        " Where the record shows a known parameter too, the two are weighed, and the others change "
        "through their correlation with it."
        if known
        else ""
    )
    return (
        "Physical parameters: the nearest to the estimates above, less its bias, by "
        f"their covariance{fixed} (minimum distance).{more}"
    )
