"""Validation of estimates, or of a fit, on a second record: `validate` and `validate_fit`.

Parameters are frozen, and the output is simulated for the second record. Only the initial positions
and velocities of the windows of an open loop are estimated from the second record.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import OPEN_LOOP, is_output_error
from axisid.estimation.diagnostics import RecordDifference, common_samples, difference_of
from axisid.estimation.diagnostics.control_law import LawAgreement, law_agreement
from axisid.estimation.estimates import Estimate, SamplingDistribution
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.identification import Identification, RecordInfo
from axisid.estimation.methods import METHODS, Bootstrap, estimate_by, filtered_record
from axisid.estimation.noise_models import DEFAULT_TWIN_COUNT
from axisid.estimation.output_error import OutputFit, checked_horizon
from axisid.estimation.output_residuals import (
    ClosedLoopResiduals,
    MultipleShootingResiduals,
    OutputResiduals,
)
from axisid.estimation.records import Record, check_record, law_clock
from axisid.estimation.regression import (
    Hac,
    InverseForm,
    factor,
    least_squares,
    loop_reference,
    simulated_loops,
    simulated_position,
)
from axisid.estimation.signals import FilteredRecord, RowTimes
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.estimation.unknowns import GAIN, INITIAL_STATE_PARAMETERS, by_declared_gain
from axisid.estimation.verdict_checks import Check, Levels, NotUsed, status_of
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.checks import check_among
from axisid.support.errors import DataError, EstimationError, ModelError, UsageError
from axisid.support.missing import Missing
from axisid.support.one_thread import in_one_thread
from axisid.support.settings import setting
from axisid.support.wording import quoted

from .validation_findings import OutputOnRecord, SamplePeriods
from .validation_result import (
    MAX_VALIDATION_ERROR,
    FitValidation,
    MethodValidation,
    Validation,
    checked_law,
    is_as_small,
)


@np.errstate(all="ignore")
@in_one_thread
def validate(
    result: Identification | Any, record: Record, *, like: int | None = None
) -> Validation:
    """Validate every estimate, with frozen parameters, on another record of the axis.

    The errors of the frozen parameters on the second record are computed. The parameters are also
    estimated from the second record by the same methods, and compared with the frozen parameters.

    Parameters
    ----------
    result : Identification or SavedIdentification
        Result whose estimates are validated.
    record : Record
        The second record, read for the same axis. It is filtered like the record of the estimates,
        with the same cut-off frequency in Hz. The prefilter's settings `hold` and `reversals` are
        chosen for the second record, unless the user gave them for the identification.
    like : int, optional
        Number, from 1, of a record of the result whose local parameters (`local`) and known values,
        such as a payload, also apply to this record. Needed if the result has such values.

    Returns
    -------
    Validation
        For each method: the equation error, the errors of the simulated loop, and the difference of
        the parameters between both records. For the second record: the agreement with the declared
        control law, and the share of its samples that the estimates were made from.

    Raises
    ------
    UsageError, DataError
        The record does not suit the prefilter or has no force.
    """
    if not hasattr(result, "estimates"):
        raise UsageError(
            f"the result is {quoted(result)}. Give a result of identify, or load_result(path).",
            code="validation",
        )
    check_record(record)
    own_names = [*result.local_names, *(n for each in result.of_records[:1] for n in each.known)]
    if like is None and own_names:
        raise UsageError(
            f"this result has separate values for each of its records: {', '.join(own_names)}. The "
            "values for the second record are unknown. Give the number of the record with the same "
            f"values: {setting('like', '1')}.",
            code="validation",
        )
    whole, levels = result, result.levels
    if like is not None:
        result = whole.part(like)
    # Settings of the prefilter that were not given are chosen for each record.
    requested = result.requested or result.prefilter
    data = filtered_record(
        result.axis, record, requested.at_period(result.record.period, record.period)
    )
    # A saved result has no samples of its own records.
    own_data = result.problem.data if isinstance(result, Identification) else ()
    law = law_agreement(result.axis, record)
    reestimates = _estimates_of_record(data, [*result.estimates], law)
    # The level is divided by the number of tests, one for each method.
    of_each = replace(levels, level=levels.level / len(result.estimates))
    methods = tuple(
        _validation(data, frozen, own_data, reestimates.get(method), of_each)
        for method, frozen in result.estimates.items()
    )
    return Validation(
        record=record,
        unit=result.axis.coordinate.unit,
        methods=methods,
        known_share=_known_share(
            [of_one.record for of_one in whole.of_records] or [whole.record], record
        ),
        time_base=law_clock(result.axis.control, record).doubt or None,
        law=law,
        levels=levels,
    )


def _estimates_of_record(
    data: FilteredRecord, methods: Sequence[str], law: LawAgreement | Missing
) -> dict[str, Estimate]:
    """Return the estimates from the second record by method, with simulated replicas of the record.

    Methods that fail are missing. `law` is the comparison of the declared law with the record.
    """
    problem = Problem(axis=data.axis, data=(data,))
    found: dict[str, Estimate] = {}
    twins = Bootstrap(
        problem=problem,
        count=DEFAULT_TWIN_COUNT,
        methods=methods,
        has_laws=lambda: isinstance(law, LawAgreement) and law.passed,
    )
    for method in methods:
        with suppress(ModelError, DataError, EstimationError):
            found[method] = estimate_by(problem, METHODS[method], None, "hac", twins)
    return found


def reestimated(frozen: SamplingDistribution, own: Estimate) -> RecordDifference | None:
    """Return the difference between the estimate from a second record and frozen parameters.

    Parameters
    ----------
    frozen : SamplingDistribution
        The estimate that is validated.
    own : Estimate
        Estimate from the second record by the same method.

    Returns
    -------
    RecordDifference or None
        Difference of the values, both minus their bias if it is known for both; None if the second
        record does not determine the parameters.
    """
    second = own.distribution
    before, after = frozen.theta, second.theta
    if frozen.bias is not None and second.bias is not None:
        before, after = frozen.corrected, second.corrected
    covariances = np.array([each.covariances[frozen.chosen] for each in (frozen, second)])
    if not np.all(np.isfinite([after, *covariances[0], *covariances[1]])):
        return None
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    dof = np.array([each.freedom[frozen.chosen] for each in (frozen, second)])
    # Welch and Satterthwaite's degrees of freedom of a difference.
    freedom = variances.sum(axis=0) ** 2 / (variances**2 / dof).sum(axis=0)
    return difference_of(
        {q.name: q.unit for q in own.quantities},
        before,
        after - before,
        covariances.sum(axis=0),
        float(np.nanmin(freedom)),
        (own.X @ np.linalg.solve(own.jacobian, np.diag(after - before)))
        / float(np.linalg.norm(own.y)),
    )


def least_mean_square(residuals: Array, neighbours: RowTimes) -> float:
    """Return a lower confidence limit of the mean square of residuals, (n,).

    It is the mean square minus three of its standard errors (HAC), at least 0; without a standard
    error, it is the mean square. `neighbours` are the times of the rows.
    """
    squares = residuals**2
    mean = float(squares.mean())
    try:
        ones = factor(np.ones((len(squares), 1)), ["mean"], neighbours=neighbours)
        # Squares are not residuals of a fit, which removes slow parts: the kernel alone is enough.
        variance = Hac(widened=False).matrix(least_squares(squares, ones))[0, 0]
    except EstimationError:
        return mean
    return max(mean - MIN_DISTANCE_FROM_NOISE.value * float(np.sqrt(variance)), 0.0)


def _known_share(own: Sequence[RecordInfo], record: Record) -> float:
    """Return the share of a record's samples that the result was estimated from, 0 to 1.

    Samples are recognised by the digest of a whole record, by the log file and the windows that
    were read from it, or by a comparison with the samples of the result's records (`own`). A saved
    result has no samples.
    """
    known = np.zeros(len(record), dtype=bool)
    for each in own:
        if each.digest == record.digest:
            return 1.0
        file = each.provenance.sha256
        if file and file == record.provenance.sha256:
            for start, stop in each.windows or [(-math.inf, math.inf)]:
                known |= (start <= record.time) & (record.time <= stop)
        elif isinstance(each, Record) and (common := common_samples(each, record)):
            known |= common[1]
    return float(np.mean(known))


def _validation(
    data: FilteredRecord,
    estimate: Estimate | Any,
    own_data: Sequence[FilteredRecord],
    second: Estimate | None,
    levels: Levels,
) -> MethodValidation:
    """Return the validation of one estimate on a second record.

    Parameters
    ----------
    data : FilteredRecord
        The second record.
    estimate : Estimate or SavedEstimate
    own_data : sequence of FilteredRecord
        Records of the estimate; empty if unknown.
    second : Estimate or None
        Estimate from the second record by the same method; None if it failed.
    levels : Levels
        Levels of significance and relevance at which the two estimates differ.

    Raises
    ------
    DataError
        The second record has no rows, or its equation error is not finite.
    """
    # Equation error of the frozen parameters on the rows of the second record.
    problem, frozen = Problem(axis=data.axis, data=(data,)), estimate.distribution
    form = METHODS[estimate.method].form(data.axis).at(frozen.theta)
    rows, theta, source = problem.rows(form), form.regressed(frozen.theta), data.record.provenance
    if not len(rows.left):
        raise DataError(
            f"{source.source}: no rows remain, because all samples in motion are masked or near "
            "velocity reversals. Record longer strokes, or identify with this setting of the "
            f"prefilter: {setting('reversals', 'keep')}.",
            code="too-short",
        )
    residuals = rows.residuals(theta)
    # Errors of the simulated loop.
    simulation, position, tracking, reason = None, None, None, None
    try:
        loops, right = problem.simulated(form, frozen.theta)
        force_error = rows.left - right.regressor @ theta - right.intercept
        simulation = relative_error_percent(force_error, rows.left)
        if is_output_error(estimate.method):  # its rows are those of the simulated loop
            residuals = force_error
        if not data.record.integrated:  # the integral of a velocity drifts from the position
            position_error, tracking_error = _position_errors(data, loops)
            position = float(np.sqrt(np.mean(position_error**2)))
            tracking = relative_error_percent(position_error, tracking_error)
    except (ModelError, DataError, EstimationError) as error:
        reason = str(error)
    equation = relative_error_percent(residuals, rows.left)
    if not math.isfinite(equation):
        raise DataError(
            f"{source.source}: the equation error of {estimate.method} is not finite. Check the "
            "size and the units of the columns.",
            code="not-finite",
        )
    # Part of the equation error that is not chance.
    share = math.sqrt(
        least_mean_square(residuals, data.sampling.neighbours) / np.mean(residuals**2)
    )
    # Parameters of the second record.
    difference, changed = None, tuple[str, ...]()
    if second is not None:
        difference = reestimated(frozen, second)
    if difference is not None and difference.matters(levels):
        changed = difference.differing(levels)
    # The tracking error on the estimate's own records is only compared with one on this record.
    own_tracking = None
    if tracking is not None:
        own_tracking = _own_tracking(own_data, frozen.theta)
    return MethodValidation(
        method=estimate.method,
        equation_error_percent=equation,
        own_equation_error_percent=estimate.equation_error_percent,
        simulation_error_percent=simulation,
        position_error_rms=position,
        tracking_error_percent=tracking,
        reason=reason,
        own_simulation_error_percent=estimate.simulation_error_percent,
        own_tracking_error_percent=own_tracking,
        least_equation_error_percent=equation * share,
        reestimate=difference,
        changed=changed,
    )


def _own_tracking(own: Sequence[FilteredRecord], physical: Array) -> float | None:
    """Return the position error of the parameters (p,) on the estimate's own records.

    It is the root mean square relative to that of the tracking error, %. None if the records are
    unknown or have no position, or if a loop cannot be simulated.
    """
    if not own or any(data.record.integrated for data in own):
        return None
    with suppress(ModelError, DataError, EstimationError):
        pairs = [
            _position_errors(data, simulated_loops(data.axis, data.record, physical))
            for data in own
        ]
        position_error, tracking_error = (
            np.concatenate(errors) for errors in zip(*pairs, strict=True)
        )
        return relative_error_percent(position_error, tracking_error)
    return None


def _position_errors(data: FilteredRecord, loops: Sequence[Simulation]) -> tuple[Array, Array]:
    """Return the position error and the tracking error at the m kept samples, (m,) each.

    They are the recorded minus the simulated position, and the reference minus the recorded
    position.
    """
    position, kept = data.record.position, data.sampling.kept
    tracking = loop_reference(data.axis, data.record) - position
    return (position - simulated_position(loops))[kept], tracking[kept]


_OTHER_PERIOD = 1e-3  # relative difference of sampling periods; equal clocks differ by less


@np.errstate(all="ignore")
def validate_fit(
    result: OutputFit,
    record: Record,
    *,
    horizon: float | None = None,
    output: str | None = None,
) -> FitValidation:
    """Validate a fit, with frozen parameters, on another record of the axis.

    The error on a record that the fit was not made from shows how well it predicts, and which of
    several models predicts best. To hold out part of a log, read its parts (`windows` of
    `read_record`).

    Parameters
    ----------
    result : OutputFit
        Result of `fit`.
    record : Record
        Record that was read for the same axis.
    horizon : float, optional
        Length of the windows of an open loop, s; by default that of the fit. The initial position
        and velocity of each window are fitted to the window.
    output : str, optional
        One of the outputs of the fit; by default the first.

    Raises
    ------
    UsageError
        The result is no fit, has local parameters or known values of each record, or no windows; or
        the record has signals that the axis of the fit does not declare.
    DataError
        The record lacks the compared output, or a signal.
    EstimationError
        The record cannot be simulated with these parameters.
    """
    check_record(record)
    if not isinstance(result, OutputFit):
        raise UsageError(
            f"the result is {quoted(result)}. Give a result of fit.", code="validation"
        )
    if {*result.local} - {*INITIAL_STATE_PARAMETERS} or result.known:
        raise UsageError(
            "the fit has local parameters or known values of each record. The values for the "
            "second record are unknown. Fit without local parameters and known values.",
            code="validation",
        )
    length = result.horizon
    if horizon is not None:
        length = checked_horizon(horizon, result.outputs, [record])
    followed = result.outputs[0] if output is None else str(output)
    check_among(("output of the fit", followed, result.outputs))
    axis = result.axes[0]
    if others := [*(record.signals.keys() - {signal.name for signal in axis.signals})]:
        raise UsageError(
            f"{record.provenance.source} has the signal {others[0]!r}, which axis {axis.name!r} of "
            "the fit does not declare. The record was read for another axis. Read the record for "
            "the axis of the fit, or fit the other axis.",
            code="validation",
        )
    form = InverseForm(axis)
    # The axis has the estimated gains of the law, and the record has the initial state of a loop.
    physical = result.physical[: len(form.physical_quantities)]
    if GAIN in result.names:
        physical = by_declared_gain(axis, physical, result[GAIN].value)
    predictions: OutputResiduals
    if length is None:
        predictions = ClosedLoopResiduals(form, [axis], [record], followed)
    else:
        predictions = MultipleShootingResiduals(form, [axis], [record], length)
    predictions.settle(physical)
    lanes = predictions(physical[None, :])
    if lanes.failures:
        raise EstimationError(
            f"{record.provenance.source} cannot be simulated with the parameters of the fit: "
            f"{lanes.failures[0]}",
            code="validation",
        )
    errors, counted = lanes.errors[:, 0], predictions.counted > 0
    percent = relative_error_percent(errors[counted], predictions.measured[counted])
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


def _checks(
    result: OutputFit, axis: GeneratedAxis, record: Record, output: str, percent: float
) -> Iterator[Check]:
    """Yield the checks of a fit on a second record: sampling period, control law, and output.

    Another sampling period or law is a sign that the record is of another axis or drive. `percent`
    is the error of the output on the record (rms), relative to the recorded output (rms), %.
    """
    periods = [each.period for each in result.records]
    equal = any(math.isclose(record.period, each, rel_tol=_OTHER_PERIOD) for each in periods)
    yield Check(
        name="sample period",
        status=status_of(equal, matters=False),
        finding=SamplePeriods(
            of_record=float(record.period), of_fit=float(periods[0]), are_equal=equal
        ),
    )
    if result.outputs == (OPEN_LOOP,):
        yield checked_law(NotUsed("the fit of an open loop uses no control law"), "fit")
    else:
        yield checked_law(law_agreement(axis, record), "fit")
    own = max(each.percent for each in result.of_records if each.output == output)
    holds = is_as_small(percent, own, MAX_VALIDATION_ERROR)
    yield Check(
        name="simulation",
        status=status_of(holds),
        figure=percent,
        threshold=MAX_VALIDATION_ERROR,
        finding=OutputOnRecord(
            output=output, percent=float(percent), own_percent=float(own), holds=holds
        ),
    )
