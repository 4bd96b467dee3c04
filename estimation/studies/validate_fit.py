"""A fit held against another record: its parameters frozen, the output simulated anew.

The windows of an open loop start where that record is: their first positions and velocities are of
it, for whatever parameters are held against it, and nothing else is.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.choices import OPEN_LOOP, check_among
from axisid.estimation.diagnostics import Checked
from axisid.estimation.diagnostics.law import check_law
from axisid.estimation.fitting import OutputFit
from axisid.estimation.parameters import GAIN, STARTS, by_declared_gain
from axisid.estimation.predictions import LoopPredictions, Predictions, WindowPredictions
from axisid.estimation.records import Record, check_record
from axisid.estimation.regression import InverseForm
from axisid.support.arrays import Array, Exact
from axisid.support.errors import EstimationError, UsageError
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable
from axisid.support.real_numbers import is_real
from axisid.support.remedy import Note
from axisid.support.user_values import quoted

from .validation import MAX_VALIDATION_ERROR, checked_law, is_as_small

_OTHER_PERIOD = 1e-3  # relative difference of sample periods: clocks agree to less
_NO_LAW = "an open loop is followed without any law"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitValidation(Checked, Presentable, Exact):
    """What the output that frozen parameters simulate leaves of a record.

    Attributes
    ----------
    record : Record
    output : str
        ``control``, ``position``, ``force`` or ``open-loop``.
    unit : str
        Of the output.
    horizon : float or None
        Length of the windows of an open loop, s, that was asked for.
    windows : tuple of slice
        Of the errors: each window of an open loop, or each segment of the record.
    errors : (n,) array
        Simulated less recorded output.
    samples : (n,) array of int
        Of the record, that the errors are at.
    counted : (n,) array of bool
        Which of the samples are measurements.
    percent : float
        Root mean square of what is left, of that of the recorded output.
    checks : tuple of Check
        Whether the output is as near as on the fit's own records, and what says that the record may
        be of another axis, as a record does not know its axis: a control law that it does not have,
        another sample period than that of the fit's records.
    """

    record: Record
    output: str
    unit: str
    horizon: float | None
    windows: tuple[slice, ...]
    errors: Array
    samples: NDArray[np.intp]
    counted: NDArray[np.bool_]
    percent: float
    checks: tuple[Check, ...] = ()

    @property
    def notes(self) -> tuple[Note, ...]:
        """What speaks against the fit on this record."""
        return tuple(check.note for check in self.checks if check.status in ("note", "fail"))

    @property
    def error(self) -> float:
        """Root mean square of what is left, in the output's unit."""
        return float(np.sqrt(np.mean(self.errors[self.counted] ** 2)))


def validate_fit(
    result: OutputFit,
    record: Record,
    *,
    horizon: float | None = None,
    output: str | None = None,
) -> FitValidation:
    """Hold a fit, frozen, against another record of the axis.

    A record that the fit was not made from says how well it predicts, and which of several models
    does so best. To hold out part of one log, read its parts (`windows` of `read_record`).

    Parameters
    ----------
    result : OutputFit
        Of `fit`.
    record : Record
        Read for the same axis.
    horizon : float, optional
        Length of the windows of an open loop, s; by default that of the fit. The first position and
        velocity of each are fitted to the window itself.
    output : str, optional
        Which of the outputs that the fit follows; by default the first of them.

    Raises
    ------
    UsageError
        The result is no fit, has parameters of its own for each record, or no windows; or the
        record has signals that the fit's axis does not declare.
    DataError
        The record lacks what is compared, or a signal.
    EstimationError
        The record cannot be simulated with these parameters.
    """
    check_record(record)
    length = _horizon(result, horizon)
    followed = _output(result, output)
    axis = result.axes[0]
    _check_signals(axis, record)
    form = InverseForm(axis)
    # Gains of the law are in the axis, and where a loop starts is the record's.
    physical = result.physical[: len(form.physical_quantities)]
    if GAIN in result.names:
        physical = by_declared_gain(axis, physical, result[GAIN].value)
    predictions: Predictions
    if length is not None:
        predictions = WindowPredictions(form, [axis], [record], length)
    else:
        predictions = LoopPredictions(form, [axis], [record], followed)
    with np.errstate(all="ignore"):
        predictions.settle(physical)
        lanes = predictions(physical[None, :])
    if lanes.failures:
        raise EstimationError(
            f"the parameters of the fit do not simulate {record.provenance.source}: "
            f"{lanes.failures[0]}",
            code="fit-validation-lost",
        )
    errors, counted = lanes.errors[:, 0], predictions.counted > 0
    size = float(np.linalg.norm(predictions.measured[counted]))
    percent = 100 * float(np.linalg.norm(errors[counted])) / size if size else float("inf")
    return FitValidation(
        record=record,
        output=followed,
        unit=predictions.units[0],
        horizon=length,
        windows=predictions.spans[0],
        errors=errors,
        samples=predictions.samples[0],
        counted=counted,
        percent=percent,
        checks=tuple(_checks(result, axis, record, followed, percent)),
    )


def _check_signals(axis: GeneratedAxis, record: Record) -> None:
    """Refuse a record with signals of another axis."""
    declared = [signal.name for signal in axis.axis.signals]
    if others := [name for name in record.signals if name not in declared]:
        raise UsageError(
            f"{record.provenance.source} has the signal {others[0]!r}, which the fit's axis "
            f"{axis.axis.name!r} does not declare: it is of another axis. Read the record for "
            "this one, or fit that one.",
            code="validated-fit-signals",
        )


def _checks(
    result: OutputFit, axis: GeneratedAxis, record: Record, output: str, percent: float
) -> Iterator[Check]:
    """Whether the fit holds, and what says that a record is of another axis, or drive."""
    periods = [each.period for each in result.records]
    same = any(math.isclose(record.period, each, rel_tol=_OTHER_PERIOD) for each in periods)
    said = Note(
        f"the record is sampled every {record.period:.6g} s, and what was fitted every "
        f"{periods[0]:.6g} s: see whether it is of the same axis and drive"
    )
    held = "its sample period is that of the fit"
    yield Check.unless("sample period", None if same else said, held, matters=False)
    law = Missing(_NO_LAW) if result.outputs == (OPEN_LOOP,) else check_law(axis, record)
    yield checked_law(law, "the record's control is not the law's of the fit's axis: ")
    own = max(each.percent for each in result.of_records if each.output == output)
    told = f"the simulated {output} is {percent:.3g} % from the recorded one, and {own:.3g} %"
    lost = Note(f"{told} in the fit's own records: see whether axis and load are the same")
    near = is_as_small(percent, own, MAX_VALIDATION_ERROR)
    held = f"{told} at most in the fit's own"
    yield Check.unless("simulation", None if near else lost, held, percent, MAX_VALIDATION_ERROR)


def _horizon(result: object, asked: object) -> float | None:
    """Length of the windows, s; None for a loop without."""
    if not isinstance(result, OutputFit):
        raise UsageError(
            f"the result is {quoted(result)}; give what fit gave.", code="validated-fit-type"
        )
    if {*result.local} - {*STARTS} or result.known:
        raise UsageError(
            "the fit has parameters or known values for each of its records, and nothing says "
            "which are those of another record; fit without them.",
            code="validated-fit-local",
        )
    if asked is None:
        return result.horizon
    if OPEN_LOOP not in result.outputs:
        raise UsageError(
            f"a horizon is given, and the fit follows the {result.output}, which has no windows; "
            "leave it out.",
            code="validated-fit-horizon",
        )
    if not (is_real(asked) and 0 < float(asked) < float("inf")):
        raise UsageError(
            f"the horizon is {quoted(asked)}; give a positive time, s.",
            code="validated-fit-horizon-time",
        )
    return float(asked)


def _output(result: OutputFit, asked: object) -> str:
    """Which output is held against the record."""
    if asked is None:
        return result.outputs[0]
    check_among(("output of the fit", asked, result.outputs))
    return str(asked)
