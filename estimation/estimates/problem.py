"""The rows that a record gives an axis's forms, and the loops that are simulated beside them."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from axisid.estimation.regression import (
    Equations,
    Factored,
    Form,
    InverseForm,
    Solution,
    factor,
    simulated_loops,
    simulated_right,
)
from axisid.estimation.signals import FilteredRecord, motion_lacks
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import AxisidError

from .estimate import FOLLOWING, Iterate
from .visibility import Reach, check_shown


class Regressions:
    """What a record under a filter gives to be regressed.

    Parameters
    ----------
    data : FilteredRecord
    """

    def __init__(self, data: FilteredRecord) -> None:
        self.data = data
        self.axis, self.record, self.prefilter = data.axis, data.record, data.prefilter
        self.signals = data.signals
        self._linear: dict[type[Form], Equations] = {}

    def rows(self, form: Form) -> Equations:
        """The measured rows of a form.

        Raises
        ------
        EstimationError
            They do not show a parameter, which is named.
        """
        if self.axis.is_linear and type(form) in self._linear:
            return self._linear[type(form)]
        every = form.equations(self.signals)
        rows = every.reduced(self.prefilter, self.record.period)
        if isinstance(form, InverseForm):
            self._check(every, rows)
        if self.axis.is_linear:
            self._linear[type(form)] = rows
        return rows

    def factored(self, form: Form, measured: Equations) -> Factored:
        """The regressor of measured rows, or an error that says what the motion lacks."""
        with adding(self.lacking()):
            return factor(measured.regressor, [q.expression or q.name for q in form.quantities])

    def simulated(self, form: Form, physical: Array) -> tuple[tuple[Simulation, ...], Array, Array]:
        """The loops simulated with an estimate, and their known part and regressor, reduced."""
        loops = simulated_loops(self.axis, self.record, physical)
        right = simulated_right(form, loops, physical, self.prefilter, self.record.period)
        return loops, *right

    @property
    def rest(self) -> float:
        """Part of the samples of a fit at which the axis stands still."""
        return self.data.rest

    def lacking(self) -> str:
        """What the motion lacks, as a sentence; empty if nothing is known to lack."""
        facts = motion_lacks(self.signals)
        return f"In this record {', and '.join(facts)}." if facts else ""

    def _check(self, every: Equations, rows: Equations) -> None:
        """Refuse columns that the rows do not show, of what every sample has."""
        with adding(self.lacking()):
            check_shown(
                self.axis,
                Reach.of(self.signals, every, self.data.kept),
                rows.regressor,
                rows.left - rows.known,
                rows=len(rows.left),
                source="the record",
                without_turns=self.prefilter.reversals == "leave-out",
            )


@dataclass(frozen=True, slots=True)
class Fit:
    """A solution of measured rows, with the loops simulated from it."""

    measured: Equations
    solution: Solution
    instruments: Factored | None
    iterates: tuple[Iterate, ...]
    loops: tuple[Simulation, ...]
    simulated: Array | None
    remarks: tuple[str, ...]
    #: Why the loop cannot be simulated with the estimate, if it is the estimate's fault.
    not_simulated: str = ""

    @property
    def follows(self) -> bool:
        """Whether the simulated loops move as the record does, so that they stand for it."""
        if self.simulated is None:
            return False
        left = self.measured.left
        return relative_error_percent(left - self.simulated, left) < FOLLOWING


@contextmanager
def adding(what: str) -> Iterator[None]:
    """Say more in an error, if there is more to say."""
    try:
        yield
    except AxisidError as error:
        if what:
            raise type(error)(f"{error} {what}") from error
        raise
