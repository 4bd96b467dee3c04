"""What would make a recorded control the declared law's: a column changed, another velocity."""

import math
from collections.abc import Iterator
from dataclasses import replace

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.records import Record
from axisid.estimation.thresholds.diagnostics import MAX_LAW_RESIDUAL, MAX_REPAIRED_RESIDUAL
from axisid.modeling.declaration import ControlLaw
from axisid.modeling.laws import velocity_variants
from axisid.support.remedy import Note, Remedy, Setting

from .law_terms import law_error_percent
from .position_zero import position_zero, zero_note

_COLUMN_FAULTS = {
    -1.0: "its sign",
    1e-3: "its unit, such as millimetres for metres",
    1e3: "its unit, such as metres for millimetres",
    math.pi / 180: "its unit, such as degrees for radians",
}


def repair_of(
    axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int, declared: float, shift: int
) -> Note | None:
    """What would make the law fit: columns changed, or its velocity formed otherwise; or None.

    Where the control is only some samples early or late, there is nothing else to mend.
    """
    good = min(MAX_LAW_RESIDUAL.value, MAX_REPAIRED_RESIDUAL.value * declared)
    if shift:
        if law_error_percent(axis, law, record.shifted(control=-shift), settle) < good:
            return None
        return _moved_column(axis, law, record, settle, good)
    for said, changed in _changed_columns(record, law):
        if law_error_percent(axis, law, changed, settle) < good:
            return Note(f"it is with {said}")
    if moved := _moved_column(axis, law, record, settle, good):
        return moved
    zero = position_zero(axis, law, record, settle)
    if zero is not None and zero.error_percent < good:
        return zero_note(axis, record, zero)
    offs = {
        name: law_error_percent(
            build(replace(axis.axis, control=variant), native=False), variant, record, settle
        )
        for name, variant in velocity_variants(law).items()
    }
    best = min(offs, key=lambda name: offs[name], default="")
    if not best or offs[best] >= good:
        return None
    return Note(
        f"it is that of the law {best} with the same gains ({offs[best]:.2g} % off), which forms "
        "the velocity in another way: declare that"
    )


def _moved_column(
    axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int, good: float
) -> Note | None:
    """The reference or the position some samples earlier or later, where the law fits them so."""
    offs = {
        (role, samples): law_error_percent(axis, law, record.shifted(**{role: samples}), settle)
        for samples in (1, -1, 2, -2)
        for role in ("reference", "position", *_signals_of(law))
    }
    role, samples = min(offs, key=lambda moved: offs[moved])
    if offs[role, samples] >= good:
        return None
    way = "later" if samples > 0 else "earlier"
    return Note(
        f"it is with the {role} {abs(samples)} sample{'s' * (abs(samples) > 1)} {way}: where the "
        "log wrote it at another time, move it with ",
        Remedy.of(Setting("shift", f"{role}={samples}")),
    )


def _changed_columns(record: Record, law: ControlLaw) -> Iterator[tuple[str, Record]]:
    """The record as it would be without a common mistake in its columns, and which."""
    reference, position = record.reference, record.position
    assert reference is not None  # noqa: S101  # there is none to check without it
    if record.injected is not None:
        there = "reference" if record.injected_at == "control" else "control"
        yield f"the test signal added to the {there}", replace(record, injected_at=there)
        for scale, what in _COLUMN_FAULTS.items():
            scaled = replace(record, injected=scale * record.injected)
            yield f"the test signal times {scale:g}: check {what}", scaled
        yield "no test signal: check which column it is", replace(record, injected=None)
    for role, values in (("position", position), ("reference", reference)):
        for scale, what in _COLUMN_FAULTS.items():
            changed = replace(record, **{role: scale * values})  # type: ignore[arg-type]
            yield f"the {role} times {scale:g}: check {what}", changed
    for name in _signals_of(law):
        for scale, what in _COLUMN_FAULTS.items():
            signals = {**record.signals, name: scale * record.signals[name]}
            yield f"the {name} times {scale:g}: check {what}", replace(record, signals=signals)
    swapped = replace(record, position=reference, reference=position)
    yield "position and reference exchanged: check which column is which", swapped


def _signals_of(law: ControlLaw) -> tuple[str, ...]:
    """Names of the recorded signals that a law reads."""
    return tuple(sorted(map(str, law.signals)))
