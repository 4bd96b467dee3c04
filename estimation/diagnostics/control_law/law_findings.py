"""Findings of the comparison of a recorded control with the declared control law.

Residuals are ``100 ||control - law|| / ||control||``, in percent of the recorded control.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from axisid.estimation.findings import Finding

#: Samples that a law may have read of a record with uneven times: the rows of the record, or its
#: columns interpolated at even times.
Reading = Literal["sampled rows", "even times"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LawReproduced(Finding):
    """A recorded control that the declared control law reproduces.

    Attributes
    ----------
    residual_percent : float
        Residual of the law, percent of the recorded control.
    open_percent : float or None
        Uncertainty of the law's control by values between the samples of the log, percent of the
        recorded control; None for a law that reads the samples.
    """

    residual_percent: float
    open_percent: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundByReading(Finding):
    """Comparison of a law that read other samples than those of the record.

    Attributes
    ----------
    reading : {"sampled rows", "even times"}
        Samples that fit the control best.
    finding : Finding
        Finding of the comparison with these samples.
    recorded_percent : float or None
        Residual with the samples of the record, percent; None where the law fails with both.
    """

    reading: Reading
    finding: Finding
    recorded_percent: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LateControl(Finding):
    """A recorded control that follows the declared law some samples later or earlier.

    Attributes
    ----------
    residual_percent : float
        Residual without the shift, percent of the recorded control.
    samples : int
        Delay of the recorded control relative to the law; negative for an early control.
    is_at_least : bool
        Whether this is the largest shift that was tried.
    is_before_law : bool
        Whether the control comes earlier than any law could compute it.
    blame : {"law or log", "log", "position or reference", "law"}
        Source of the error, which the motion shows: the law, the log of the control, or the log of
        position or reference; "law or log" where the motion was not examined, or does not show the
        source.
    delay : int or None
        Delay to declare for the law, samples; None where no delay of the law explains the control.
    shift : int
        Samples by which to shift the control, or the position or the reference; 0 for a wrong law.
    unknown : str
        Reason why the motion does not show the source; empty where the motion shows it, or was not
        examined.
    """

    residual_percent: float
    samples: int
    is_at_least: bool
    is_before_law: bool
    blame: Literal["law or log", "log", "position or reference", "law"]
    delay: int | None
    shift: int
    unknown: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantOrDrift(Finding):
    """A constant or a drift of the recorded control in addition to the declared law.

    Attributes
    ----------
    residual_percent : float
        Residual of the law, percent of the recorded control.
    constant : float or None
        Constant of the control that the law does not have; None where it is not significant.
    drift : float or None
        Change of the residual over the record; None where it is not significant.
    unit : str
        Unit of both, which is that of the control.
    """

    residual_percent: float
    constant: float | None
    drift: float | None
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherGain:
    """A gain of the law that has another value in the recorded control.

    Attributes
    ----------
    name : str
    value : float
        Value with which the law gives the recorded control.
    declared : float
        Declared value.
    times : float
        Value divided by the declared value.
    """

    name: str
    value: float
    declared: float
    times: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlScale:
    """A factor by which a recorded control is too large.

    Attributes
    ----------
    times : float
        The factor; negative for the opposite sign.
    units : (str, str) or None
        Recorded unit, and the unit that it was taken for; None for a factor that no known pair of
        units has.
    """

    times: float
    units: tuple[str, str] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlDiffers(Finding):
    """Base of findings of a recorded control that differs from the declared law.

    Attributes
    ----------
    residual_percent : float
        Residual of the law, percent of the recorded control.
    is_large : bool
        Whether the residual is beyond its threshold; otherwise only a factor of the law is wrong.
    """

    residual_percent: float
    is_large: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherGains(ControlDiffers):
    """A recorded control that follows the declared law with other gains.

    Attributes
    ----------
    alternatives : tuple of tuple of OtherGain
        Sets of gains that explain the control equally well, the best first.
    has_right_gains : bool
        Whether the law has further gains, which are correct.
    scale : ControlScale or None
        Factor by which the recorded control may be too large instead; None where no factor explains
        the control.
    injected_differs : bool
        Whether the test signal has another size as well.
    """

    alternatives: tuple[tuple[OtherGain, ...], ...]
    has_right_gains: bool
    scale: ControlScale | None = None
    injected_differs: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherScale(ControlDiffers):
    """A recorded control of another scale or of the opposite sign.

    Attributes
    ----------
    scale : ControlScale
        Scale of the recorded control.
    scaled_percent : float
        Residual with the control divided by the scale, percent.
    """

    scale: ControlScale
    scaled_percent: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherInjectedSize(ControlDiffers):
    """A test signal that has another size in the recorded control than in its column."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UnexplainedControl(ControlDiffers):
    """A recorded control that no change of the law's gains explains.

    Attributes
    ----------
    may_be_injected : bool
        Whether the cause may be a test signal that the record does not contain.
    """

    may_be_injected: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LawRepair(Finding):
    """Base of changes of the record, the law or the drive with which the law fits the control.

    `RepairedLaw` contains the change, with the residuals without and with it.
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class ExchangedColumns(LawRepair):
    """Position and reference that are exchanged in the record."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherTestSignal(LawRepair):
    """A test signal that entered the loop in another way than declared.

    Attributes
    ----------
    change : {"added to the control", "added to the reference", "opposite sign", "none"}
        Change with which the law fits the control: another injection point, the opposite sign, or
        no test signal.
    """

    change: Literal["added to the control", "added to the reference", "opposite sign", "none"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaledColumn(LawRepair):
    """A column with another scale than the law read.

    Attributes
    ----------
    role : str
        Role of the column, or the name of a signal.
    times : float
        Factor of the column with which the law gives the recorded control.
    column : str
        Name of the column in the log; ``NAME`` where it is unknown.
    unit : str or None
        Usual unit that explains the factor; None where no unit does.
    """

    role: str
    times: float
    column: str
    unit: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class MovedColumn(LawRepair):
    """A column that is recorded at another time than the law read it.

    Attributes
    ----------
    role : str
        Role of the column, or the name of a signal.
    samples : int
        Shift of the column to later times, with which the law fits; negative for earlier times.
    """

    role: str
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceClock(LawRepair):
    """A reference with time stamps of another clock than that of the position.

    Attributes
    ----------
    rate : float
        Relative amount by which the clock of the reference is fast compared with that of the
        position; negative for slow.
    """

    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MovedZero(LawRepair):
    """A position that is recorded from another zero than the reference.

    Attributes
    ----------
    position : float
        Amount by which the recorded position is too large.
    unit : str
        Unit of the position.
    column : str
        Name of the position in the log; ``NAME`` where it is unknown.
    control : float or None
        Constant of the control with the same effect; None for a law that integrates.
    control_unit : str
    exceeds_limit : bool
        Whether this constant exceeds the limit of the drive.
    """

    position: float
    unit: str
    column: str
    control: float | None
    control_unit: str
    exceeds_limit: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherVelocity(LawRepair):
    """A law that computes the velocity in another way than the declared law.

    Attributes
    ----------
    law : str
        Name of the law of the library with that velocity and the same gains.
    """

    law: str


@dataclass(frozen=True, slots=True, kw_only=True)
class UndeclaredLimit(LawRepair):
    """A limit of the drive that is below the declared one.

    Attributes
    ----------
    limit : float
        Limit that the recorded control shows, in `unit`.
    unit : str
        Unit of the limit: that of the drive.
    samples : int
        Number of samples in which the output of the law exceeds this limit.
    """

    limit: float
    unit: str
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RepairedLaw(Finding):
    """A change of the record or of the law with which the law reproduces the recorded control.

    Attributes
    ----------
    residual_percent : float
        Residual without the change, percent of the recorded control.
    repaired_percent : float
        Residual with the change, percent of the recorded control.
    repair : LawRepair
        The change.
    """

    residual_percent: float
    repaired_percent: float
    repair: LawRepair


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundGainsAgree(Finding):
    """Gains that fit the recorded control and agree with the gains that a fit has found.

    Attributes
    ----------
    finding : Finding
        Finding of the comparison of the law with the gains that fit the control.
    gains : mapping of str to float
        Gains that fit the control, by name.
    standard_errors : float
        Joint distance from the gains of the fit, in standard errors.
    """

    finding: Finding
    gains: Mapping[str, float]
    standard_errors: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundGainsDiffer(Finding):
    """Gains that fit the recorded control and differ from the gains that a fit has found.

    Attributes
    ----------
    residual_percent : float or None
        Residual of the law with the gains that fit the control, percent of the recorded control;
        None where it is not known.
    gains : mapping of str to float
        Gains that fit the control, by name.
    found : mapping of str to float
        Gains of the fit, by name.
    standard_errors : float
        Joint distance between both sets of gains, in standard errors.
    """

    residual_percent: float | None
    gains: Mapping[str, float]
    found: Mapping[str, float]
    standard_errors: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LawOfSecondRecord(Finding):
    """A second record whose control does not follow the law of a result.

    Attributes
    ----------
    result : {"estimates", "fit"}
        Kind of the result: estimates of identify, or a fit.
    finding : Finding
        Finding of the comparison of the control of the second record with the law.
    """

    result: Literal["estimates", "fit"]
    finding: Finding
