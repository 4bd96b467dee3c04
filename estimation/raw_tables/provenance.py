"""Provenance of a record: its source, its clock and its repairs."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """One repair of a record.

    Attributes
    ----------
    kind : str
    count : int
        How often it was made: lines or samples left out, samples moved, jumps undone, samples
        masked, rows made, values drawn between others, gaps.
    text : str
        The same for the user, with the method.
    """

    kind: Literal[
        "tail",
        "wrap",
        "clipped",
        "empty",
        "clock",
        "resample",
        "gaps",
        "shift",
        "window",
        "between",
        "wild",
    ]
    count: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodSource:
    """Whose word the sampling period of a record is.

    Attributes
    ----------
    step : float
        Sampling period of the log itself, in periods of the record: 1 unless it was resampled.
    uncertainty : float
        Relative, of that: what jitter and lost samples leave open.
    counted : bool
        The log has no times: its samples were counted by the period that was given.
    stated : bool
        The user gave the log's period, beside its times or in place of them.
    """

    step: float = 1.0
    uncertainty: float = 0.0
    counted: bool = False
    stated: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Source of a record, with assumptions and repairs.

    Attributes
    ----------
    source : str
        File name, or how the record was made.
    sha256 : str
        Of the file, or of the files of a folder in the order of their names: of the very bytes that
        were used. Empty if there is none.
    given, path : str
        The file as it was named, and absolute; empty if there is none.
    columns : dict of str to str
        Column name by role.
    truth : dict of str to float
        Parameters of a simulated record, SI; empty for a measured one.
    assumed : tuple of str
        What was taken of the file: separator, encoding, units and their conversion.
    doubts : tuple of str
        What may be wrong with the data, and was taken as it is, with what to do about it.
    repairs : tuple of Repair
        What was done to the data, in this order; only on request, except a last row that is cut and
        wild samples.
    clock : PeriodSource or None
        Of a log that was read.
    """

    source: str = "arrays"
    sha256: str = ""
    given: str = ""
    path: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    truth: dict[str, float] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
    clock: PeriodSource | None = None
