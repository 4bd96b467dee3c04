"""The pipeline: from an axis and its records to estimates, method by method."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.choices import INSTRUMENT_STARTS, ROW_LOSSES, is_output_error
from axisid.estimation.diagnostics.control_law import RecordLaws
from axisid.estimation.estimates import COVARIANCES, Estimate
from axisid.estimation.estimation_problem import Problem, check_has_rows
from axisid.estimation.methods import METHODS, Bootstrap, estimate_by
from axisid.estimation.noise_models import DEFAULT_TWIN_COUNT, check_twin_count
from axisid.estimation.records import Record, check_record
from axisid.estimation.regression import LoopDataError
from axisid.estimation.signals import Prefilter
from axisid.estimation.unknowns import KnownValue
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Levels
from axisid.modeling.declaration import Axis
from axisid.support.checks import check_among, listed
from axisid.support.errors import EstimationError, ModelError, UsageError
from axisid.support.one_thread import in_one_thread

from .bounded_identification import axis_at_bounds, bounded_identification
from .drive_delay_estimation import identify_with_drive_time
from .joint_records import joint_records
from .result import Identification


@in_one_thread
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
    bootstrap: int = DEFAULT_TWIN_COUNT,
    level: float = DEFAULT_LEVELS.level,
    least_share: float = DEFAULT_LEVELS.least_share,
    judge: bool = True,
) -> Identification:
    """Identify an axis from a record, or from several of them together.

    Several records make one regression with the rows of all records. Rows of different records are
    not neighbours. Each record is weighted by its own noise, and is filtered, simulated and checked
    separately.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record or sequence of Record
        They may differ in period, length and columns.
    prefilter : Prefilter, optional
        The paper's appropriate filter by default. Cut-off and decimation that it does not give are
        chosen by the rate of the record, see `Prefilter`. For several records it is the filter of
        the first. The decimation of the others gives rows at the same distance in time.
    methods : str or sequence of str, optional
        One or more of `METHODS`. By default (None, ``"all"``) all methods that the axis and the
        record allow. Methods that they do not allow are in `Identification.skipped`, failed methods
        in `Identification.failed`.
    lags : int, optional
        Lags of the autocorrelation-consistent covariance; chosen from the data by default.
    covariance : str
        One of `COVARIANCES`, ``hac``, ``robust`` or ``iid``, for intervals, draws and curvatures.
        All standard errors are given whichever is chosen.
    local : str or sequence of str
        Declared parameters with a separate value in each record, such as an amplifier's offset. The
        values of ``"tau0"`` are ``result.local["tau0"]``, one for each record.
    known : mapping of str to sequence, optional
        Known values of each record: a declared parameter (a payload, an angle, a temperature) or a
        gain of the control law, by name, with a value for each record, SI, or a value and its
        standard deviation: ``{"m_add": [0.0, (20.0, 0.01)]}``.
    gain : {"identified", "declared"}
        Identified: where a known force shows the drive gain, ``drive_gain`` is an additional
        parameter, and the standard errors of the others include its uncertainty. Declared: the
        declared gain is used.
    skip_bad : bool
        Continue without records that cannot be used; they are in `Identification.set_aside`.
    start : {"least-squares", "nominal"}
        Start of the iteration of the instruments: least squares, where its simulated loop follows
        the records, or the nominal values, as published; see `Estimate.started`. Both lead to the
        same estimate. A nonlinear model starts from least squares.
    loss : {"squares", "huber", "bisquare"}
        Loss of the rows: squares, or a robust loss with less weight for rows with large residuals,
        such as shocks and rounded reversals.
    bounded : bool
        Fix a declared parameter at its bound if its estimate by the reported method, minus the bias
        of the filter, is beyond it, and identify the others; see `Identification.held`. Otherwise,
        and for sums of parameters and local parameters, estimates beyond a bound are reported, not
        clipped.
    bootstrap : int
        Number of simulated replicas of the records for bias and HAC standard errors: their loops
        are simulated again with the noise that was measured in them. With 0, the standard errors
        are those of the rows, and no bias is known.
    level, least_share : float
        Probability that a check reports an error of a correct model, over all hypotheses, and part
        of the force, or of a parameter, from which an error is relevant.
    judge : bool
        True to compute the bias, the intervals and the verdict before the result is returned. With
        False each is computed when a property that needs it is read.

    Raises
    ------
    UsageError, DataError, ModelError, EstimationError
        See each class. A method that is requested by name raises if it does not suit axis or
        records. A method that fails raises only if no other method gives an estimate.
    """
    if isinstance(axis, Axis):
        check_has_rows(axis)  # before the derivation of the axis, which may take seconds
    generated = as_generated(axis)
    check_has_rows(generated.axis)
    records = records_of(record)
    check_choices(covariance, start, loss)
    check_twin_count(bootstrap)
    levels = Levels(level=level, least_share=least_share)
    requested = requested_methods(methods)
    as_given = Prefilter.given(prefilter).at_rate_of(records[0].period)

    def identified(
        axis_with_drive: GeneratedAxis,
        by_methods: Sequence[str] | None,
        fixed: Mapping[str, float] | None = None,
    ) -> Identification:
        """Return the identification of an axis whose lag and delay are numbers, by some methods.

        `by_methods` has the names of the methods, or is None for all that axis and records allow.
        `fixed` has the parameters that are fixed, with their bounds; no other parameter is fixed
        then. With None, every parameter that is beyond its bound is fixed there if `bounded` is
        True.
        """

        def without_bounds(axis: GeneratedAxis) -> Identification:
            """Return the identification of an axis without regard to bounds."""
            shared = joint_records(axis, records, as_given, local, known, gain, skip_bad=skip_bad)
            return identify_problem(
                shared.problem(axis, as_given, loss),
                as_given,
                by_methods,
                lags=lags,
                covariance=covariance,
                set_aside=shared.set_aside,
                start=start,
                loss=loss,
                bootstrap=bootstrap,
                levels=levels,
            )

        if fixed:
            return without_bounds(axis_at_bounds(axis_with_drive, fixed))
        if bounded and fixed is None:
            return bounded_identification(axis_with_drive, without_bounds)
        return without_bounds(axis_with_drive)

    if generated.declared.drive.estimated is not None:
        result = identify_with_drive_time(generated, records, identified, requested)
    else:
        result = identified(generated, requested)
    return result.judged() if judge else result


def records_of(record: object) -> list[Record]:
    """Return one or several given records as a list.

    Raises
    ------
    UsageError
        There is no record, or something that is not a record.
    """
    is_several = isinstance(record, (Sequence, Iterator)) and not isinstance(record, (str, bytes))
    records = list(record) if is_several and isinstance(record, Iterable) else [record]
    if not records:
        raise UsageError(
            "no record is given. Give one or more records, as from read_record(path, axis).",
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
    bootstrap: int = DEFAULT_TWIN_COUNT,
    levels: Levels = DEFAULT_LEVELS,
) -> Identification:
    """Return the identification from records that are already filtered, by each method in turn.

    Parameters
    ----------
    problem : Problem
        The filtered records as one regression.
    as_given : Prefilter
        Prefilter as requested, for the result.
    requested : sequence of str or None
        Methods to run; None for all methods. A requested method that axis or records do not allow
        raises its error. With None it is skipped, with the reason.
    lags, covariance, start, loss, bootstrap
        As in `identify`.
    set_aside : mapping of str to str, optional
        Records that could not be used, with the reason, for the result.
    levels : Levels
        Thresholds of the checks.

    Raises
    ------
    ModelError, LoopDataError
        The axis, or a record, does not allow a requested method.
    EstimationError
        No method gives an estimate.
    """
    estimates, skipped, failed = dict[str, Estimate](), dict[str, str](), dict[str, str]()
    first_failure: EstimationError | None = None
    chosen = [*METHODS] if requested is None else requested
    laws = RecordLaws.of(problem.data)
    twins = Bootstrap(
        problem=problem,
        count=bootstrap,
        methods=chosen,
        has_laws=lambda: laws.hold,
        loss=loss,
    )
    for method in dict.fromkeys(chosen):
        try:
            # Values that are not finite are refused by name. NumPy's warnings would only repeat it.
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
            # Output error relies on more assumptions than the other methods. If it was not
            # requested, its failure says nothing about the estimates of the other methods.
            if requested is None and is_output_error(method):
                skipped[method] = str(error)
            else:
                failed[method] = str(error)
            first_failure = first_failure or error
    if first_failure is not None and not estimates:
        raise first_failure
    return Identification(
        problem=problem,
        estimates=estimates,
        skipped=skipped,
        failed=failed,
        requested=as_given,
        set_aside=set_aside or {},
        levels=levels,
        compared_laws=laws,
    )


def requested_methods(methods: str | Iterable[object] | None) -> tuple[str, ...] | None:
    """Return the names of the requested methods; None where all methods are requested.

    All methods are requested by None or by the name ``all``.

    Raises
    ------
    UsageError
        There is no method, or none with that name.
    """
    names = tuple(map(str, listed("all" if methods is None else methods)))
    if "all" in names:
        return None
    for name in names:
        check_among(("method", name, METHODS))
    if not names:
        raise UsageError(f"no method is given. Choose from {', '.join(METHODS)}.", code="method")
    return names


def check_choices(covariance: object, start: object, loss: object) -> None:
    """Refuse values that are not among the choices of `identify`.

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
