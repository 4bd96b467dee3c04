"""Estimates held against another record, as they are."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.diagnostics.loop import LawCheck, check_law
from axisid.estimation.identification import Identification
from axisid.estimation.methods import METHODS, Instruments, bound_record
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
from axisid.estimation.thresholds.studies import (
    MAX_VALIDATION_ERROR,
    MAX_VALIDATION_ERROR_RATIO,
    MAX_VALIDATION_TRACKING,
)
from axisid.support.arrays import Array, Exact, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError, UsageError
from axisid.support.given import given
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable
from axisid.support.remedy import Note, Remedy, Setting

from .anew import Anew, estimated_anew, least_mean_square


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
    own_simulation_error_percent, own_tracking_error_percent : float or None
        On the record that the estimate was made from; None where they are not known, as the latter
        is of a result that was read from a file.
    least_equation_error_percent : float or None
        The equation error less what chance may make of it in so short a record.
    anew : Anew or None
        What the record itself says of the parameters; None where it cannot.
    """

    method: str
    equation_error_percent: float
    own_equation_error_percent: float
    simulation_error_percent: float | None
    position_error_rms: float | None
    tracking_error_percent: float | None
    reason: Note | None
    own_simulation_error_percent: float | None = None
    own_tracking_error_percent: float | None = None
    least_equation_error_percent: float | None = None
    anew: Anew | None = None

    @property
    def holds(self) -> bool:
        """Whether the force fits the motion, the loop the record, and the parameters are the same.

        The errors are compared with those on the estimate's own record.
        """
        return self.fits and self.follows and not (self.anew and self.anew.changed)

    @property
    def fits(self) -> bool:
        """Whether the equation error is of the size that it has on the estimate's own record."""
        most = MAX_VALIDATION_ERROR.value
        least = self.least_equation_error_percent
        found = self.equation_error_percent if least is None else least
        return _as_small(found, self.own_equation_error_percent, most)

    @property
    def follows(self) -> bool:
        """Whether the simulated loop is as near the record as it is on the estimate's own."""
        pairs = (
            (
                self.simulation_error_percent,
                self.own_simulation_error_percent,
                MAX_VALIDATION_ERROR.value,
            ),
            (
                self.tracking_error_percent,
                self.own_tracking_error_percent,
                MAX_VALIDATION_TRACKING.value,
            ),
        )
        return all(
            found is None or own is None or _as_small(found, own, most)
            for found, own, most in pairs
        )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class Validation(Presentable, Exact):
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
    law : LawCheck or Missing
        The declared control law against the record.
    """

    record: Record
    unit: str
    methods: tuple[MethodValidation, ...]
    same_record: bool = False
    time_base: Note | None = None
    law: LawCheck | Missing = field(default_factory=lambda: Missing("it was not looked at"))

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
            ("parameters anew", "%"): tuple(
                # Of the record that they are of, rounding alone is left.
                None if v.anew is None else round(v.anew.share_percent, 6)
                for v in self
            ),
        }

    @property
    def notes(self) -> tuple[Note, ...]:
        """What is missing and why, and which estimates do not hold."""
        reasons = dict.fromkeys(v.reason for v in self if v.reason)
        notes = [Note.of("no simulation: ", reason) for reason in reasons]
        if self.time_base:
            notes.append(Note.of("believe nothing before this is mended: ", self.time_base))
        return (*notes, *self._whether_it_holds())

    @property
    def has_declared_law(self) -> bool:
        """Whether nothing speaks against the declared control law on this record."""
        return isinstance(self.law, Missing) or self.law.passed

    def _whether_it_holds(self) -> tuple[Note, ...]:
        """Which estimates do not, and why, in words."""
        if self.same_record:
            said = (
                "this is the record that the estimates were made from, so it says nothing new; "
                "validate on another one"
            )
            return (Note(said),)
        faults = [*self._other_law(), *self._other_force(), *self._other_loop(), *self._moved()]
        return tuple(faults) or (Note(self._held()),)

    def _held(self) -> str:
        times, most = MAX_VALIDATION_ERROR_RATIO.value, MAX_VALIDATION_ERROR.value
        also = ", the simulated loops follow it" * any(v.tracking_error_percent for v in self)
        also += ", its control is the declared law's" * (not isinstance(self.law, Missing))
        also += ", and estimated anew the parameters are the same" * any(v.anew for v in self)
        return (
            f"the estimates hold: no equation error is both beyond {most:g} % and beyond "
            f"{times:g} times the one on their own record{also}"
        )

    def _other_law(self) -> Iterator[Note]:
        if isinstance(self.law, LawCheck) and not self.law.passed:
            yield Note.of("does not hold: the loop of this record is another one: ", self.law.note)

    def _other_force(self) -> Iterator[Note]:
        times, most = MAX_VALIDATION_ERROR_RATIO.value, MAX_VALIDATION_ERROR.value
        if lost := [v.method for v in self if not v.fits]:
            yield Note(
                f"{', '.join(lost)}: does not hold on this record (more than {most:g} % and than "
                f"{times:g} times the error on its own); check that it is the same axis, its units"
                " and its signs"
            )

    def _other_loop(self) -> Iterator[Note]:
        """Only where the law does not say more of it, or the force is at fault."""
        lost = [v for v in self if v.fits and not v.follows]
        if not lost or not self.has_declared_law:
            return
        worst = max(v.tracking_error_percent or 0.0 for v in lost)
        yield Note(
            f"{', '.join(v.method for v in lost)}: does not hold on this record: the force fits "
            f"the motion, but the simulated position is {worst:.3g} % of the tracking error from "
            "the recorded one, far more than on its own record; check the gains and the period of "
            "the drive, and name a test signal that was added, with ",
            Remedy.of(Setting("columns", "injected=NAME"), " and ", Setting("injected-at")),
        )

    def _moved(self) -> Iterator[Note]:
        found = {v.method: v.anew for v in self if v.anew is not None and v.anew.changed}
        texts = {method: anew.text() for method, anew in found.items()}
        for words in dict.fromkeys(texts.values()):
            methods = [method for method in texts if texts[method] == words]
            share = max(found[method].share_percent for method in methods)
            yield Note(
                f"{', '.join(methods)}: does not hold on this record: estimated anew it has "
                f"{words}, which makes {share:.2g} % of the force; check the load and what has "
                "changed, or whether friction and motion are beyond what the model says"
            )


def _as_small(found: float, own: float, most: float) -> bool:
    """Whether an error is small, or of the size that it has on the estimate's own record."""
    return found <= max(MAX_VALIDATION_ERROR_RATIO.value * own, most)


class FrozenEstimate(Protocol):
    """What is held against another record of an estimate."""

    @property
    def method(self) -> str:
        """How it was estimated."""

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""

    @property
    def chosen(self) -> str:
        """Name of the covariance that intervals are of."""

    @property
    def covariances(self) -> Mapping[str, Array]:
        """Of the physical parameters, (p, p), by name."""

    @property
    def freedom(self) -> Mapping[str, Array]:
        """Degrees of freedom of the variances in these, (p,)."""

    @property
    def equation_error_percent(self) -> float:
        """On its own record."""

    @property
    def simulation_error_percent(self) -> float | None:
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
        own_data = result.data if isinstance(result, Identification) else None
        methods = tuple(
            _validation(data, estimate, own_data) for estimate in result.estimates.values()
        )
        law = check_law(result.axis, record)
    apart = other_period(result.axis.axis.control, record.period, clock_of(record))
    return Validation(
        record=record,
        unit=result.axis.axis.coordinate.unit,
        methods=methods,
        same_record=_is_same(result.record, record),
        time_base=apart.note if apart is not None and not apart.confirmed else None,
        law=law,
    )


def _is_same(own: OwnRecord, other: Record) -> bool:
    """Whether two records are of the same samples, or read from the same file."""
    file = own.provenance.sha256
    return own.digest == other.digest or (bool(file) and file == other.provenance.sha256)


def _validation(
    data: FilteredRecord, estimate: FrozenEstimate, own_data: FilteredRecord | None
) -> MethodValidation:
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
    residuals = rows.left - rows.known - rows.regressor @ theta
    equation = relative_error_percent(residuals, rows.left)
    if not math.isfinite(equation):
        raise DataError(
            f"{record.provenance.source}: the equation error of {estimate.method} is not finite; "
            "check the size and the units of its columns."
        )
    found = MethodValidation(
        method=estimate.method,
        equation_error_percent=equation,
        own_equation_error_percent=estimate.equation_error_percent,
        simulation_error_percent=None,
        position_error_rms=None,
        tracking_error_percent=None,
        reason=None,
        own_simulation_error_percent=estimate.simulation_error_percent,
        least_equation_error_percent=equation
        * math.sqrt(least_mean_square(residuals, data.neighbours) / np.mean(residuals**2)),
    )
    covariance = estimate.covariances[estimate.chosen]
    anew = partial(
        estimated_anew,
        form,
        rows,
        neighbours=data.neighbours,
        frozen=estimate.physical,
        covariance=covariance,
        freedom=estimate.freedom[estimate.chosen],
    )
    is_iv = isinstance(METHODS[estimate.method], Instruments)
    try:
        loops = simulated_loops(axis, record, estimate.physical)
        known, regressor = simulated_right(form, loops, estimate.physical, data)
    except (ModelError, DataError, EstimationError) as error:
        by_rows = None if is_iv else anew(instruments=None)
        return replace(found, reason=error.note, anew=by_rows)
    off, tracking = _positions(data, loops)
    instruments = regressor if is_iv else None
    return replace(
        found,
        simulation_error_percent=relative_error_percent(
            rows.left - regressor @ theta - known, rows.left
        ),
        position_error_rms=float(np.sqrt(np.mean(off**2))),
        tracking_error_percent=relative_error_percent(off, tracking),
        own_tracking_error_percent=_own_tracking(own_data, estimate.physical),
        anew=anew(instruments=instruments),
    )


def _own_tracking(data: FilteredRecord | None, physical: Array) -> float | None:
    """The same error on the estimate's own record, where that and its loop are there."""
    if data is None:
        return None
    try:
        loops = simulated_loops(data.axis, data.record, physical)
    except (ModelError, DataError, EstimationError):
        return None
    return relative_error_percent(*_positions(data, loops))


def _positions(data: FilteredRecord, loops: Sequence[Simulation]) -> tuple[Array, Array]:
    """Recorded less simulated position, and reference less recorded position."""
    position, kept = data.record.position, data.kept
    reference = loop_reference(data.axis, data.record)
    return (position - simulated_position(loops))[kept], (reference - position)[kept]
