"""Estimates held against another record: from a result and a record to a `Validation`."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Levels
from axisid.estimation.choices import is_output_error
from axisid.estimation.diagnostics import overlaps
from axisid.estimation.diagnostics.law import LawCheck, check_law
from axisid.estimation.estimates import Distribution, Estimate
from axisid.estimation.identification import Identification, OfRecord, RecordInfo
from axisid.estimation.methods import METHODS, Bootstrap, bound_record, estimate_by
from axisid.estimation.problems import Problem
from axisid.estimation.records import Record, check_record, clock_of, other_period
from axisid.estimation.regression import (
    Equations,
    Form,
    loop_reference,
    simulated_loops,
    simulated_position,
    simulated_right,
)
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.simulation import Simulation
from axisid.estimation.twins import DEFAULT_COUNT
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError, UsageError
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy, Setting
from axisid.support.user_values import quoted

from .reestimate import Reestimate, least_mean_square
from .validation import MethodValidation, Validation


class FrozenEstimate(Protocol):
    """What is held against another record of an estimate."""

    @property
    def method(self) -> str:
        """How it was estimated."""

    @property
    def distribution(self) -> Distribution:
        """Of the physical parameters."""

    @property
    def equation_error_percent(self) -> float:
        """On its own record."""

    @property
    def simulation_error_percent(self) -> float | None:
        """On its own record."""


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
    def record(self) -> RecordInfo:
        """The record that it was identified from."""

    @property
    def estimates(self) -> Mapping[str, FrozenEstimate]:
        """By method."""

    @property
    def levels(self) -> Levels:
        """By which its checks tell something."""

    @property
    def of_records(self) -> tuple[OfRecord, ...]:
        """What there is to say of each of several records; empty for one."""

    @property
    def local_names(self) -> Mapping[str, tuple[str, ...]]:
        """Of each parameter that records have for themselves, its names by record."""

    def part(self, number: int) -> Any:
        """The result as one of its records has it, by its number from 1: a `FrozenResult`."""


def validate(result: FrozenResult, record: Record, *, like: int | None = None) -> Validation:
    """Hold every estimate, frozen, against another record of the axis.

    Parameters
    ----------
    result : Identification or SavedIdentification
    record : Record
        Read for the same axis; it is filtered as the estimates' own record was, in Hz. The hold and
        the reversals are chosen for it anew where they were left open.
    like : int, optional
        Number of one of several records that the result was made from, from 1: what is its own
        (`local`) or known of it, such as a payload, holds of the record too. Needed where there is
        such.

    Raises
    ------
    UsageError, DataError
        The record does not suit the prefilter or has no force.
    """
    if not hasattr(result, "estimates"):
        raise UsageError(
            f"the result is {quoted(result)}; give what identify gave, or load_result(path).",
            code="validated-type",
        )
    check_record(record)
    whole, levels = result, result.levels
    if like is not None:
        result = result.part(like)
    elif problem := _own_parameters(result):
        raise UsageError(problem.text, problem.remedy, code="own-parameters")
    with np.errstate(all="ignore"):
        requested = result.requested or result.prefilter  # what was left open suits each record
        rescaled = requested.at_period(result.record.period, record.period)
        data = bound_record(result.axis, record, rescaled)
        own_data = result.problem.data if isinstance(result, Identification) else ()
        law = check_law(result.axis, record)
        again = _estimated_anew(data, [*result.estimates], law)
        of_each = replace(levels, level=levels.level / len(result.estimates))
        methods = tuple(
            replace(
                _validation(data, frozen, own_data),
                reestimate=Reestimate.of(frozen.distribution, again[method], of_each)
                if method in again
                else None,
            )
            for method, frozen in result.estimates.items()
        )
    apart = other_period(result.axis.axis.control, record.period, clock_of(record))
    return Validation(
        record=record,
        unit=result.axis.axis.coordinate.unit,
        methods=methods,
        known_share=_known_share(
            [of_one.record for of_one in whole.of_records] or [whole.record], record
        ),
        time_base=apart.note if apart is not None and not apart.confirmed else None,
        law=law,
        levels=levels,
    )


def _estimated_anew(
    data: FilteredRecord, methods: Sequence[str], law: LawCheck | Missing
) -> dict[str, Estimate]:
    """The second record's own estimates, with its twins; without those that it does not give."""
    problem, found = Problem(axis=data.axis, data=(data,)), {}
    twins = Bootstrap(
        problem=problem,
        count=DEFAULT_COUNT,
        methods=methods,
        has_laws=lambda: isinstance(law, LawCheck) and law.passed,
    )
    for method in methods:
        with suppress(ModelError, DataError, EstimationError):
            found[method] = estimate_by(problem, METHODS[method], None, "hac", twins)
    return found


def _own_parameters(result: FrozenResult) -> Note | None:
    """Why no other record can be held against a result of several; None if any can."""
    names = [*result.local_names]
    names += [name for of_one in result.of_records[:1] for name in of_one.known]
    if not names:
        return None
    return Note(
        f"{', '.join(names)} of this result {'is' if len(names) == 1 else 'are'} each record's own "
        "or known of each, and nothing says what holds of another record; ",
        Remedy.of("name the record that it is like: ", Setting("validate-like", "1"), "."),
    )


def _known_share(own: Sequence[RecordInfo], record: Record) -> float:
    """Part of a record's samples that are among those of others: by what they are, or their file.

    A file has no samples of the records that a result was made from; of them the whole is known by
    its digest, and parts of one log by their windows.
    """
    known = np.zeros(len(record), dtype=bool)
    for each in own:
        if each.digest == record.digest:
            return 1.0
        file = each.provenance.sha256
        if file and file == record.provenance.sha256:
            known |= _within(each.windows, record.time)
        elif isinstance(each, Record):
            for overlap in overlaps([each, record]):
                known |= overlap.samples[1]
    return float(np.mean(known))


def _within(windows: Sequence[tuple[float, float]], time: Array) -> NDArray[np.bool_]:
    """Which times are in a window; all where there is none."""
    if not windows:
        return np.ones(len(time), dtype=bool)
    inside = np.zeros(len(time), dtype=bool)
    for start, stop in windows:
        inside |= (time >= start) & (time <= stop)
    return inside


def _validation(
    data: FilteredRecord, estimate: FrozenEstimate, own_data: Sequence[FilteredRecord]
) -> MethodValidation:
    """How an estimate holds on a second record, its own records being these."""
    axis, record, frozen = data.axis, data.record, estimate.distribution
    form = METHODS[estimate.method].form(axis).at(frozen.theta)
    rows = _rows_left(form, data)
    theta = form.regressed(frozen.theta)
    found = _by_equations(estimate, rows, theta, data)
    try:
        loops = simulated_loops(axis, record, frozen.theta)
        intercept, regressor = simulated_right(form, loops, frozen.theta, data)
    except (ModelError, DataError, EstimationError) as error:
        return replace(found, reason=error.note)
    if is_output_error(estimate.method):  # whose rows are the loop's
        of_loop = replace(rows, intercept=intercept, regressor=regressor)
        found = _by_equations(estimate, of_loop, theta, data)
    found = replace(
        found,
        simulation_error_percent=relative_error_percent(
            rows.left - regressor @ theta - intercept, rows.left
        ),
    )
    if data.record.integrated:  # the velocity's integral drifts away from where the axis was
        return found
    off, tracking = _positions(data, loops)
    return replace(
        found,
        position_error_rms=float(np.sqrt(np.mean(off**2))),
        tracking_error_percent=relative_error_percent(off, tracking),
        own_tracking_error_percent=_own_tracking(own_data, frozen.theta),
    )


def _rows_left(form: Form, data: FilteredRecord) -> Equations:
    """The rows of the second record; refused where it has none."""
    rows = form.equations(data.signals).reduced(data)
    if not len(rows.left):
        raise DataError(
            f"{data.record.provenance.source}: no row is left of it, since all its motion is near "
            "reversals or masked; ",
            Remedy.of(
                "record longer strokes, or identify with ", Setting("reversals", "keep"), "."
            ),
            code="no-row",
        )
    return rows


def _by_equations(
    estimate: FrozenEstimate, rows: Equations, theta: Array, data: FilteredRecord
) -> MethodValidation:
    """What the rows alone say, before the loop is simulated."""
    residuals = rows.left - rows.intercept - rows.regressor @ theta
    equation = relative_error_percent(residuals, rows.left)
    if not math.isfinite(equation):
        raise DataError(
            f"{data.record.provenance.source}: the equation error of {estimate.method} is not "
            "finite; check the size and the units of its columns.",
            code="equation-error-not-finite",
        )
    return MethodValidation(
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


def _own_tracking(own: Sequence[FilteredRecord], physical: Array) -> float | None:
    """The same error on the estimate's own records, where they and their loops are there."""
    if not own or any(data.record.integrated for data in own):
        return None
    try:
        pairs = [
            _positions(data, simulated_loops(data.axis, data.record, physical)) for data in own
        ]
    except (ModelError, DataError, EstimationError):
        return None
    off, tracking = (np.concatenate(side) for side in zip(*pairs, strict=True))
    return relative_error_percent(off, tracking)


def _positions(data: FilteredRecord, loops: Sequence[Simulation]) -> tuple[Array, Array]:
    """Recorded less simulated position, and reference less recorded position."""
    position, kept = data.record.position, data.kept
    reference = loop_reference(data.axis, data.record)
    return (position - simulated_position(loops))[kept], (reference - position)[kept]
