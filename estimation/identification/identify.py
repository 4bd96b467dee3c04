"""The pipeline: from an axis and a record to estimates, method by method."""

from collections.abc import Iterable, Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.estimates import COVARIANCES, Estimate
from axisid.estimation.methods import METHODS, bound_record, estimate_by
from axisid.estimation.problems import Problem
from axisid.estimation.records import Record, check_record
from axisid.estimation.regression import LoopDataError
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.modeling.declaration import Axis
from axisid.support.errors import EstimationError, ModelError, UsageError
from axisid.support.given import given, is_among
from axisid.support.remedy import Note

from .result import Identification


def identify(
    axis: Axis | GeneratedAxis,
    record: Record,
    prefilter: Prefilter | None = None,
    methods: Sequence[str] | None = None,
    *,
    lags: int | None = None,
    covariance: str = "hac",
) -> Identification:
    """Identify an axis from a record.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record
    prefilter : Prefilter, optional
        The paper's appropriate filter by default. What it leaves open of cut-off and decimation
        follows the record's rate, see `Prefilter`.
    methods : sequence of str, optional
        Of `METHODS`. By default all that the axis and the record allow; what they do not allow is
        in `Identification.skipped`, what came to nothing in `Identification.failed`.
    lags : int, optional
        Of the autocorrelation-consistent covariance; chosen from the data by default.
    covariance : str
        Of `COVARIANCES`, ``hac``, ``robust`` or ``iid``: what intervals, draws, the
        delta method's check and the endogeneity test are of. All
        deviations are given whichever is chosen.

    Raises
    ------
    UsageError, DataError, ModelError, EstimationError
        See each; a method asked for by name raises, whatever the reason.
    """
    generated = as_generated(axis)
    _check_arguments(record, covariance)
    requested = _requested(methods)
    as_given = Prefilter() if prefilter is None else prefilter
    if isinstance(as_given, Prefilter):
        as_given = as_given.at_rate_of(record.period)
    data = bound_record(generated, record, as_given)
    return identify_filtered(data, as_given, requested, lags=lags, covariance=covariance)


def identify_filtered(
    data: FilteredRecord,
    as_given: Prefilter,
    requested: Sequence[str] | None = None,
    *,
    lags: int | None = None,
    covariance: str = "hac",
) -> Identification:
    """`identify` from a record that is filtered already, by the prefilter that was asked for."""
    problem = Problem(axis=data.axis, data=(data,))
    estimates: dict[str, Estimate] = {}
    skipped: dict[str, Note] = {}
    failed: dict[str, Note] = {}
    for method in METHODS if requested is None else dict.fromkeys(requested):
        try:
            # What is not finite is refused by name; NumPy's own warnings would only repeat it.
            with np.errstate(all="ignore"):
                estimates[method] = estimate_by(problem, METHODS[method], lags, covariance)
        except (ModelError, LoopDataError) as error:
            if requested is not None:
                raise
            skipped[method] = error.note
        except EstimationError as error:
            if requested is not None or not estimates:
                raise
            failed[method] = error.note
    return Identification(
        data=data,
        estimates=estimates,
        skipped=skipped,
        failed=failed,
        requested=as_given,
    )


def _requested(methods: object) -> tuple[str, ...] | None:
    """The methods that are asked for by name; None for all."""
    if methods is None:
        return None
    if not isinstance(methods, Iterable):
        raise UsageError(f"the methods are {given(methods)}; give a list of names.")
    listed = (methods,) if isinstance(methods, str) else tuple(methods)
    for method in listed:
        if not is_among(method, METHODS):
            raise UsageError(
                f"there is no method {given(method)}; choose from {', '.join(METHODS)}.",
                code="unknown-method",
            )
    if not listed:
        raise UsageError(f"no method is given; choose from {', '.join(METHODS)}.", code="no-method")
    return listed


def _check_arguments(record: object, covariance: object) -> None:
    check_record(record)
    if not is_among(covariance, COVARIANCES):
        raise UsageError(
            f"there is no covariance {given(covariance)}; choose from {', '.join(COVARIANCES)}.",
            code="unknown-covariance",
        )
