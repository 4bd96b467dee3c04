"""Provenance of a record: its source, its clock and its repairs."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """One repair of a record.

    Attributes
    ----------
    kind : str
        Kind of the repair, such as ``gaps``.
    count : int
        Number of changes, which depends on the kind: lines or samples left out, samples shifted,
        jumps removed, samples masked, rows resampled, values interpolated, or gaps.
    text : str
        Description for the user, with the method.
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
    """Source of the sampling period of a record.

    Attributes
    ----------
    step : float
        Sampling period of the log, in periods of the record: 1 unless it was resampled.
    uncertainty : float
        Relative uncertainty of the log's period by jitter and lost samples.
    counted : bool
        True for a log without times, whose samples are counted by the given period.
    stated : bool
        True if the user gave the period of the log, in addition to its times or instead of them.
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
        File name, or a text on how the record was made.
    sha256 : str
        SHA-256 of the bytes of the file that were used, or of the files of a folder in the order of
        their names; empty without a file.
    given, path : str
        Path of the file as the user gave it, and its absolute path; empty without a file.
    columns : dict of str to str
        Column name by role.
    truth : dict of str to float
        Parameters of a simulated record, SI; empty for a measured record.
    assumed : tuple of str
        Assumptions about the file: separator, encoding, units and their conversion.
    doubts : tuple of str
        Possible faults of the data that were not corrected, each with a remedy.
    repairs : tuple of Repair
        Repairs of the data, in the order in which they were made. They are made on request only,
        except that a truncated last row and single outliers are always left out.
    clock : PeriodSource or None
        Source of the sampling period of a log that was read; None for a record of arrays.
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
