"""Estimates, or a fit, held against another record: from a result and a record to a `Validation`.

Parameters are frozen, and the output is simulated anew. The windows of an open loop start where
that record is: their first positions and velocities are of it, for whatever parameters are held
against it, and nothing else is.
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
from axisid.support.errors import (
    DataError,
    EstimationError,
    Missing,
    ModelError,
    UsageError,
    check_among,
    quoted,
)
from axisid.support.one_thread import in_one_thread
from axisid.support.settings import setting

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
            code="validation",
        )
    check_record(record)
    own_names = [*result.local_names, *(n for each in result.of_records[:1] for n in each.known)]
    if like is None and own_names:
        raise UsageError(
            f"{', '.join(own_names)} of this result {'is' if len(own_names) == 1 else 'are'} each "
            "record's own or known of each, and nothing says what holds of another record; "
            "name the record that it is like: validate-like=1.",
            code="validation",
        )
    whole, levels = result, result.levels
    result = whole if like is None else whole.part(like)
    requested = result.requested or result.prefilter  # what was left open suits each record
    data = filtered_record(
        result.axis, record, requested.at_period(result.record.period, record.period)
    )
    own_data = result.problem.data if isinstance(result, Identification) else ()
    law = law_agreement(result.axis, record)
    anew = _estimated_anew(data, [*result.estimates], law)
    of_each = replace(levels, level=levels.level / len(result.estimates))
    methods = tuple(
        _validation(data, frozen, own_data, anew.get(method), of_each)
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


def _estimated_anew(
    data: FilteredRecord, methods: Sequence[str], law: LawAgreement | Missing
) -> dict[str, Estimate]:
    """The second record's own estimates, with its twins; without those that it does not give."""
    problem, found = Problem(axis=data.axis, data=(data,)), {}
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
    """What a second record has more than frozen parameters, by its own estimate of one method.

    Parameters
    ----------
    frozen : SamplingDistribution
    own : Estimate
        Of the second record.

    Returns
    -------
    RecordDifference or None
        Less their bias where that is known of both; None where the second record's own tell
        nothing.
    """
    anew = own.distribution
    both_biases = frozen.bias is not None and anew.bias is not None
    before, after = (each.corrected if both_biases else each.theta for each in (frozen, anew))
    covariances = np.array([each.covariances[frozen.chosen] for each in (frozen, anew)])
    if not np.all(np.isfinite([after, *covariances[0], *covariances[1]])):
        return None
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    dof = np.array([each.freedom[frozen.chosen] for each in (frozen, anew)])
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
    """The least mean square that residuals (n,) stand for, where a few slow waves are all of it."""
    squares = residuals**2
    mean = float(squares.mean())
    try:
        ones = factor(np.ones((len(squares), 1)), ["mean"], neighbours=neighbours)
        # Squares are no errors that a fit has taken the slow part of: the kernel's is enough.
        variance = Hac(widened=False).matrix(least_squares(squares, ones))[0, 0]
    except EstimationError:
        return mean
    return max(mean - MIN_DISTANCE_FROM_NOISE.value * float(np.sqrt(variance)), 0.0)


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
            for start, stop in each.windows or [(-math.inf, math.inf)]:
                known |= (start <= record.time) & (record.time <= stop)
        elif isinstance(each, Record) and (common := common_samples(each, record)):
            known |= common[1]
    return float(np.mean(known))


def _validation(
    data: FilteredRecord,
    estimate: Estimate | Any,
    own_data: Sequence[FilteredRecord],
    again: Estimate | None,
    levels: Levels,
) -> MethodValidation:
    """How an estimate holds on a second record, its own records being these.

    Parameters
    ----------
    data : FilteredRecord
        The second record.
    estimate : Estimate or SavedEstimate
    own_data : sequence of FilteredRecord
        What it was made from, where that is known.
    again : Estimate or None
        The second record's own, by the same method.
    levels : Levels
        From when on the two are others.
    """
    problem, frozen = Problem(axis=data.axis, data=(data,)), estimate.distribution
    form = METHODS[estimate.method].form(data.axis).at(frozen.theta)
    rows, theta, source = problem.rows(form), form.regressed(frozen.theta), data.record.provenance
    if not len(rows.left):
        raise DataError(
            f"{source.source}: no row is left of it, since all its motion is near reversals "
            "or masked. Record longer strokes, or identify with the prefilter's "
            f"{setting('reversals', 'keep')}.",
            code="too-short",
        )
    residuals = rows.residuals(theta)
    simulation, position, tracking, reason = None, None, None, None
    try:
        loops, right = problem.simulated(form, frozen.theta)
        apart = rows.left - right.regressor @ theta - right.intercept
        simulation = relative_error_percent(apart, rows.left)
        if is_output_error(estimate.method):  # whose rows are the loop's
            residuals = apart
        if not data.record.integrated:  # the velocity's integral drifts from where the axis was
            off, wanted = _positions(data, loops)
            position = float(np.sqrt(np.mean(off**2)))
            tracking = relative_error_percent(off, wanted)
    except (ModelError, DataError, EstimationError) as error:
        reason = str(error)
    if not math.isfinite(equation := relative_error_percent(residuals, rows.left)):
        raise DataError(
            f"{source.source}: the equation error of {estimate.method} is not finite; check the "
            "size and the units of its columns.",
            code="not-finite",
        )
    chance = math.sqrt(
        least_mean_square(residuals, data.sampling.neighbours) / np.mean(residuals**2)
    )
    anew = None if again is None else reestimated(frozen, again)
    return MethodValidation(
        method=estimate.method,
        equation_error_percent=equation,
        own_equation_error_percent=estimate.equation_error_percent,
        simulation_error_percent=simulation,
        position_error_rms=position,
        tracking_error_percent=tracking,
        reason=reason,
        own_simulation_error_percent=estimate.simulation_error_percent,
        own_tracking_error_percent=None
        if tracking is None
        else _own_tracking(own_data, frozen.theta),
        least_equation_error_percent=equation * chance,
        reestimate=anew,
        changed=anew.differing(levels) if anew is not None and anew.matters(levels) else (),
    )


def _own_tracking(own: Sequence[FilteredRecord], physical: Array) -> float | None:
    """The same error on the estimate's own records, where they and their loops are there."""
    if not own or any(data.record.integrated for data in own):
        return None
    with suppress(ModelError, DataError, EstimationError):
        pairs = [
            _positions(data, simulated_loops(data.axis, data.record, physical)) for data in own
        ]
        off, tracking = (np.concatenate(side) for side in zip(*pairs, strict=True))
        return relative_error_percent(off, tracking)
    return None


def _positions(data: FilteredRecord, loops: Sequence[Simulation]) -> tuple[Array, Array]:
    """Recorded less simulated position, and reference less recorded position."""
    position, kept = data.record.position, data.sampling.kept
    tracking = loop_reference(data.axis, data.record) - position
    return (position - simulated_position(loops))[kept], tracking[kept]


_OTHER_PERIOD = 1e-3  # relative difference of sample periods: clocks agree to less


@np.errstate(all="ignore")
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
    if not isinstance(result, OutputFit):
        raise UsageError(f"the result is {quoted(result)}; give what fit gave.", code="validation")
    if {*result.local} - {*INITIAL_STATE_PARAMETERS} or result.known:
        raise UsageError(
            "the fit has parameters or known values for each of its records, and nothing says "
            "which are those of another record; fit without them.",
            code="validation",
        )
    length = (
        result.horizon if horizon is None else checked_horizon(horizon, result.outputs, [record])
    )
    followed = result.outputs[0] if output is None else str(output)
    check_among(("output of the fit", followed, result.outputs))
    axis = result.axes[0]
    if others := [*(record.signals.keys() - {signal.name for signal in axis.signals})]:
        raise UsageError(
            f"{record.provenance.source} has the signal {others[0]!r}, which the fit's axis "
            f"{axis.name!r} does not declare: it is of another axis. Read the record for "
            "this one, or fit that one.",
            code="validation",
        )
    form = InverseForm(axis)
    # Gains of the law are in the axis, and where a loop starts is the record's.
    physical = result.physical[: len(form.physical_quantities)]
    if GAIN in result.names:
        physical = by_declared_gain(axis, physical, result[GAIN].value)
    predictions: OutputResiduals = (
        ClosedLoopResiduals(form, [axis], [record], followed)
        if length is None
        else MultipleShootingResiduals(form, [axis], [record], length)
    )
    predictions.settle(physical)
    if (lanes := predictions(physical[None, :])).failures:
        raise EstimationError(
            f"the parameters of the fit do not simulate {record.provenance.source}: "
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
    """Yield the checks of the fit, and of signs that the record is of another axis or drive."""
    periods = [each.period for each in result.records]
    equal = any(math.isclose(record.period, each, rel_tol=_OTHER_PERIOD) for each in periods)
    yield Check(
        name="sample period",
        status=status_of(equal, matters=False),
        finding=SamplePeriods(
            of_record=float(record.period), of_fit=float(periods[0]), are_equal=equal
        ),
    )
    yield checked_law(
        NotUsed("the fit of an open loop uses no control law")
        if result.outputs == (OPEN_LOOP,)
        else law_agreement(axis, record),
        "the recorded control does not follow the law of the fit's axis: ",
    )
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
