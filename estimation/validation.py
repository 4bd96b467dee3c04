"""Estimates held against another record, as they are."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from axisid.codegen import GeneratedAxis
from axisid.modeling import ModelError

from .arrays import Array, relative_error_percent
from .closed_loop import Simulation, simulate
from .errors import DataError, EstimationError
from .estimate import Estimate
from .forms import DirectForm, InverseForm
from .identification import loop_reference, simulated_right
from .prefilter import Prefilter
from .record import Record
from .results import Identification
from .serialised import record_dict
from .signals import Signals, measured_signals, settled
from .summary import text_table


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
    """One estimate on a record that it was not made from.

    Attributes
    ----------
    method : str
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||`` on the record, filtered as for the estimate.
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
    simulation_error_percent: float | None
    position_error_rms: float | None
    tracking_error_percent: float | None
    reason: str


def validate(result: Identification, record: Record) -> tuple[Validation, ...]:
    """Hold every estimate, frozen, against another record of the axis.

    Parameters
    ----------
    result : Identification
    record : Record
        Read for the same axis; it is filtered as the estimates' own record was.

    Raises
    ------
    UsageError, DataError
        The record does not suit the prefilter or has no force.
    """
    with np.errstate(all="ignore"):
        prefilter = settled(result.prefilter, result.axis, record)
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
    form = InverseForm(axis) if estimate.method.startswith("idm") else DirectForm(axis)
    rows = form.equations(signals).reduced(prefilter, record.period)
    theta = form.regressed(estimate.physical)
    equation = relative_error_percent(rows.left - rows.known - rows.regressor @ theta, rows.left)
    try:
        reference = loop_reference(axis, record)
        start = float(record.position[0])
        loop = simulate(axis, estimate.physical, reference, record.period, start=start)
        known, regressor = simulated_right(form, loop, estimate.physical, prefilter, record.period)
    except (ModelError, DataError, EstimationError) as error:
        return Validation(
            method=estimate.method,
            equation_error_percent=equation,
            simulation_error_percent=None,
            position_error_rms=None,
            tracking_error_percent=None,
            reason=str(error),
        )
    off, tracking = _positions(record, loop, reference, prefilter)
    return Validation(
        method=estimate.method,
        equation_error_percent=equation,
        simulation_error_percent=relative_error_percent(
            rows.left - regressor @ theta - known, rows.left
        ),
        position_error_rms=float(np.sqrt(np.mean(off**2))),
        tracking_error_percent=relative_error_percent(off, tracking),
        reason="",
    )


def _positions(
    record: Record, loop: Simulation, reference: Array, prefilter: Prefilter
) -> tuple[Array, Array]:
    """Recorded less simulated position, and reference less recorded position."""
    start, end = prefilter.dropped(record.period)
    kept = slice(start, len(record) - end)
    return (record.position - loop.position)[kept], (reference - record.position)[kept]


def validation_text(validations: Sequence[Validation], record: Record, unit: str) -> str:
    """The validations as a table."""
    header = ["validation", "unit", *(v.method.upper() for v in validations)]
    rows = [
        ["equation error", "%", *(_cell(v.equation_error_percent) for v in validations)],
        ["simulation error", "%", *(_cell(v.simulation_error_percent) for v in validations)],
        ["position error, rms", unit, *(_cell(v.position_error_rms) for v in validations)],
        ["of the tracking error", "%", *(_cell(v.tracking_error_percent) for v in validations)],
    ]
    lines = [
        f"Frozen estimates on {record.provenance.source}, {len(record)} samples:",
        "",
        text_table(header, rows),
    ]
    reasons = dict.fromkeys(v.reason for v in validations if v.reason)
    lines += [f"no simulation: {reason}" for reason in reasons]
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
