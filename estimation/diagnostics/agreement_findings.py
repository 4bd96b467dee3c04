"""Findings of the checks of `agreement_of_estimates`."""

from dataclasses import dataclass

from axisid.estimation.findings import Finding
from axisid.support.arrays import MaybeNan


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterDifference:
    """Difference of a parameter between two estimates.

    Attributes
    ----------
    name : str
    difference : float
        Estimate of the first method minus that of the second, in `unit`.
    unit : str
    percent : float or None
        The difference in percent of the second estimate; None where that is 0.
    standard_errors : float
        Size of the difference, in standard errors of the second estimate.
    """

    name: str
    difference: float
    unit: str
    percent: float | None
    standard_errors: float


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateComparison:
    """Differences between the estimates of two methods.

    Attributes
    ----------
    first, second : str
        Names of the two methods.
    differences : tuple of ParameterDifference
        Significant differences; empty where the methods agree within chance.
    largest : ParameterDifference
        The largest significant difference, in standard errors; the largest of all differences if
        none is significant.
    p_value : float
        P-value of a test of all differences at once.
    is_large : bool
        Whether a significant difference is larger than the half widths of both confidence intervals
        and than `Levels.least_share` of the value.
    """

    first: str
    second: str
    differences: tuple[ParameterDifference, ...]
    largest: ParameterDifference
    p_value: MaybeNan
    is_large: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentsAgainstOutputError(Finding):
    """Comparison of IDM-IV with DIDIM.

    Attributes
    ----------
    comparison : EstimateComparison
    reported : str
        Method of the two whose estimate is reported.
    law_passed : bool or None
        Whether the recorded control follows the declared control law; None where this could not be
        checked.
    less_precise : tuple of str
        Parameters with a significant difference and a larger standard error by DIDIM.
    """

    comparison: EstimateComparison
    reported: str
    law_passed: bool | None
    less_precise: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LeastSquaresAgainstInstruments(Finding):
    """Comparison of least squares with instrumental variables, for the same form of the model.

    Attributes
    ----------
    comparison : EstimateComparison
    """

    comparison: EstimateComparison


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectAgainstInverse(Finding):
    """Comparison of least squares of the direct model with least squares of the inverse model.

    Attributes
    ----------
    comparison : EstimateComparison
    """

    comparison: EstimateComparison


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterBias:
    """Bias of the estimate of a parameter.

    Attributes
    ----------
    name : str
    bias : float
        In `unit`.
    unit : str
    standard_errors : float
        Size of the bias, in standard errors of the estimate.
    """

    name: str
    bias: float
    unit: str
    standard_errors: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseBias(Finding):
    """Bias of least squares by noise, found with simulated replicas of the record.

    Attributes
    ----------
    method : str
    biases : tuple of ParameterBias
        Biases beyond the threshold.
    largest : float
        Largest bias, in standard errors.
    most : float
        Threshold, in standard errors.
    instruments : str
        Method that estimates the same form of the model by instruments; empty if there is none.
    """

    method: str
    biases: tuple[ParameterBias, ...]
    largest: float
    most: float
    instruments: str


@dataclass(frozen=True, slots=True, kw_only=True)
class QuantisationBias(Finding):
    """Bias of least squares by the steps of the logged position.

    Attributes
    ----------
    method : str
    biases : tuple of ParameterBias
        Biases beyond the threshold; empty where the bias is unknown.
    largest : float or None
        Largest bias, in standard errors; None where it is unknown.
    most : float
        Threshold, in standard errors.
    fewest_steps : int or None
        Number of steps of the position that the motion needs, if it has fewer and the bias is
        therefore unknown; None where the bias is known.
    """

    method: str
    biases: tuple[ParameterBias, ...]
    largest: float | None
    most: float
    fewest_steps: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AgreementOfEstimates(Finding):
    """Findings of the comparison with other methods and of the bias of the reported estimate.

    Attributes
    ----------
    reported : str
        Method whose estimate is reported.
    findings : tuple of Finding
        Findings of the comparisons with the worst status, which is the status of the check.
    all_pass : bool
        Whether all comparisons pass.
    """

    reported: str
    findings: tuple[Finding, ...]
    all_pass: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class WeakestInstrument(Finding):
    """Column of the regressor that the instruments explain least.

    Attributes
    ----------
    column : str
        Parameter of the column.
    conditional_f : float or None
        First-stage F statistic, conditional on the other columns; None where it is not finite, as
        for a column that the instruments explain exactly.
    least_f : float
        Threshold of the F statistic.
    is_strong : bool
        Whether the F statistic reaches the threshold.
    """

    column: str
    conditional_f: float | None
    least_f: float
    is_strong: bool
