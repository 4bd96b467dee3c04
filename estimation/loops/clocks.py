"""The clocks of a record and of its law, and what is worked out once for each record."""

import math
import weakref
from collections.abc import Hashable
from functools import partial
from typing import Generic, TypeVar

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record, clock_of, law_ratio
from axisid.estimation.simulation import TwoClocks, law_of
from axisid.estimation.thresholds import MIN_PHASE_AGREEMENT
from axisid.support.arrays import Array

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class KeptByRecord(Generic[K, V]):
    """What is known of records that are alive, by their identity, asked for in every iteration."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[weakref.ref[Record], dict[K, V]]] = {}

    def of(self, record: Record) -> dict[K, V]:
        """What is known of a record, to be added to."""
        found = self._known.get(id(record))
        if found is None:
            alive = weakref.ref(record, partial(self._forget, id(record)))
            found = self._known[id(record)] = (alive, {})
        return found[1]

    def __len__(self) -> int:
        return len(self._known)

    def _forget(self, record: int, _: object) -> None:
        self._known.pop(record, None)


#: With the reference that they took to the law's evaluations.
_KNOWN: KeptByRecord[tuple[GeneratedAxis, tuple[int, int]], TwoClocks | None] = KeptByRecord()


def two_clocks(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> TwoClocks | None:
    """When the law is evaluated along a segment of a record; None at each of its samples.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
    span : tuple of int
        First row and the one after the last.
    """
    known = _KNOWN.of(record)
    if (axis, span) not in known:
        known[axis, span] = _two_clocks(axis, record, span)
    return known[axis, span]


def _two_clocks(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> TwoClocks | None:
    law = law_of(axis)
    ratio = law_ratio(law, record.period, clock_of(record)) or 1.0
    if ratio == 1.0:
        return None
    control = None if record.control is None else record.control[slice(*span)]
    late = 0.0 if ratio > 1 or control is None else _first_change(control, 1 / ratio)
    return TwoClocks(
        samples=span[1] - span[0],
        log_period=record.period,
        law_period=law.period,
        first=record.period * late,
        between=law.reference_between or "spline",
    )


def _first_change(control: Array, samples: float) -> float:
    """When a control that is held over so many samples was last changed before the first, samples.

    0 where it changes at no even distance.
    """
    changes = np.flatnonzero(np.diff(control)) + 1.0
    whole = math.isclose(samples, round(samples), rel_tol=1e-3)
    if not whole:
        changes -= 0.5  # it was somewhere in the step before
    turns = np.exp(2j * np.pi * changes / samples)
    mean = turns.mean() if len(turns) else 0.0
    if abs(mean) < MIN_PHASE_AGREEMENT.value:
        return 0.0
    phase = float(np.angle(mean)) / (2 * np.pi) % 1.0 * samples
    phase = round(phase) % round(samples) if whole else phase
    return phase - samples if phase > 0 else 0.0
