"""Repairs of a log, made on request only; each says what it did and how often."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from typing import Any, Literal

import numpy as np

from axisid.estimation.choices import check_among
from axisid.estimation.records.columns import Mask, expected_units, to_si
from axisid.estimation.tables import Repair
from axisid.estimation.thresholds import MAX_EVEN_STEP, MIN_RECORD_SAMPLES
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, covered
from axisid.support.errors import UsageError, is_real, quoted
from axisid.support.mappings import FrozenMapping

from .clocks import long_steps
from .shifts import Interpolation, checked_between, checked_shifts
from .wrapping import Modulus

Span = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Repairs:
    """What may be done to a log that is not a record as it stands.

    Attributes
    ----------
    resample : float, "auto" or None
        Onto an even grid at so many hertz; ``auto`` takes the position's own median rate.
    gaps : {"split"} or None
        Cut the log where samples are missing; each piece is filtered and simulated by itself.
    wrap : str, float, mapping of str to either, or None
        Modulus of a position that starts again after it, in SI or with a unit (``360:deg``); of
        other columns, by role (``{"control": 65536}``, ``"control=65536"``), whose numbers were
        written without their sign, so that -1 is the modulus less 1.
    mask : {"clipped"} or None
        Leave out what the drive's limit or a recorder has cut off of the control or the force,
        with all rows whose filters reach it.
    tail : {"drop"} or None
        Leave out lines at the end of a log of text that are no rows: one cut off, or a footer.
    shift : mapping of str to int, float or str
        By role, how far a column is moved to later times against the others: samples, or a time
        with its unit (``"2ms"``). What is no whole number of samples needs `resample`.
    between : mapping of str to {"spline", "linear", "held"}
        By role, what a measured velocity, acceleration or force is between its values, where these
        are written in every so many samples, the others empty or the last value again.

    Raises
    ------
    UsageError
        A setting makes no sense for any log.
    """

    resample: float | Literal["auto"] | None = None
    gaps: Literal["split"] | None = None
    wrap: str | float | Mapping[str, str | float] | None = None
    mask: Literal["clipped"] | None = None
    tail: Literal["drop"] | None = None
    shift: Mapping[str, Any] = field(default_factory=dict)
    between: Mapping[str, Interpolation] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rate = self.resample
        if rate not in ("auto", None) and not (is_real(rate) and 0 < rate < math.inf):
            raise UsageError(f"the rate to resample at is {quoted(rate)}; give hertz, or auto.")
        check_among(
            ("repair of gaps", self.gaps or "split", ("split",)),
            ("mask", self.mask or "clipped", ("clipped",)),
            ("repair of the end of the log", self.tail or "drop", ("drop",)),
        )
        if isinstance(self.wrap, Mapping):
            object.__setattr__(self, "wrap", FrozenMapping(self.wrap))
        object.__setattr__(self, "shift", FrozenMapping(checked_shifts(self.shift)))
        object.__setattr__(self, "between", FrozenMapping(checked_between(self.between)))

    def moduli(self, axis: Axis | None) -> dict[str, Modulus]:
        """Moduli by role.

        Raises
        ------
        UsageError
            One is no positive number, in another unit than its column, or of no such column.
        """
        given = self.wrap
        if isinstance(given, str) and "=" in given:
            pairs = (pair.partition("=") for pair in given.split(","))
            given = {role.strip(): modulus for role, _, modulus in pairs}
        elif given is not None and not isinstance(given, Mapping):
            given = {"position": given}
        return {role: _modulus(role, str(text), axis) for role, text in (given or {}).items()}


def _modulus(role: str, text: str, axis: Axis | None) -> Modulus:
    if role in ("time", "reference"):
        raise UsageError(
            f"no modulus is taken out of the {role} alone; the reference follows the position, and "
            "a time that begins again is cut (gaps).",
            code="wrap",
        )
    number, _, unit = text.partition(":")
    size = math.nan
    with suppress(ValueError):
        size = float(number)
    if not 0 < size < math.inf:
        raise UsageError(
            f"the modulus is {text!r}; give a positive number, with a unit where it is not SI, as "
            "in 360:deg or 1:rev."
        )
    usual, si = " or ".join(expected_units(role, axis)), np.array([size])
    if unit:
        si, _ = to_si(role, si, unit, axis, requested=True, source="the modulus")
    return Modulus(si=float(si[0]), factor=float(si[0]) / size, unit=unit.strip() or usual)


def split_at_gaps(time: Array, cuts: Sequence[int]) -> tuple[Mask, list[int], Repair]:
    """Rows to keep, (N,), the lengths of the segments that they make, and what was found.

    Pieces of fewer than 3 rows are left out. The rows `cuts` begin a segment of their own, whatever
    the time before them.
    """
    steps = np.diff(time)
    gaps = np.setdiff1d(long_steps(time, MAX_EVEN_STEP.value), [row - 1 for row in cuts])
    begins = sorted({*(gaps + 1).tolist(), *cuts})
    pieces = [*zip([0, *begins], [*begins, len(time)], strict=True)]
    long = [(a, b) for a, b in pieces if b - a >= MIN_RECORD_SAMPLES.value]
    kept, lengths = covered(long, len(time)), [b - a for a, b in long]
    lost = float(np.sum(steps[gaps] - np.median(steps))) if len(gaps) else 0.0
    repair = gaps_repair(len(gaps), lost, len(lengths), int(np.sum(~kept)))
    return kept, lengths, repair


def adjoining(lengths: Sequence[int]) -> tuple[Span, ...]:
    """Segments of these lengths, one after the other; none where there is one alone."""
    return tuple(pairwise(accumulate(lengths, initial=0))) if len(lengths) > 1 else ()


def gaps_repair(gaps: int, lost: float, segments: int, dropped: int) -> Repair:
    """What is said of a split log."""
    text = (
        f"cut at {gaps} {'gap' if gaps == 1 else 'gaps'} ({lost:.4g} s are missing) into "
        f"{segments} segments, each filtered and simulated by itself"
    )
    if dropped:
        text += f"; {dropped} rows in pieces of fewer than {MIN_RECORD_SAMPLES.value} left out"
    return Repair(kind="gaps", count=gaps, text=text if gaps else "no gaps found")
