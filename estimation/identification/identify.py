"""The pipeline: from an axis and its records to estimates, method by method.

The estimate within declared bounds is the point within them that is nearest to the free one, by the
covariance of independent residuals; of least squares that is the bounded least squares of the same
rows. What it has at a bound is held, the others are identified anew with it, until none goes beyond
its bound. What a bound holds is not known, so the others are as unsure as its parameter lets them
be: they have the covariance that they have without bounds. The bounded estimate is, by that
covariance, nearer to whatever is within the bounds than the free one is, so that it is enough.

A drive's lag or delay makes the force act where the motion shows it: the loop is simulated with it,
and the delay that the alignment finds beside it is added, until there is none. A lag, a delay and
the half sample of the hold move the force alike at the frequencies of a motion: a record shows
their sum, so that at most one of them can be estimated, and the others are to be known.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import stdtrit

from axisid.codegen.generated_axes import GeneratedAxis, as_generated, build
from axisid.estimation.bootstrap import DEFAULT_COUNT, check_count
from axisid.estimation.choices import INSTRUMENT_STARTS, ROW_LOSSES, is_output_error
from axisid.estimation.diagnostic_checks import DEFAULT_LEVELS, Levels, unless_faulty
from axisid.estimation.diagnostics import Case
from axisid.estimation.estimates import COVARIANCES, Estimate, student_interval
from axisid.estimation.estimation_problem import ParameterAtBound, Problem, check_has_rows
from axisid.estimation.methods import METHODS, Bootstrap, estimate_by
from axisid.estimation.parameters import KnownValue, bounded_quadratic_minimum
from axisid.estimation.records import Record, check_record
from axisid.estimation.regression import LoopDataError, covariance_root
from axisid.estimation.signals import Prefilter
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.modeling.declaration import HIDDEN_FROM, Axis, leave_out
from axisid.modeling.quantities import Parameter
from axisid.support.errors import (
    AxisidError,
    EstimationError,
    Missing,
    ModelError,
    UsageError,
    check_among,
    listed,
    refuse,
)

from .joint_records import shared_records
from .result import DriveTime, Identification

#: Identifies an axis by methods; None for all that axis and record allow.
Identify = Callable[[GeneratedAxis, Sequence[str] | None], Identification]


def identify(
    axis: Axis | GeneratedAxis,
    record: Record | Sequence[Record],
    prefilter: Prefilter | None = None,
    methods: Sequence[str] | None = None,
    *,
    lags: int | None = None,
    covariance: str = "hac",
    local: str | Sequence[str] = (),
    known: Mapping[str, Sequence[KnownValue]] | None = None,
    gain: str = "identified",
    skip_bad: bool = False,
    start: str = INSTRUMENT_STARTS[0],
    loss: str = ROW_LOSSES[0],
    bounded: bool = False,
    bootstrap: int = DEFAULT_COUNT,
    level: float = DEFAULT_LEVELS.level,
    least_share: float = DEFAULT_LEVELS.least_share,
) -> Identification:
    """Identify an axis from a record, or from several of them together.

    Several records are one regression: their rows stand one after the other, none the neighbour of
    another record's, each record weighted by its own noise. Each is filtered, simulated and checked
    by itself.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record or sequence of Record
        They may differ in period, length and columns.
    prefilter : Prefilter, optional
        The paper's appropriate filter by default. What it leaves open of cut-off and decimation
        follows the record's rate, see `Prefilter`. Of several records it is that of the first; the
        decimation of the others is such that rows are as far apart in all.
    methods : str or sequence of str, optional
        Of `METHODS`. By default (None, ``"all"``) all that the axis and the record allow; what they
        do not allow is in `Identification.skipped`, what came to nothing in
        `Identification.failed`.
    lags : int, optional
        Of the autocorrelation-consistent covariance; chosen from the data by default.
    covariance : str
        Of `COVARIANCES`, ``hac``, ``robust`` or ``iid``: what intervals, draws and the curvatures
        are of. All deviations are given whichever is chosen.
    local : str or sequence of str
        Declared parameters that each record has for itself, such as an amplifier's offset. Result
        ``result.local["tau0"]`` has one value for each record.
    known : mapping of str to sequence, optional
        What is known of each record: a declared parameter (a payload, an angle, a temperature) or a
        gain of the control law, by name, with a value for each record, SI, or a value and its
        standard deviation: ``{"m_add": [0.0, (20.0, 0.01)]}``.
    gain : {"identified", "declared"}
        Where a known force makes the drive gain known, ``drive_gain`` is a parameter with the
        others, whose deviations contain its own; or the declared gain is believed.
    skip_bad : bool
        Go on without records that cannot be used; they are in `Identification.set_aside`.
    start : {"least-squares", "nominal"}
        Where instruments start to iterate, which end at the same estimate: at least squares where
        its simulated loop follows the records, or at the nominal values, as published; see
        `Estimate.started`. A model that is not linear starts at least squares.
    loss : {"squares", "huber", "bisquare"}
        How rows count: by squares, or for less the larger their residual is, so that shocks and
        rounded reversals lead less.
    bounded : bool
        Hold a declared parameter that the judged method would have beyond its bound, less the
        filter's own bias, at that bound, and identify the others; see `Identification.held`. Else,
        and of sums of parameters and each record's own, it is reported, not clipped.
    bootstrap : int
        How many twins of the records tell bias and HAC deviations: their loops once more, with the
        noise that was measured in them. 0 for
        none: deviations then are those of neighbouring rows, and no bias is known.
    level, least_share : float
        Chance that a check tells anything of a right model, over all that it looks for, and part of
        the force, or of a parameter, from which that matters.

    Raises
    ------
    UsageError, DataError, ModelError, EstimationError
        See each. A method that is asked for by name and does not suit axis or records raises; one
        that comes to nothing does where no other gives an estimate.
    """
    if isinstance(axis, Axis):
        check_has_rows(axis)  # before it is derived, which may take seconds
    generated = as_generated(axis)
    check_has_rows(generated.axis)
    records = records_of(record)
    check_choices(covariance, start, loss)
    check_count(bootstrap)
    levels = Levels(level=level, least_share=least_share)
    requested = requested_methods(methods)
    as_given = Prefilter.given(prefilter).at_rate_of(records[0].period)

    def run(tried: GeneratedAxis, chosen: Sequence[str] | None) -> Identification:
        def free(axis: GeneratedAxis) -> Identification:
            shared = shared_records(axis, records, as_given, local, known, gain, skip_bad=skip_bad)
            return identify_problem(
                shared.problem(axis, as_given, loss),
                as_given,
                chosen,
                lags=lags,
                covariance=covariance,
                set_aside=shared.set_aside,
                start=start,
                loss=loss,
                bootstrap=bootstrap,
                levels=levels,
            )

        return bounded_result(tried, free) if bounded else free(tried)

    if generated.declared.drive.estimated is not None:
        return identified_with_time(generated, records, run, requested)
    return run(generated, requested)


def records_of(record: object) -> list[Record]:
    """The records that a result is to be made from, one or several.

    Raises
    ------
    UsageError
        There is none, or something else among them.
    """
    listed = isinstance(record, (Sequence, Iterator)) and not isinstance(record, (str, bytes))
    records = list(record) if listed and isinstance(record, Iterable) else [record]
    if not records:
        raise UsageError(
            "no record is given; give one or more, read by read_record(path, axis).",
            code="record",
        )
    for each in records:
        check_record(each)
    return [each for each in records if isinstance(each, Record)]


def identify_problem(
    problem: Problem,
    as_given: Prefilter,
    requested: Sequence[str] | None,
    *,
    lags: int | None = None,
    covariance: str = "hac",
    set_aside: Mapping[str, str] | None = None,
    start: str,
    loss: str = ROW_LOSSES[0],
    bootstrap: int = DEFAULT_COUNT,
    levels: Levels = DEFAULT_LEVELS,
) -> Identification:
    """`identify` from records that are filtered already, by the prefilter that was asked for."""
    estimates, skipped, failed = dict[str, Estimate](), dict[str, str](), dict[str, str]()
    lost: EstimationError | None = None
    chosen = [*METHODS] if requested is None else requested
    twins = Bootstrap(
        problem=problem,
        count=bootstrap,
        methods=chosen,
        has_laws=lambda: Case(problem=problem, estimates={}).laws_hold,
        loss=loss,
    )
    for method in dict.fromkeys(chosen):
        try:
            # What is not finite is refused by name; NumPy's own warnings would only repeat it.
            with np.errstate(all="ignore"):
                estimates[method] = estimate_by(
                    problem,
                    replace(METHODS[method], start=start, loss=loss),
                    lags,
                    covariance,
                    twins if bootstrap else None,
                )
        except (ModelError, LoopDataError) as error:
            if requested is not None:
                raise
            skipped[method] = str(error)
        except EstimationError as error:
            if requested is None and not estimates:
                raise
            # Nobody asked for it, and it rests on more than the others: they stand without it.
            unasked = requested is None and is_output_error(method)
            (skipped if unasked else failed)[method] = str(error)
            lost = lost or error
    if lost is not None and not estimates:
        raise lost
    return Identification(
        problem=problem,
        estimates=estimates,
        skipped=skipped,
        failed=failed,
        requested=as_given,
        set_aside=set_aside or {},
        levels=levels,
    )


def requested_methods(methods: str | Iterable[object] | None) -> tuple[str, ...] | None:
    """The methods that are asked for by name; None for all, which is also called ``all``.

    Raises
    ------
    UsageError
        There is none, or none of that name.
    """
    names = tuple(map(str, listed("all" if methods is None else methods)))
    if "all" in names:
        return None
    check_among(*(("method", method, METHODS) for method in names))
    if not names:
        raise UsageError(f"no method is given; choose from {', '.join(METHODS)}.", code="method")
    return names


def check_choices(covariance: object, start: object, loss: object) -> None:
    """Refuse what `identify` has no choice of.

    Raises
    ------
    UsageError
        There is no such covariance, start or loss.
    """
    check_among(
        ("covariance", covariance, COVARIANCES),
        ("start", start, INSTRUMENT_STARTS),
        ("loss", loss, ROW_LOSSES),
    )


def bounded_result(
    axis: GeneratedAxis, identify: Callable[[GeneratedAxis], Identification]
) -> Identification:
    """What is identified with every declared parameter within its bounds, by the judged method.

    Its covariances are those of the free estimates: a parameter that is held is not known.

    Parameters
    ----------
    axis : GeneratedAxis
    identify : callable

    Raises
    ------
    EstimationError
        Nothing is left to identify, or no inertia, with the parameters at their bounds.
    """
    result = free = identify(axis)
    bounds: dict[str, float] = {}
    while beyond := _at_bounds(axis, result.preferred):
        bounds |= beyond
        result = identify(_axis_with(axis, bounds))
    if not bounds:
        return free
    held = []
    for name, bound in bounds.items():
        others = {other: at for other, at in bounds.items() if other != name}
        without = identify(_axis_with(axis, others)) if others else free
        held.append(_held(without.preferred, axis, name, bound))
    estimates = {
        method: _as_unsure(estimate, free.estimates.get(method, estimate))
        for method, estimate in result.estimates.items()
    }
    return replace(result, problem=replace(result.problem, held=tuple(held)), estimates=estimates)


def _axis_with(axis: GeneratedAxis, bounds: Mapping[str, float]) -> GeneratedAxis:
    """An axis whose parameters at a bound are held there."""
    try:
        return build(leave_out(axis.declared, **bounds), native=axis.native.enabled)
    except AxisidError as error:
        said = ", ".join(f"{name} at its bound {bound:g}" for name, bound in bounds.items())
        raise EstimationError(
            f"with {said} there is no axis left: {str(error).rstrip('.')}. Check the signs "
            "and units of the record.",
            code="bounds",
        ) from error


def _as_unsure(estimate: Estimate, free: Estimate) -> Estimate:
    """The same with the covariances that its parameters have where nothing is held."""
    names, own = ([q.name for q in each] for each in (free.quantities, free.ddm_quantities))
    try:
        at = [names.index(q.name) for q in estimate.quantities]
        of_ddm = [own.index(q.name) for q in estimate.ddm_quantities]
    except ValueError:  # what is held regrouped the others
        return estimate
    return estimate.with_inference(
        covariances={n: each[np.ix_(at, at)] for n, each in free.covariances.items()},
        covariance_names=free.covariance_names,
        ddm_covariances={
            n: each[np.ix_(of_ddm, of_ddm)] for n, each in free.ddm_covariances.items()
        },
        freedom={n: each[at] for n, each in free.freedom.items()},
        ddm_freedom={n: each[of_ddm] for n, each in free.inference.ddm_freedom.items()},
    )


def _at_bounds(axis: GeneratedAxis, estimate: Estimate) -> dict[str, float]:
    """Declared parameters that the bounded estimate has at a bound, with that bound."""
    names, free = {p.name for p in axis.declared.parameters}, estimate.corrected
    declared = [p if p.name in names else None for p in estimate.form.declared]
    if all(p is None or p.allows(x) for p, x in zip(declared, free, strict=True)):
        return {}
    lower = np.array([-np.inf if p is None else p.lower for p in declared])
    upper = np.array([np.inf if p is None else p.upper for p in declared])
    covariance = estimate.covariances["iid"]
    scale = np.sqrt(np.diag(covariance))
    rows = np.linalg.pinv(covariance_root(covariance) / scale[:, None]) / scale
    _, sides = bounded_quadratic_minimum(lower, upper, free, rows, np.zeros(len(free)))
    return {
        p.name: p.lower if side < 0 else p.upper
        for p, side in zip(declared, sides, strict=True)
        if p and side
    }


def _held(estimate: Estimate, axis: GeneratedAxis, name: str, bound: float) -> ParameterAtBound:
    """A parameter at its bound, and what it is in an estimate that has it free."""
    value = estimate.parameters[name]
    is_lower = any((p.name, p.lower) == (name, bound) for p in axis.declared.parameters)
    dof = dict(zip(estimate.parameters, estimate.freedom[estimate.chosen], strict=True))[name]
    away = float(stdtrit(dof, INTERVAL_LEVEL.value)) * value.deviation
    reach = value.corrected + (away if is_lower else -away)
    return ParameterAtBound(
        name=name,
        unit=value.unit,
        bound=bound,
        is_lower=is_lower,
        free=value.corrected,
        deviation=value.deviation,
        reach=max(bound, reach) if is_lower else min(bound, reach),
    )


def at_time(axis: GeneratedAxis, name: str, value: float) -> GeneratedAxis:
    """The axis with another lag or delay of its drive, s, which is then known.

    To compile its loop takes less than a search without does.
    """
    drive = axis.declared.drive.with_time(name, value)
    return build(replace(axis.declared, drive=drive), native=axis.native.enabled)


def identified_with_time(
    axis: GeneratedAxis,
    records: Sequence[Record],
    run: Identify,
    methods: Sequence[str] | None,
) -> Identification:
    """Identify an axis whose drive has a lag or a delay that is estimated too.

    Every deviation of the parameters has in it what that of the time adds: the estimates are made
    once more with the time a deviation longer.

    Raises
    ------
    UsageError
        There are several records, or the control was recorded where nothing shows the time.
    EstimationError
        The record does not show it, or the force acts before its command.
    """
    declared = axis.declared
    name, parameter = declared.drive.estimated or ("lag", Parameter("lag", "s"))
    if len(records) > 1:
        raise UsageError(
            f"axis {declared.name!r}: the drive's {name} is to be estimated, which one record "
            f"tells, and {len(records)} are given; identify it from one of them, and declare it as "
            "a number for all.",
            code="drive-time",
        )
    value, deviation = _searched(axis, records[0], name, run)
    result = run(at_time(axis, name, value), methods)
    longer = run(at_time(axis, name, value + deviation), [*result.estimates])
    judged = result.preferred
    low, high = student_interval(value, deviation, float(len(judged.y) - len(judged.theta)))
    return replace(
        result,
        estimates={n: _widened(e, longer.estimates[n]) for n, e in result.estimates.items()},
        drive_time=DriveTime(
            name=name,
            parameter=parameter,
            value=value,
            deviation=deviation,
            interval=(max(low, 0.0), high),
        ),
    )


def _searched(axis: GeneratedAxis, record: Record, name: str, run: Identify) -> tuple[float, float]:
    """The lag or the delay with which force and motion are aligned, and its deviation, s."""
    declared, period = axis.declared, record.period
    check_time(declared, record, name)
    value = float(getattr(declared.drive, name))
    for _ in range(10):
        result = run(at_time(axis, name, value), ["idm-iv"])
        alignment = unless_faulty(partial(getattr, result.case.parts[0], "alignment"))
        if isinstance(alignment, Missing) or alignment.at_the_end:
            unseen = "the record tells no delay between force and motion"
            why = alignment if isinstance(alignment, Missing) else unseen
            raise EstimationError(
                f"axis {declared.name!r}: the drive's {name} cannot be estimated: {why}.",
                code="drive-time",
            )
        step, deviation = (
            (alignment.best - result.data.hold_delay) * period,
            alignment.deviation * period,
        )
        # It has settled within a twentieth of its deviation, or what rounding does not reach.
        near = max(0.05 * deviation, 1e-9 * period)
        if abs(step) < near or (value == 0 and step <= 0):
            break
        value = max(value + step, 0.0)
    else:
        raise EstimationError(
            f"axis {declared.name!r}: the estimate of the drive's {name} does not settle; it is "
            f"about {value:.3g} s. See whether the law and the model are right.",
            code="no-convergence",
        )
    if step < -2 * deviation:
        raise EstimationError(
            f"axis {declared.name!r}: the force acts {-step:.3g} s before its command, so there is "
            f"no {name} to estimate; see whether the control is logged late, and its hold.",
            code="drive-time",
        )
    return value, deviation


def _widened(estimate: Estimate, longer: Estimate) -> Estimate:
    """An estimate whose covariances have in them that a time may be a deviation longer."""
    changes = {
        "covariances": longer.physical - estimate.physical,
        "ddm_covariances": longer.theta_ddm - estimate.theta_ddm,
    }
    return estimate.with_inference(
        **{
            which: {n: each + np.outer(by, by) for n, each in getattr(estimate, which).items()}
            for which, by in changes.items()
        }
    )


def check_time(declared: Axis, record: Record, name: str, *, by_law: bool = True) -> None:
    """Refuse a time that a record cannot show, of a loop under a law or of one without.

    Raises
    ------
    UsageError
        The control was recorded where nothing shows it.
    """
    law = declared.control
    unsampled = by_law and (law is None or law.continuous)
    refuse(
        UsageError,
        (
            unsampled or record.force is not None or record.control is None,
            f"axis {declared.name!r}: the drive's {name} is told by a recorded control"
            f"{' of a sampled law' * by_law}, and by no force that was measured",
        ),
        (
            declared.drive.logged in HIDDEN_FROM[name],
            f"axis {declared.name!r}: the control was recorded behind the drive's {name} "
            f"(logged={declared.drive.logged!r}), so that the motion does not show it",
        ),
        code="drive-time",
    )
