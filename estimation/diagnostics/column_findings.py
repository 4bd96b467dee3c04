"""Findings of the checks of `column_comparison`."""

from dataclasses import dataclass
from typing import Literal

from axisid.estimation.findings import Finding
from axisid.estimation.records import AdvisedShift
from axisid.support.arrays import MaybeNan


@dataclass(frozen=True, slots=True, kw_only=True)
class GainOfForce:
    """Declared drive gain, and the gain that fits the recorded force.

    Attributes
    ----------
    declared : float
    fitting : float
        Gain with which the force from the control equals the recorded force.
    unit : str
    """

    declared: float
    fitting: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceAgainstControl(Finding):
    """Comparison of the recorded force with the force that the drive makes of the control.

    Attributes
    ----------
    fault : {"scale", "offset", "other"} or None
        Kind of the difference: ``scale`` for a factor, ``offset`` for a constant alone, ``other``
        for a late force or a larger difference; None where the forces agree.
    difference_percent : float
        Root mean square of the difference, in percent of the force from the control, at low
        frequencies.
    factor : float
        Recorded force over the force from the control.
    factor_uncertainty : float
        Half the range of the factor that noise and the unexplained part allow.
    offset : float
        Constant of the recorded force relative to the force from the control, in `force_unit`.
    offset_uncertainty : float
        Uncertainty of the constant by noise and the unexplained part, in `force_unit`.
    lag : float
        Lag of the recorded force behind the force from the control, s.
    force_unit : str
    drive : str
        Force of the declared drive, as a text: ``35.15 N/V times the control``.
    gain : GainOfForce or None
        Declared gain and the gain that fits; None for a drive that is more than a gain.
    """

    fault: Literal["scale", "offset", "other"] | None
    difference_percent: float
    factor: MaybeNan
    factor_uncertainty: MaybeNan
    offset: MaybeNan
    offset_uncertainty: MaybeNan
    lag: MaybeNan
    force_unit: str
    drive: str
    gain: GainOfForce | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlAgainstLimit(Finding):
    """Samples of the recorded control beyond the limit of the drive.

    Attributes
    ----------
    is_beyond : bool
        Whether too many samples are beyond the limit.
    share_percent : float
        Samples beyond the limit, in percent of all samples.
    excess_percent : float
        Distance beyond the limit, percent of the limit, above which a sample counts.
    limit : float
        Limit of the drive, in `unit`.
    largest : float
        Largest size of the control, in `unit`.
    unit : str
    has_force : bool
        Whether the force is recorded too, so that only the simulated loop uses the control.
    """

    is_beyond: bool
    share_percent: float
    excess_percent: float
    limit: float
    largest: float
    unit: str
    has_force: bool


#: Signal with which a measured velocity or acceleration is compared.
MotionReference = Literal[
    "velocity of the simulated loop",
    "derivative of the position",
    "second derivative of the position",
    "derivative of the measured velocity",
]
#: Property in which a measured column differs from the signal that it is compared with.
ColumnFault = Literal["delay", "factor", "offset"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnCorrections:
    """Corrections of a measured velocity or acceleration.

    Attributes
    ----------
    column : str
        Name of the column in the log; ``NAME`` where it is not known.
    faults : tuple of {"delay", "factor", "offset"}
        Properties of the column that are wrong, in the order in which to correct them.
    shift : AdvisedShift or None
        Shift of the column that corrects its delay. None without a delay, and for a column that
        holds each value for several samples, which has to be interpolated instead.
    likely_unit : str or None
        Usual unit that explains the factor; None where no unit does, or the factor is correct.
    is_reversed : bool
        Whether the opposite sign explains the factor.
    scale_reference : {"position", "reference"}
        Column whose unit and scale may be wrong instead.
    """

    column: str
    faults: tuple[ColumnFault, ...]
    shift: AdvisedShift | None
    likely_unit: str | None
    is_reversed: bool
    scale_reference: Literal["position", "reference"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredMotion(Finding):
    """Comparison of a measured velocity or acceleration with a computed one.

    Attributes
    ----------
    role : str
        ``velocity`` or ``acceleration``.
    reference : str
        Name of the computed signal.
    is_other_signal : bool
        Whether the part that factor, delay and constant do not explain exceeds its tolerance.
    is_wrong : bool
        Whether this part, the factor, the delay or the constant exceeds its tolerance.
    worst : float
        Largest distance of the factor from 1, of the delay, the constant and the unexplained part
        from 0, each relative to its tolerance.
    worst_of : {"factor", "delay", "offset", "unexplained part"}
        Property with this largest distance.
    unexplained_percent : float
        Root mean square of the unexplained part, percent of the computed signal.
    factor, factor_uncertainty : float
        Measured divided by computed signal.
    delay, delay_uncertainty : float
        Delay of the measured column, samples; negative for an early column.
    offset, offset_uncertainty : float
        Constant of the measured column relative to the computed one, in `unit`.
    unit : str
        Unit of the column in the model.
    corrections : ColumnCorrections
    """

    role: str
    reference: MotionReference
    is_other_signal: bool
    is_wrong: bool
    worst: MaybeNan
    worst_of: Literal["factor", "delay", "offset", "unexplained part"]
    unexplained_percent: MaybeNan
    factor: MaybeNan
    factor_uncertainty: MaybeNan
    delay: MaybeNan
    delay_uncertainty: MaybeNan
    offset: MaybeNan
    offset_uncertainty: MaybeNan
    unit: str
    corrections: ColumnCorrections
