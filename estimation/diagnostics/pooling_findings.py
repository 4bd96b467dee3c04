"""Findings of the check that compares several records, see `pooling`."""

from dataclasses import dataclass

from axisid.estimation.findings import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferingParameter:
    """A parameter that differs between a record and the other records.

    Attributes
    ----------
    name : str
    own : float
        Estimate from the record alone, SI.
    common : float
        Estimate from the other records, SI.
    standard_error : float
        Standard error of the difference, SI.
    unit : str
    is_load : bool
        Whether the parameter is a mass or an inertia, which another load changes.
    """

    name: str
    own: float
    common: float
    standard_error: float
    unit: str
    is_load: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OddRecord:
    """The record that differs most from the others.

    Attributes
    ----------
    name : str
        Name of the record.
    other : str or None
        Name of the other record if there are two records; None if there are more.
    parameters : tuple of DifferingParameter
        Parameters that differ significantly.
    matters : bool
        Whether the effect of the difference on the output is relevant, so that the check fails.
    """

    name: str
    other: str | None
    parameters: tuple[DifferingParameter, ...]
    matters: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class UnidentifiedInRecord:
    """Parameters that a record alone does not identify.

    Attributes
    ----------
    record : str
        Name of the record.
    parameters : tuple of str
        Names of the parameters; empty where the record cannot be compared at all.
    """

    record: str
    parameters: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedRecords(Finding):
    """Comparison of each record with the others.

    Attributes
    ----------
    odd : OddRecord or None
        The record that differs most; None where all records agree within chance.
    largest_percent : float
        Largest effect of the difference between the parameters of a record alone and those of the
        other records, in percent of the output of the record (rms).
    least_percent : float
        Effect in percent of the output, above which a significant difference fails the check.
    output : str
        ``force``, or ``output`` for a fit.
    unidentified : tuple of UnidentifiedInRecord
    """

    odd: OddRecord | None
    largest_percent: float
    least_percent: float
    output: str
    unidentified: tuple[UnidentifiedInRecord, ...]
