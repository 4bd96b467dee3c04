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
from axisid.support.errors import EstimationError, ModelError, UsageError, check_among, listed
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
    judge : bool
        Whether the bias, the intervals and the verdict are computed before the result is returned.
        With False each is computed when a property that needs it is read.

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
    check_twin_count(bootstrap)
    levels = Levels(level=level, least_share=least_share)
    requested = requested_methods(methods)
    as_given = Prefilter.given(prefilter).at_rate_of(records[0].period)

    def run(
        tried: GeneratedAxis,
        chosen: Sequence[str] | None,
        held: Mapping[str, float] | None = None,
    ) -> Identification:
        def free(axis: GeneratedAxis) -> Identification:
            shared = joint_records(axis, records, as_given, local, known, gain, skip_bad=skip_bad)
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

        if held:
            return free(axis_at_bounds(tried, held))
        return bounded_identification(tried, free) if bounded and held is None else free(tried)

    if generated.declared.drive.estimated is not None:
        result = identify_with_drive_time(generated, records, run, requested)
    else:
        result = run(generated, requested)
    return result.judged() if judge else result


def records_of(record: object) -> list[Record]:
    """Return the records of a result, one or several.

    Raises
    ------
    UsageError
        There is none, or something else among them.
    """
    listed = isinstance(record, (Sequence, Iterator)) and not isinstance(record, (str, bytes))
    records = list(record) if listed and isinstance(record, Iterable) else [record]
    if not records:
        raise UsageError(
            "no record is given. Give one or more records of read_record(path, axis).",
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
    """Identify from records that are filtered already, by the requested prefilter."""
    estimates, skipped, failed = dict[str, Estimate](), dict[str, str](), dict[str, str]()
    lost: EstimationError | None = None
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
        compared_laws=laws,
    )


def requested_methods(methods: str | Iterable[object] | None) -> tuple[str, ...] | None:
    """Return the requested methods by name; None for all, which is also called ``all``.

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
        raise UsageError(f"no method is given. Choose from {', '.join(METHODS)}.", code="method")
    return names


def check_choices(covariance: object, start: object, loss: object) -> None:
    """Refuse values that are no choice of `identify`.

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
