"""Findings of the checks of a fit, see `checks_of_fit`."""

from dataclasses import dataclass
from typing import Literal

from axisid.estimation.diagnostics import RelativeError
from axisid.estimation.findings import Finding

from .covariance import UnseenDirection


@dataclass(frozen=True, slots=True, kw_only=True)
class LawCorrection:
    """What has to be corrected where the recorded control does not follow the declared law.

    Attributes
    ----------
    term : str or None
        The term of the law that moves the parameter most; None where no gain is the cause.
    factor : float or None
        Of that term in the record, over the declared one.
    follows_position_alone : bool
        Whether the fit follows the position and nothing else.
    """

    term: str | None
    factor: float | None
    follows_position_alone: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MovedByLaw(Finding):
    """The parameter that a difference between law and recorded control moves most.

    Attributes
    ----------
    differences : tuple of str
        What differs, as the `kind` of an `Explanation`.
    parameter : str
    percent : float or None
        Of its value by which it moves; None where that is 0.
    distance : float
        By which it moves, in standard errors.
    correction : LawCorrection or None
        None where nothing has to be corrected.
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
        Of its value by which it moves where the term is 1 % wrong.
    is_large : bool
        Whether the parameters depend on an exact law.
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
    state : {"interrupted", "converged", "not converged"}
    """

    steps: int
    state: Literal["interrupted", "converged", "not converged"]


@dataclass(frozen=True, slots=True, kw_only=True)
class EndsOfSearches(Finding):
    """Searches from several starts that end at the best minimum.

    Attributes
    ----------
    at_best, searches : int
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
        The longest one in which errors do not grow by more than `max_growth`, s.
    max_growth : float
    windows, advised_windows : int
    state : {"good", "few", "growing"}
        Few windows, or errors that grow in them.
    """

    horizon: float
    steady_horizon: float
    max_growth: float
    windows: int
    advised_windows: int
    state: Literal["good", "few", "growing"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedOutput(Finding):
    """The simulated output compared with the recorded one, where it is worst.

    Attributes
    ----------
    output : str
    percent : float or None
        Error (rms) of the recorded output (rms), %; None where that is 0.
    percent_beyond_noise : float or None
        The same without the part that noise explains.
    follows : bool
        Whether the simulated output follows the recorded one.
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
        Parameters whose bounds the record contradicts; empty where the control law is the cause.
    """

    bounds: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplesNearRests(Finding):
    """Samples near a standstill or a velocity reversal.

    Attributes
    ----------
    percent_left_out : float
        Of the samples; 0 where they have weight because a parameter is hardly shown without them.
    """

    percent_left_out: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PriorAndRecord(Finding):
    """The prior value of a parameter that is farthest from the record.

    Attributes
    ----------
    parameter, unit : str
    prior, standard_error : float
        SI.
    of_record, standard_error_of_record : float or None
        As estimated from the records alone, SI; None where that is unknown.
    distance : float
        Of the prior from the record, in standard errors.
    agree : bool
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
        Empty where the outputs show every parameter.
    """

    outputs: tuple[str, ...]
    unseen: tuple[UnseenDirection, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FitPrecision(Finding):
    """Relative standard errors of the parameters of a fit.

    Attributes
    ----------
    largest_percent : float or None
        The largest of those that have to be small; None where one of a value of 0 is among them.
    negligible : tuple of RelativeError
        Parameters that cannot be distinguished from 0 and change the output by less than 1 % of the
        largest change by a parameter.
    unidentified : tuple of RelativeError
    """

    largest_percent: float | None
    negligible: tuple[RelativeError, ...]
    unidentified: tuple[RelativeError, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoParameterAtBound(Finding):
    """No parameter of a fit is at a bound."""
