"""Estimates held against another record, as they are."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.estimates import METHODS, bound_record
from axisid.estimation.records import Record, check_record, clock_of, other_period
from axisid.estimation.regression import (
    loop_reference,
    simulated_loops,
    simulated_position,
    simulated_right,
)
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.simulation import Simulation
from axisid.estimation.tables import Provenance
from axisid.estimation.thresholds.studies import MAX_VALIDATION_ERROR, MAX_VALIDATION_ERROR_RATIO
from axisid.support.arrays import Array, Exact, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError, UsageError
from axisid.support.given import given
from axisid.support.remedy import Note, Remedy, Setting
from axisid.support.shown import Shown


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodValidation:
    """One estimate on a record that it was not made from.

    Attributes
    ----------
    method : str
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||`` on the record, filtered as for the estimate.
    own_equation_error_percent : float
        The same on the record that the estimate was made from.
    simulation_error_percent : float or None
        ``100 ||y - simulated|| / ||y||``; None where the loop could not be simulated.
    position_error_rms : float or None
        Of the simulated position against the recorded one over the samples that are kept, in
        the coordinate's unit.
    tracking_error_percent : float or None
        The same in percent of the recorded tracking error, reference less position: how much of
        what the loop leaves the estimate does not explain.
    reason : Note or None
        Why there are no simulated figures.
    """

    method: str
    equation_error_percent: float
    own_equation_error_percent: float
    simulation_error_percent: float | None
    position_error_rms: float | None
    tracking_error_percent: float | None
    reason: Note | None

    @property
    def holds(self) -> bool:
        """Whether the error is of the size that it has on the estimate's own record."""
        times, most = MAX_VALIDATION_ERROR_RATIO.value, MAX_VALIDATION_ERROR.value
        return self.equation_error_percent <= max(times * self.own_equation_error_percent, most)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class Validation(Shown, Exact):
    """The estimates of a result, frozen, on another record; ``validation["idm-iv"]`` is one.

    Attributes
    ----------
    record : Record
    unit : str
        Of the position.
    methods : tuple of MethodValidation
        In the order of the result's estimates; the object iterates over them.
    same_record : bool
        Whether it is the record that the estimates were made from.
    time_base : Note or None
        What speaks against the record's sampling period.
    """

    record: Record
    unit: str
    methods: tuple[MethodValidation, ...]
    same_record: bool = False
    time_base: Note | None = None

    def __iter__(self) -> Iterator[MethodValidation]:
        return iter(self.methods)

    def __getitem__(self, method: str) -> MethodValidation:
        found = next((each for each in self.methods if each.method == str(method).lower()), None)
        if found is None:
            methods = ", ".join(each.method for each in self.methods)
            raise UsageError(f"the validation has no {given(method)}; choose from {methods}.")
        return found

    def __repr__(self) -> str:
        held = ", ".join(f"{v.method} {v.equation_error_percent:.4g} %" for v in self)
        return f"validation on {self.record.provenance.source}: equation error {held}"

    @property
    def errors(self) -> dict[tuple[str, str], tuple[float | None, ...]]:
        """Figures of the methods by name and unit, as a table shows them."""
        return {
            ("equation error", "%"): tuple(v.equation_error_percent for v in self),
            ("on its own record", "%"): tuple(v.own_equation_error_percent for v in self),
            ("simulation error", "%"): tuple(v.simulation_error_percent for v in self),
            ("position error, rms", self.unit): tuple(v.position_error_rms for v in self),
            ("of the tracking error", "%"): tuple(v.tracking_error_percent for v in self),
        }

    @property
    def notes(self) -> tuple[Note, ...]:
        """What is missing and why, and which estimates do not hold."""
        reasons = dict.fromkeys(v.reason for v in self if v.reason)
        notes = [Note.of("no simulation: ", reason) for reason in reasons]
        if self.time_base:
            notes.append(Note.of("believe nothing before this is mended: ", self.time_base))
        return (*notes, Note(self._whether_it_holds()))

    def _whether_it_holds(self) -> str:
        """Which estimates do not, in words."""
        if self.same_record:
            return (
                "this is the record that the estimates were made from, so it says nothing new; "
                "validate on another one"
            )
        times, most = MAX_VALIDATION_ERROR_RATIO.value, MAX_VALIDATION_ERROR.value
        lost = [v.method for v in self if not v.holds]
        if not lost:
            return (
                f"the estimates hold: no equation error is both beyond {most:g} % and beyond "
                f"{times:g} times the one on their own record"
            )
        return (
            f"{', '.join(lost)}: does not hold on this record (more than {most:g} % and than "
            f"{times:g} times the error on its own); check that it is the same axis, its units"
            " and its signs"
        )


class FrozenEstimate(Protocol):
    """What is held against another record of an estimate."""

    @property
    def method(self) -> str:
        """How it was estimated."""

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""

    @property
    def equation_error_percent(self) -> float:
        """On its own record."""


class OwnRecord(Protocol):
    """What is asked of the record that an estimate was made from."""

    @property
    def provenance(self) -> Provenance:
        """Where it comes from."""

    @property
    def period(self) -> float:
        """Sampling period, s."""

    @property
    def digest(self) -> str:
        """Of the samples."""


class FrozenResult(Protocol):
    """An identification: a live one, or what a file holds of one."""

    @property
    def axis(self) -> GeneratedAxis:
        """The axis that was identified."""

    @property
    def requested(self) -> Prefilter | None:
        """The prefilter before what it left open was chosen for the record, if that is known."""

    @property
    def prefilter(self) -> Prefilter:
        """The filter as it was applied."""

    @property
    def record(self) -> OwnRecord:
        """The record that it was identified from."""

    @property
    def estimates(self) -> Mapping[str, FrozenEstimate]:
        """By method."""


def validate(result: FrozenResult, record: Record) -> Validation:
    """Hold every estimate, frozen, against another record of the axis.

    Parameters
    ----------
    result : Identification or SavedIdentification
    record : Record
        Read for the same axis; it is filtered as the estimates' own record was, in Hz. The hold and
        the reversals are chosen for it anew where they were left open.

    Raises
    ------
    UsageError, DataError
        The record does not suit the prefilter or has no force.
    """
    if not hasattr(result, "estimates"):
        raise UsageError(
            f"the result is {given(result)}; give what identify gave, or load_result(path)."
        )
    check_record(record)
    with np.errstate(all="ignore"):
        requested = result.requested or result.prefilter  # what was left open suits each record
        rescaled = requested.at_period(result.record.period, record.period)
        data = bound_record(result.axis, record, rescaled)
        methods = tuple(_validation(data, estimate) for estimate in result.estimates.values())
    apart = other_period(result.axis.axis.control, record.period, clock_of(record))
    return Validation(
        record=record,
        unit=result.axis.axis.coordinate.unit,
        methods=methods,
        same_record=_is_same(result.record, record),
        time_base=apart.note if apart is not None and not apart.confirmed else None,
    )


def _is_same(own: OwnRecord, other: Record) -> bool:
    """Whether two records are of the same samples, or read from the same file."""
    file = own.provenance.sha256
    return own.digest == other.digest or (bool(file) and file == other.provenance.sha256)


def _validation(data: FilteredRecord, estimate: FrozenEstimate) -> MethodValidation:
    axis, record = data.axis, data.record
    form = METHODS[estimate.method].form(axis).at(estimate.physical)
    rows = form.equations(data.signals).reduced(data)
    theta = form.regressed(estimate.physical)
    if not len(rows.left):
        raise DataError(
            f"{record.provenance.source}: no row is left of it, since all its motion is near "
            "reversals or masked; ",
            Remedy.of(
                "record longer strokes, or identify with ", Setting("reversals", "keep"), "."
            ),
            code="no-row",
        )
    equation = relative_error_percent(rows.left - rows.known - rows.regressor @ theta, rows.left)
    if not math.isfinite(equation):
        raise DataError(
            f"{record.provenance.source}: the equation error of {estimate.method} is not finite; "
            "check the size and the units of its columns."
        )
    try:
        reference = loop_reference(axis, record)
        loops = simulated_loops(axis, record, estimate.physical)
        known, regressor = simulated_right(form, loops, estimate.physical, data)
    except (ModelError, DataError, EstimationError) as error:
        return MethodValidation(
            method=estimate.method,
            equation_error_percent=equation,
            own_equation_error_percent=estimate.equation_error_percent,
            simulation_error_percent=None,
            position_error_rms=None,
            tracking_error_percent=None,
            reason=error.note,
        )
    off, tracking = _positions(data, loops, reference)
    return MethodValidation(
        method=estimate.method,
        equation_error_percent=equation,
        own_equation_error_percent=estimate.equation_error_percent,
        simulation_error_percent=relative_error_percent(
            rows.left - regressor @ theta - known, rows.left
        ),
        position_error_rms=float(np.sqrt(np.mean(off**2))),
        tracking_error_percent=relative_error_percent(off, tracking),
        reason=None,
    )


def _positions(
    data: FilteredRecord, loops: Sequence[Simulation], reference: Array
) -> tuple[Array, Array]:
    """Recorded less simulated position, and reference less recorded position."""
    position, kept = data.record.position, data.kept
    return (position - simulated_position(loops))[kept], (reference - position)[kept]
