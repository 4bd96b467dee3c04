"""Findings of the search for a misspecification: numbers, names, units and the advised settings.

A `Misspecification` is the result of the search. Its finding adds those data of the axis and of the
record that a sentence needs: units, times, and the advised setting of the drive or of the log.
"""

import math
from dataclasses import dataclass
from typing import Literal

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.findings import Finding
from axisid.estimation.records import AdvisedShift, Record, shift_into_time
from axisid.estimation.records.columns import likely_unit
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE

from .hypotheses import GAIN
from .search import Misspecification
from .terms import TERMS

_RIGID = 3.0  # factor below an antiresonance, up to which an axis moves as a rigid body
_MIN_SHIFT_ERROR = 0.5  # least uncertainty of an advised shift, samples
_MIN_UNIT_ERROR = 0.02  # relative difference of a factor from that of another unit


@dataclass(frozen=True, slots=True, kw_only=True)
class ShareOfForce:
    """Part of the force by a misspecification, root mean square, in percent of the force.

    Attributes
    ----------
    percent : float
        Whole part; above 100 if the parameters of the model cancel it.
    beyond_percent : float
        Part that the parameters of the model do not explain. This is compared with the threshold.
    """

    percent: float
    beyond_percent: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateTerm:
    """A force that the model may lack, at its place, and the numbers to declare it with.

    Attributes
    ----------
    kind : str
        Name of the term in `TERMS`.
    at : float or None
        Place of the term: speed, period, frequency or force, in the unit of its kind; None for a
        term without a place.
    cutoff : float or None
        For an antiresonance: the highest frequency at which a rigid model is valid, Hz; None for
        other terms.
    dead_band : float or None
        For a dead band: the dead band of the drive to declare, in the drive's unit; None for other
        terms.
    limit : float or None
        For saturation: the limit of the drive to declare, in the drive's unit; None for other
        terms.
    is_declared : bool
        True for a Stribeck term if the axis already has a Stribeck element, with another fixed
        velocity or exponent.
    what, declare : str
        Texts of a user's own term, see `Term`; empty for a built-in term.
    """

    kind: str
    at: float | None = None
    cutoff: float | None = None
    dead_band: float | None = None
    limit: float | None = None
    is_declared: bool = False
    what: str = ""
    declare: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingTerm(Finding):
    """A force of the motion that the model lacks.

    Attributes
    ----------
    term : CandidateTerm
    size : float
        Factor of the term's column, or norm of the factors of several columns; in `unit`.
    standard_error : float
        Standard error of the size.
    unit : str
        Unit of the size; empty for a term whose size is not reported.
    share : ShareOfForce
    coordinate, coordinate_unit, force_unit, drive_unit : str
        Name of the coordinate, and units of the axis.
    others : tuple of CandidateTerm
        Terms that explain nearly as much of the force.
    """

    term: CandidateTerm
    size: float
    standard_error: float
    unit: str
    share: ShareOfForce
    coordinate: str
    coordinate_unit: str
    force_unit: str
    drive_unit: str
    others: tuple[CandidateTerm, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangedParameter(Finding):
    """A parameter with another value than the given one, or whose value changes in the record.

    Attributes
    ----------
    parameter : str
        Name of the parameter; `GAIN` for the gain of the drive.
    is_gain : bool
        True for the gain of the drive, which changes by a factor.
    change : {"held", "drift", "step"}
        ``held`` for a wrong given value, ``drift`` for a slow change over the record, ``step`` for
        a change at one time.
    size : float
        Change, in `unit`; for a given value the estimated value minus the given value.
    standard_error : float
        Standard error of the size.
    unit : str
    percent : float or None
        Change in percent of the value before the change; None for a given value.
    share : ShareOfForce
        Part of the force that the change explains.
    seconds : float or None
        Time of a step after the first row, s; None for other changes.
    """

    parameter: str
    is_gain: bool
    change: Literal["held", "drift", "step"]
    size: float
    standard_error: float
    unit: str
    percent: float | None
    share: ShareOfForce
    seconds: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LateSignal(Finding):
    """A recorded signal that is late or early relative to its force.

    Attributes
    ----------
    signal : str
    samples : float
        Delay; negative for an early signal.
    standard_error : float
        Standard error of the delay, samples.
    seconds : float
        The delay, s.
    share : ShareOfForce
        Part of the force that the delay explains.
    at_the_end : bool
        True if the delay is at the end of the searched range; the true delay is then not known.
    shift : AdvisedShift or None
        Shift of the column that corrects the delay; None at the end of the range.
    """

    signal: str
    samples: float
    standard_error: float
    seconds: float
    share: ShareOfForce
    at_the_end: bool
    shift: AdvisedShift | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaledSignal(Finding):
    """A recorded signal with another scale than its force needs.

    Attributes
    ----------
    signal : str
    factor : float
        Factor by which the recorded values have to be multiplied.
    standard_error : float
        Standard error of the factor.
    share : ShareOfForce
        Part of the force that the factor explains.
    column : str or None
        Name of the signal's column in the log; None if the record does not have the name.
    likely_unit : str or None
        Usual unit of the signal that explains the factor; None if no unit explains it.
    """

    signal: str
    factor: float
    standard_error: float
    share: ShareOfForce
    column: str | None
    likely_unit: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class OutlyingSample(Finding):
    """A single sample of a measured column that does not fit the samples around it.

    Attributes
    ----------
    role : str
        Role of the column.
    size : float
        Distance of the sample from its expected value, in `unit`.
    standard_error : float
        Standard error of the size.
    unit : str
    sample : int
        Number of the sample; the first of the record is 1.
    seconds : float
        Time after the first sample, s.
    share : ShareOfForce
    """

    role: str
    size: float
    standard_error: float
    unit: str
    sample: int
    seconds: float
    share: ShareOfForce


def misspecification_finding(
    lack: Misspecification, axis: GeneratedAxis, record: Record
) -> MissingTerm | ChangedParameter | LateSignal | ScaledSignal | OutlyingSample:
    """Return the finding of a misspecification, with the units and the advised numbers.

    Parameters
    ----------
    lack : Misspecification
    axis : GeneratedAxis
    record : Record
        Record with the misspecification; not used for a missing term.
    """
    if lack.is_term:
        return _missing_term(lack, axis)
    if lack.kind == "late signal":
        return _late_signal(lack, record)
    if lack.kind == "scaled signal":
        return _scaled_signal(lack, axis, record)
    if lack.kind == "outlier":
        return _outlying_sample(lack, record)
    return _changed_parameter(lack)


def _share(lack: Misspecification) -> ShareOfForce:
    """Return the part of the force by a misspecification, in percent."""
    return ShareOfForce(percent=100 * lack.share, beyond_percent=100 * lack.own_share)


def _missing_term(lack: Misspecification, axis: GeneratedAxis) -> MissingTerm:
    """Return the finding of a missing term, with other terms that explain nearly as much."""
    coordinate = axis.coordinate
    others = [_candidate(kind, at, axis) for kind, at in lack.others]
    return MissingTerm(
        term=_candidate(lack.kind, lack.at, axis, lack.size),
        size=lack.size,
        standard_error=lack.deviation,
        unit=lack.unit,
        share=_share(lack),
        coordinate=coordinate.name,
        coordinate_unit=coordinate.unit,
        force_unit=str(coordinate.force_unit),
        drive_unit=axis.drive.unit,
        others=tuple(others),
    )


def _candidate(
    kind: str, at: float, axis: GeneratedAxis, size: float | None = None
) -> CandidateTerm:
    """Return a term of `TERMS` with its place and the numbers to declare it with.

    Parameters
    ----------
    kind : str
        Name of the term.
    at : float
        Place of the term: speed, period, frequency or force; NaN for none.
    axis : GeneratedAxis
    size : float or None
        Factor of the term's column, which is the force of a dead band; None if it is not known.
    """
    drive, term = axis.drive, TERMS[kind]
    what, declare = term.what, term.declare
    if term.opposite is not None and size is not None and size < 0:
        what, declare = term.opposite
    dead_band = None
    if kind == "dead band" and size is not None:
        dead_band = drive.deadband + size / abs(drive.gain)
    return CandidateTerm(
        kind=kind,
        at=at if math.isfinite(at) else None,
        cutoff=at / _RIGID if kind == "resonance" else None,
        dead_band=dead_band,
        limit=at / abs(drive.gain) if kind == "saturation" else None,
        is_declared=kind == "stribeck" and axis.has_stribeck,
        what=what,
        declare=declare,
    )


def _changed_parameter(lack: Misspecification) -> ChangedParameter:
    """Return the finding of a parameter that changes in the record or has a wrong given value."""
    changes: dict[str, Literal["held", "drift", "step"]] = {"held": "held", "drift": "drift"}
    return ChangedParameter(
        parameter=lack.parameter,
        is_gain=lack.parameter == GAIN,
        change=changes.get(lack.kind, "step"),
        size=lack.size,
        standard_error=lack.deviation,
        unit=lack.unit,
        percent=100 * lack.size / lack.before if lack.before else None,
        share=_share(lack),
        seconds=lack.at if math.isfinite(lack.at) else None,
    )


def _late_signal(lack: Misspecification, record: Record) -> LateSignal:
    """Return the finding of a late or early recorded signal, with the advised shift."""
    shift = None
    if not lack.at_the_end:
        apart = max(MIN_DISTANCE_FROM_NOISE.value * lack.deviation, _MIN_SHIFT_ERROR)
        shift = shift_into_time(lack.parameter, lack.size, apart)
    return LateSignal(
        signal=lack.parameter,
        samples=lack.size,
        standard_error=lack.deviation,
        seconds=lack.size * record.period,
        share=_share(lack),
        at_the_end=lack.at_the_end,
        shift=shift,
    )


def _scaled_signal(lack: Misspecification, axis: GeneratedAxis, record: Record) -> ScaledSignal:
    """Return the finding of a signal with a wrong scale, with the unit that explains it."""
    factor = lack.size
    (declared,) = (each for each in axis.signals if each.name == lack.parameter)
    vague = _MIN_UNIT_ERROR + MIN_DISTANCE_FROM_NOISE.value * lack.deviation / abs(factor)
    return ScaledSignal(
        signal=lack.parameter,
        factor=factor,
        standard_error=lack.deviation,
        share=_share(lack),
        column=record.provenance.columns.get(lack.parameter),
        likely_unit=likely_unit(str(declared.unit), 1 / factor, vague),
    )


def _outlying_sample(lack: Misspecification, record: Record) -> OutlyingSample:
    """Return the finding of an outlier, with the number and the time of its sample."""
    sample = int(lack.at)
    return OutlyingSample(
        role=lack.parameter,
        size=lack.size,
        standard_error=lack.deviation,
        unit=lack.unit,
        sample=sample + 1,
        seconds=float(record.time[sample] - record.time[0]),
        share=_share(lack),
    )
