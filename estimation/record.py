"""The record: what was measured, checked once, then read-only."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, frozen
from .errors import DataError

_LARGEST_GAP = 1.5  # in sampling periods
_PERIOD_TOLERANCE = 0.05
_UNEVEN = 0.02  # mean step against the median one


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Where a record comes from.

    Attributes
    ----------
    source : str
        File name, or how the record was made.
    sha256 : str
        Of the file; empty if there is none.
    columns : dict of str to str
        Column name by role.
    truth : dict of str to float
        Parameters of a simulated record, SI; empty for a measured one.
    """

    source: str = "arrays"
    sha256: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    truth: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """A closed-loop record at one sampling period, in SI units.

    Attributes
    ----------
    time : (N,) array
        s, strictly increasing without gaps.
    position : (N,) array
        Measured, m or rad.
    reference : (N,) array or None
        Commanded position; instrumental variables need it.
    control : (N,) array or None
        Control signal in the drive's unit.
    force : (N,) array or None
        Drive force, N or N m; taken instead of the control where both are given.
    sample_period : float or None
        s. None takes the mean of the time column's steps.
    provenance : Provenance
        Where the record comes from.

    Raises
    ------
    DataError
        Columns of different lengths, not finite, constant; time that does not increase evenly.
    """

    time: Array
    position: Array
    reference: Array | None = None
    control: Array | None = None
    force: Array | None = None
    sample_period: float | None = None
    provenance: Provenance = field(default_factory=Provenance)

    def __post_init__(self) -> None:
        for role, values in self.channels().items():
            object.__setattr__(self, role, self._column(role, values))
        self._check_lengths()
        self._check_time()
        for role, values in self.channels().items():
            if role != "time" and np.ptp(values) == 0:
                raise DataError(
                    f"{self._name()}: the {role} is {values[0]:g} in every row, so it says nothing "
                    f"about the axis. Check the {role} column, or record a motion."
                )

    @property
    def period(self) -> float:
        """Sampling period, s."""
        if self.sample_period is not None:
            return self.sample_period
        return float((self.time[-1] - self.time[0]) / (len(self) - 1))

    def __len__(self) -> int:
        return len(self.time)

    def channels(self) -> dict[str, Array]:
        """The columns there are, by role."""
        columns = {
            "time": self.time,
            "position": self.position,
            "reference": self.reference,
            "control": self.control,
            "force": self.force,
        }
        return {role: values for role, values in columns.items() if values is not None}

    def _name(self) -> str:
        return self.provenance.source

    def _column(self, role: str, values: ArrayLike) -> Array:
        if np.ma.is_masked(values) or np.iscomplexobj(values):
            raise DataError(f"{self._name()}: the {role} is masked or complex; give real numbers.")
        try:
            column = frozen(values)
        except (TypeError, ValueError) as error:
            raise DataError(f"{self._name()}: the {role} is not numeric: {error}.") from error
        if column.ndim != 1:
            raise DataError(
                f"{self._name()}: the {role} has the shape {column.shape}; give one row of numbers."
            )
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise DataError(
                f"{self._name()}: the {role} is {column[bad[0]]} in data row {bad[0] + 1} "
                f"({bad.size} in all). Remove such rows or repair the log."
            )
        return column

    def _check_lengths(self) -> None:
        lengths = {role: len(values) for role, values in self.channels().items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
            raise DataError(f"{self._name()}: the columns differ in length: {listed}.")
        if len(self) < 3:
            raise DataError(f"{self._name()}: a record needs 3 rows or more, not {len(self)}.")

    def _check_time(self) -> None:
        steps = np.diff(self.time)
        back = np.flatnonzero(steps <= 0)
        if back.size:
            row = back[0] + 2
            raise DataError(
                f"{self._name()}: time does not increase in data row {row}: after "
                f"{self.time[row - 2]:.9g} s comes {self.time[row - 1]:.9g} s. Sort the rows and "
                "remove repeated ones."
            )
        typical = float(np.median(steps))
        gaps = np.flatnonzero((steps > _LARGEST_GAP * typical) | (steps * _LARGEST_GAP < typical))
        if gaps.size:
            row = gaps[0] + 2
            raise DataError(
                f"{self._name()}: the time step before data row {row} is {steps[gaps[0]]:.6g} s, "
                f"{typical:.6g} s elsewhere ({gaps.size} in all). Resample the log evenly, or "
                "cut it at the gap."
            )
        mean = float((self.time[-1] - self.time[0]) / len(steps))
        if not abs(mean / typical - 1) < _UNEVEN:
            raise DataError(
                f"{self._name()}: the time steps are uneven: {typical:.6g} s in the middle, "
                f"{mean:.6g} s in the mean. Resample the log evenly."
            )
        period = self.sample_period
        if period is not None and not abs(period / typical - 1) < _PERIOD_TOLERANCE:
            raise DataError(
                f"{self._name()}: the sampling period is given as {period:g} s, but the time "
                f"column steps by {typical:g} s. Correct one of them (time is in seconds)."
            )
