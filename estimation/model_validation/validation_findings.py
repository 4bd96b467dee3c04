"""Findings of the checks of a validation, see `validation_result`."""

from dataclasses import dataclass

from axisid.estimation.diagnostics import DifferingParameter
from axisid.estimation.findings import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class DoubtfulTimeBase(Finding):
    """A time column that contradicts the period of the control law.

    Attributes
    ----------
    reason : str
        Warning on the sampling period, see `LawClock.doubt`.
    """

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownSamples(Finding):
    """Samples of the second record that the estimates were made from.

    Attributes
    ----------
    percent : float
        Share of the samples of the second record, %.
    is_same_record : bool
        True for the estimates' own record, or a part of it.
    """

    percent: float
    is_same_record: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class EquationErrorOnRecord(Finding):
    """Equation errors on the second record, compared with those on the estimates' own records.

    Attributes
    ----------
    failed : tuple of str
        Methods whose error is too large.
    largest_percent : float
        Largest error (rms) relative to the force (rms), minus the part that may be chance in a
        short record, %.
    max_percent, max_ratio : float
        An error is too large if it is above both limits; the ratio is relative to the error on the
        estimate's own record.
    """

    failed: tuple[str, ...]
    largest_percent: float
    max_percent: float
    max_ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationOnRecord(Finding):
    """Errors of the simulated loops on the second record, and on the estimates' own records.

    Attributes
    ----------
    failed : tuple of str
        Methods whose simulated loop has too large an error on the second record.
    by_position : bool
        True if the position error is too large. If it is False and the check failed, only the force
        error is too large.
    tracking_error_percent, own_tracking_error_percent : float or None
        Position error (rms) relative to the tracking error (rms), %, on the second record and on
        the estimate's own records, of the method with the largest error on the second record; None
        if unknown.
    simulation_error_percent, own_simulation_error_percent : float or None
        Force error (rms) relative to the force (rms), %, of the same method; None if unknown.
    """

    failed: tuple[str, ...]
    by_position: bool
    tracking_error_percent: float | None
    own_tracking_error_percent: float | None
    simulation_error_percent: float | None
    own_simulation_error_percent: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReestimatedParameters(Finding):
    """Parameters estimated from the second record, compared with those of the result.

    Attributes
    ----------
    failed : tuple of str
        Methods with different parameters.
    changed : tuple of DifferingParameter
        Different parameters of the method whose difference makes the largest force; `own` is the
        value of the second record and `common` the value of the result.
    largest_percent : float
        Force (rms) that the difference of all parameters makes, relative to the force (rms), %:
        the largest of the methods.
    """

    failed: tuple[str, ...]
    changed: tuple[DifferingParameter, ...]
    largest_percent: float


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatesHold(Finding):
    """Estimates that the second record confirms.

    Attributes
    ----------
    passed : tuple of Finding
        Findings of the checks that passed.
    is_reestimated : bool
        True if the parameters could be estimated from the second record as well.
    """

    passed: tuple[Finding, ...]
    is_reestimated: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatesDoNotHold(Finding):
    """Estimates that the second record contradicts.

    Attributes
    ----------
    failed : tuple of str
        Lines of the verdict of the validation with a failed check.
    """

    failed: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoSimulation(Finding):
    """A closed loop that could not be simulated on the second record.

    Attributes
    ----------
    reason : str
        Reason why the loop could not be simulated.
    """

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplePeriods(Finding):
    """The sample period of the second record and that of the fit's records.

    Attributes
    ----------
    of_record, of_fit : float
        Sampling periods, s.
    are_equal : bool
        True if a record of the fit has the sampling period of the second record.
    """

    of_record: float
    of_fit: float
    are_equal: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputOnRecord(Finding):
    """The simulated output on the second record, compared with that on the fit's own records.

    Attributes
    ----------
    output : str
    percent, own_percent : float
        Error (rms) relative to the recorded output (rms), %, on the second record, and the largest
        of the records of the fit.
    holds : bool
        True if the error on the second record is small, or comparable to that of the fit.
    """

    output: str
    percent: float
    own_percent: float
    holds: bool
