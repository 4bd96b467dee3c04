"""What comes of a log that was read in blocks, as a document."""

from typing import Any

from axisid.estimation.signals import Sampling
from axisid.estimation.streaming import StreamedEstimate
from axisid.presentation.schema import WrittenStream, WrittenStreamRecord, plain
from axisid.support.arrays import finite
from axisid.support.remedy import as_options

from .identification import (
    assumptions,
    left_out,
    note_text,
    origin_members,
    prefilter_document,
    value_document,
)


def stream_dict(estimate: StreamedEstimate) -> dict[str, Any]:
    """What ``--json`` writes."""
    return plain(stream_document(estimate))


def stream_document(estimate: StreamedEstimate) -> WrittenStream:
    """An estimate with its record, which is nowhere as a whole."""
    return WrittenStream(
        axis=estimate.axis.axis.name,
        signature=estimate.axis.signature,
        left_out=left_out(estimate.axis),
        record=WrittenStreamRecord(
            **origin_members(estimate.provenance),
            assumed=assumptions(estimate.provenance),
            samples=estimate.samples,
            sample_period=estimate.period,
        ),
        prefilter=prefilter_document(
            Sampling(prefilter=estimate.prefilter, samples=estimate.samples, period=estimate.period)
        ),
        parameters={name: value_document(v) for name, v in estimate.parameters.items()},
        beyond_bounds=note_text(estimate.beyond_bounds),
        time_base=note_text(estimate.time_base),
        rows=estimate.rows,
        lags=estimate.lags,
        equation_error_percent=estimate.equation_error_percent,
        condition_number=finite(estimate.condition_number),
        **_iteration(estimate),
    )


def _iteration(estimate: StreamedEstimate) -> dict[str, Any]:
    """What is said of instruments alone."""
    if not estimate.iterates:
        return {}
    names = estimate.axis.names
    return {
        "method": estimate.method,
        "simulation_error_percent": estimate.simulation_error_percent,
        "iterations": tuple(
            dict(zip(names, map(float, each.physical), strict=True)) for each in estimate.iterates
        ),
        "iteration_simulation_errors_percent": tuple(
            each.simulation_error_percent for each in estimate.iterates
        ),
        "started": estimate.started,
        "remarks": tuple(remark.worded(as_options) for remark in estimate.remarks),
    }
