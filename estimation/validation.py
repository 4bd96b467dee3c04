"""Estimates held against another record, as they are."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from axisid.codegen import GeneratedAxis
from axisid.modeling import ModelError

from .arrays import Array, relative_error_percent
from .closed_loop import Simulation
from .errors import DataError, EstimationError
from .estimate import Estimate
from .forms import DirectForm, Form, InverseForm
from .prefilter import Prefilter
from .record import Record
from .results import Identification
from .serialised import record_dict
from .signals import Signals, measured_signals, settled
from .simulated_rows import (
    loop_reference,
    simulated_loops,
    simulated_position,
    simulated_right,
)
from .summary import heading_text, record_lines, text_table

_TWICE, _SMALL = 2.0, 10.0  # times, percent


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
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
    reason : str
        Why there are no simulated figures; empty where there are.
    """

    method: str
    equation_error_percent: float
    own_equation_error_percent: float
    simulation_error_percent: float | None
    position_error_rms: float | None
    tracking_error_percent: float | None
    reason: str

    @property
    def holds(self) -> bool:
        """Whether the error is of the size that it has on the estimate's own record."""
        most = max(_TWICE * self.own_equation_error_percent, _SMALL)
        return self.equation_error_percent <= most


def validate(result: Identification, record: Record) -> tuple[Validation, ...]:
    """Hold every estimate, frozen, against another record of the axis.

    Parameters
    ----------
    result : Identification
    record : Record
        Read for the same axis; it is filtered as the estimates' own record was, in Hz.

    Raises
    ------
    UsageError, DataError
        The record does not suit the prefilter or has no force.
    """
    with np.errstate(all="ignore"):
        rescaled = result.prefilter.at_period(result.record.period, record.period)
        prefilter = settled(rescaled, result.axis, record)
        signals = measured_signals(result.axis, record, prefilter)
        return tuple(
            _validation(result.axis, record, signals, prefilter, estimate)
            for estimate in result.estimates.values()
        )


def _validation(
    axis: GeneratedAxis,
    record: Record,
    signals: Signals,
    prefilter: Prefilter,
    estimate: Estimate,
) -> Validation:
    form: Form = InverseForm(axis) if estimate.method.startswith("idm") else DirectForm(axis)
    form = form.at(estimate.physical)
    rows = form.equations(signals).reduced(prefilter, record.period)
    theta = form.regressed(estimate.physical)
    equation = relative_error_percent(rows.left - rows.known - rows.regressor @ theta, rows.left)
    if not math.isfinite(equation):
        raise DataError(
            f"{record.provenance.source}: the equation error of {estimate.method} is not finite; "
            "check the size and the units of its columns."
        )
    try:
        reference = loop_reference(axis, record)
        loops = simulated_loops(axis, record, estimate.physical)
        known, regressor = simulated_right(form, loops, estimate.physical, prefilter, record.period)
    except (ModelError, DataError, EstimationError) as error:
        return Validation(
            method=estimate.method,
            equation_error_percent=equation,
            own_equation_error_percent=estimate.equation_error_percent,
            simulation_error_percent=None,
            position_error_rms=None,
            tracking_error_percent=None,
            reason=str(error),
        )
    off, tracking = _positions(record, loops, reference, prefilter)
    return Validation(
        method=estimate.method,
        equation_error_percent=equation,
        own_equation_error_percent=estimate.equation_error_percent,
        simulation_error_percent=relative_error_percent(
            rows.left - regressor @ theta - known, rows.left
        ),
        position_error_rms=float(np.sqrt(np.mean(off**2))),
        tracking_error_percent=relative_error_percent(off, tracking),
        reason="",
    )


def _positions(
    record: Record, loops: Sequence[Simulation], reference: Array, prefilter: Prefilter
) -> tuple[Array, Array]:
    """Recorded less simulated position, and reference less recorded position."""
    kept = prefilter.kept(len(record), record.period)
    return (record.position - simulated_position(loops))[kept], (reference - record.position)[kept]


def validation_text(validations: Sequence[Validation], record: Record, unit: str) -> str:
    """The validations as a table."""
    header = ["validation", "unit", *(v.method.upper() for v in validations)]
    rows = [
        ["equation error", "%", *(_cell(v.equation_error_percent) for v in validations)],
        ["on its own record", "%", *(_cell(v.own_equation_error_percent) for v in validations)],
        ["simulation error", "%", *(_cell(v.simulation_error_percent) for v in validations)],
        ["position error, rms", unit, *(_cell(v.position_error_rms) for v in validations)],
        ["of the tracking error", "%", *(_cell(v.tracking_error_percent) for v in validations)],
    ]
    lines = [
        f"Frozen estimates on {record.provenance.source}, {len(record)} samples:",
        *filter(None, [heading_text({"repaired": record_lines(record)["repaired"]})]),
        "",
        text_table(header, rows),
    ]
    reasons = dict.fromkeys(v.reason for v in validations if v.reason)
    lines += [f"no simulation: {reason}" for reason in reasons]
    lost = [v.method for v in validations if not v.holds]
    if lost:
        lines.append(
            f"{', '.join(lost)}: does not hold on this record (more than {_TWICE:g} times the "
            "error on its own); check that it is the same axis, its units and its signs"
        )
    return "\n".join(lines) + "\n"


def validation_dict(validations: Sequence[Validation], record: Record) -> dict[str, Any]:
    """The validations as plain numbers and texts; what is not finite becomes null."""
    return {
        "record": record_dict(record),
        "methods": [
            {
                name: None if isinstance(value, float) and not math.isfinite(value) else value
                for name, value in asdict(v).items()
            }
            for v in validations
        ],
    }


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
