"""Findings of the checks of a fit, see `checks_of_fit`."""

from dataclasses import dataclass
from typing import Literal

from axisid.estimation.diagnostics import RelativeError
from axisid.estimation.findings import Finding

from .covariance import UnseenDirection


@dataclass(frozen=True, slots=True, kw_only=True)
class LawCorrection:
    """Correction of the declared law, if the recorded control does not follow it.

    Attributes
    ----------
    term : str or None
        Term of the law that changes the parameter most; None if no gain is the cause.
    factor : float or None
        Value of that term in the record, relative to the declared value; None without a term.
    follows_position_alone : bool
        True if the position is the only fitted output.
    """

    term: str | None
    factor: float | None
    follows_position_alone: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MovedByLaw(Finding):
    """The parameter that a difference between law and recorded control changes most.

    Attributes
    ----------
    differences : tuple of str
        Kind of the difference, as in `Explanation`.
    parameter : str
    percent : float or None
        Change relative to the value, %; None for a value of 0.
    distance : float
        Change in standard errors.
    correction : LawCorrection or None
        Correction of the declared law; None if nothing has to be corrected.
    """

    differences: tuple[str, ...]
    parameter: str
    percent: float | None
    distance: float
    correction: LawCorrection | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LawSensitivity(Finding):
    """Sensitivity of the parameters to an error of the declared law.

    Attributes
    ----------
    term : str
        The term of the law to which a parameter is most sensitive.
    parameter : str
    percent : float
        Change of the parameter by an error of 1 % of the term, relative to its value, %.
    is_large : bool
        True if the estimates need an exact law.
    """

    term: str
    parameter: str
    percent: float
    is_large: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class EndOfSearch(Finding):
    """The end of the search for the parameters.

    Attributes
    ----------
    steps : int
        Number of steps of the search.
    state : {"interrupted", "converged", "not converged"}
        Reason why the search ended.
    """

    steps: int
    state: Literal["interrupted", "converged", "not converged"]


@dataclass(frozen=True, slots=True, kw_only=True)
class EndsOfSearches(Finding):
    """Number of searches from several starts that end at the lowest minimum.

    Attributes
    ----------
    at_best, searches : int
        Number of searches at the lowest minimum, and of all searches.
    """

    at_best: int
    searches: int


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenLoopWindows(Finding):
    """Length and number of the windows of an open loop.

    Attributes
    ----------
    horizon : float
        Length of a window, s.
    steady_horizon : float
        Longest window in which errors do not grow by more than `max_growth`, s.
    max_growth : float
        Limit of the displacement by an initial velocity, relative to that of a free axis.
    windows, advised_windows : int
        Number of windows, and the smallest advised number.
    state : {"good", "few", "growing"}
        ``few`` windows, or ``growing`` errors in them.
    """

    horizon: float
    steady_horizon: float
    max_growth: float
    windows: int
    advised_windows: int
    state: Literal["good", "few", "growing"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedOutput(Finding):
    """The simulated output compared with the recorded one, for the largest error.

    Attributes
    ----------
    output : str
    percent : float or None
        Error (rms) relative to the recorded output (rms), %; None for an output of 0.
    percent_beyond_noise : float or None
        The same error without the part that noise explains; None for an output of 0.
    follows : bool
        True if the simulated output follows the recorded one.
    """

    output: str
    percent: float | None
    percent_beyond_noise: float | None
    follows: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherCauseOfMissingTerms(Finding):
    """Another failed check that explains apparent missing terms.

    Attributes
    ----------
    bounds : tuple of str
        Parameters whose bounds the record contradicts; empty if the control law is the cause.
    """

    bounds: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplesNearRests(Finding):
    """Samples near a standstill or a velocity reversal.

    Attributes
    ----------
    percent_left_out : float
        Share of the samples that are left out, %; 0 if they are kept because the other samples
        hardly show a parameter.
    """

    percent_left_out: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PriorAndRecord(Finding):
    """Prior value and estimate of the parameter for which they differ most.

    Attributes
    ----------
    parameter, unit : str
    prior, standard_error : float
        Prior value with its standard error, SI.
    of_record, standard_error_of_record : float or None
        Estimate from the records alone with its standard error, SI; None if it is unknown.
    distance : float
        Distance of the prior value from the estimate, in standard errors.
    agree : bool
        True if the distance is within the limit.
    """

    parameter: str
    unit: str
    prior: float
    standard_error: float
    of_record: float | None
    standard_error_of_record: float | None
    distance: float
    agree: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownParameters(Finding):
    """Parameters that the outputs of a fit show.

    Attributes
    ----------
    outputs : tuple of str
    unseen : tuple of UnseenDirection
        Empty if the outputs show every parameter.
    """

    outputs: tuple[str, ...]
    unseen: tuple[UnseenDirection, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FitPrecision(Finding):
    """Relative standard errors of the parameters of a fit.

    Attributes
    ----------
    largest_percent : float or None
        Largest relative standard error of the parameters that are not negligible, %; None if such a
        parameter has a value of 0, or if there is no such parameter.
    has_others : bool
        True if there are parameters that are not negligible.
    negligible : tuple of RelativeError
        Parameters that cannot be distinguished from 0 and change the output by less than 1 % of the
        largest change by a parameter.
    unidentified : tuple of RelativeError
        Parameters with a large standard error that are not negligible.
    """

    largest_percent: float | None
    has_others: bool
    negligible: tuple[RelativeError, ...]
    unidentified: tuple[RelativeError, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoParameterAtBound(Finding):
    """No parameter of a fit is at a bound."""
