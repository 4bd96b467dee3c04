"""Findings of the checks of parameters, see `parameter_checks`."""

import math
from dataclasses import dataclass
from typing import Literal

from axisid.estimation.estimation_problem import ParameterAtBound
from axisid.estimation.findings import Finding
from axisid.estimation.signals import RestingAxis


@dataclass(frozen=True, slots=True, kw_only=True)
class FewRows(Finding):
    """Too few rows for the number of parameters.

    Attributes
    ----------
    rows, parameters : int
        Number of rows and of parameters.
    samples_per_row : int or None
        For a fit: the number of samples that count as one row; None for rows of a regression.
    """

    rows: int
    parameters: int
    samples_per_row: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RelativeError:
    """The relative standard error of a parameter.

    Attributes
    ----------
    name : str
    percent : float or None
        Standard error in percent of the value; None where the value is 0.
    """

    name: str
    percent: float | None


def relative_error(name: str, percent: float) -> RelativeError:
    """Return the relative standard error of a parameter, for a finding."""
    return RelativeError(name=name, percent=finite(percent))


def finite(number: float) -> float | None:
    """Return a number as Python's float; None where it is not finite."""
    return float(number) if math.isfinite(number) else None


#: Reason why a record does not identify a parameter: its column is nearly a combination of others,
#: the parameter acts in few rows, other terms cancel its part of the force, or the residual is
#: larger than its part of the force.
Obscurity = Literal["repeated column", "few rows", "cancelled", "below residual"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Unidentified:
    """Parameters that a record does not identify, for one reason.

    Attributes
    ----------
    parameters : tuple of RelativeError
        The parameters, with their relative standard errors.
    reason : {"repeated column", "few rows", "cancelled", "below residual"}
        Reason, see `Obscurity`.
    alike : tuple of str
        For a repeated column: the parameters whose columns it is nearly a combination of.
    rows : float
        Equivalent number of rows in which the parameters act, see `Excitation`.
    lacking : tuple of str
        Signals that the motion does not excite, as clauses.
    """

    parameters: tuple[RelativeError, ...]
    reason: Obscurity
    alike: tuple[str, ...]
    rows: float
    lacking: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Precision(Finding):
    """Relative standard errors of the parameters of a regression.

    Attributes
    ----------
    largest_percent : float or None
        Largest relative standard error of the parameters that are not negligible; None if all are
        negligible, or one of these has the value 0.
    has_others : bool
        True if there are parameters that are not negligible.
    negligible : tuple of RelativeError
        Imprecise parameters that make less than 1 % of the force, with their relative standard
        errors.
    unidentified : tuple of Unidentified
        Other imprecise parameters, grouped by reason; empty where there are none.
    """

    largest_percent: float | None
    has_others: bool
    negligible: tuple[RelativeError, ...]
    unidentified: tuple[Unidentified, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class OutsideBounds:
    """A parameter that is not within its declared bounds.

    Attributes
    ----------
    name, unit : str
    value, lower, upper : float
        Value and bounds, SI.
    is_at_bound : bool
        Whether the value equals a bound; otherwise the value is beyond the bound.
    """

    name: str
    unit: str
    value: float
    lower: float
    upper: float
    is_at_bound: bool


#: Likely cause to check where a parameter is beyond its bounds: chance, because the 95 % interval
#: reaches within the bounds; a model that lacks terms of other candidates; rests in the rows; wrong
#: signs, units or drive gain; or wrong signs, units or model.
BoundsAdvice = Literal[
    "interval reaches within",
    "other candidates explain more",
    "rests",
    "signs, units and gain",
    "signs, units and model",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class WithinBounds(Finding):
    """Parameters within their declared bounds.

    Attributes
    ----------
    parameters : tuple of str
        Names of the parameters with bounds.
    """

    parameters: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BeyondBounds(Finding):
    """Parameters that are not within their declared bounds.

    Attributes
    ----------
    parameters : tuple of OutsideBounds
    advice : str
        Likely cause to check, see `BoundsAdvice`.
    rest : RestingAxis or None
        Rests of the axis if these are the likely cause; otherwise None.
    """

    parameters: tuple[OutsideBounds, ...]
    advice: BoundsAdvice
    rest: RestingAxis | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedAtBounds(Finding):
    """Parameters that are fixed at their bounds.

    Attributes
    ----------
    parameters : tuple of ParameterAtBound
    distance : float
        Largest distance of an estimate without bounds beyond its bound, in standard errors.
    advice : str or None
        Likely cause to check, see `BoundsAdvice`; None if the distance is within chance.
    rest : RestingAxis or None
        Rests of the axis if these are the likely cause; otherwise None.
    """

    parameters: tuple[ParameterAtBound, ...]
    distance: float
    advice: BoundsAdvice | None
    rest: RestingAxis | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedValue:
    """A value that is known independently of the record.

    Attributes
    ----------
    name, unit : str
    value, standard_error : float
        Fixed value and its standard error, SI; the standard error is 0 for an exact value.
    of_record, standard_error_of_record : float or None
        Estimate from the record alone, and its standard error, SI; None where the record does not
        determine the value.
    """

    name: str
    unit: str
    value: float
    standard_error: float
    of_record: float | None
    standard_error_of_record: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedValues(Finding):
    """Comparison of fixed values with the record, by Hotelling's test of the restrictions.

    Attributes
    ----------
    values : tuple of FixedValue
        The fixed values; empty where only the physical parameters are restricted.
    statistic, restrictions, p_value : float, int, float
        Hotelling's T squared, number of restrictions, and p-value of the test.
    agree : bool
        Whether the p-value is at least the significance level.
    is_bias_known : bool
        Whether the bias by filter and noise is known and corrected.
    """

    values: tuple[FixedValue, ...]
    statistic: float
    restrictions: int
    p_value: float
    agree: bool
    is_bias_known: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FarFromNominal:
    """A value of another order of magnitude than its nominal value.

    Attributes
    ----------
    name, unit : str
    value, nominal : float
        Estimated and nominal value, SI.
    ratio : float
        Value divided by nominal value.
    """

    name: str
    unit: str
    value: float
    nominal: float
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FarFromNominalValues(Finding):
    """Values of another order of magnitude than their nominal values.

    Attributes
    ----------
    parameters : tuple of FarFromNominal
    """

    parameters: tuple[FarFromNominal, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifiedGain(Finding):
    """The identified drive gain and the declared one.

    Attributes
    ----------
    identified, standard_error, declared : float
        Identified gain with its standard error, and declared gain, in `unit`.
    unit : str
    distance : float or None
        Distance between the two gains, in standard errors of their difference; None where the
        standard error is 0.
    agreement : {"same", "near", "far"}
        ``same`` for a distance within three standard errors; otherwise ``far`` for a factor of 2 or
        more, or the opposite sign, and ``near`` for a smaller factor.
    """

    identified: float
    standard_error: float
    declared: float
    unit: str
    distance: float | None
    agreement: Literal["same", "near", "far"]
