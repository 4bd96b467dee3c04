"""What comes of a log that was read in blocks, as plain data."""

from typing import Any

from axisid.estimation.signals import Sampling
from axisid.estimation.studies import StreamedEstimate
from axisid.support.arrays import finite

from .identification import left_out_dict, origin_dict, prefilter_dict, value_dict

#: Name and version of what `stream_dict` gives.
STREAM_SCHEMA = "axisid.stream/1"


def stream_dict(estimate: StreamedEstimate) -> dict[str, Any]:
    """What ``--json`` writes."""
    return {
        "schema": STREAM_SCHEMA,
        "axis": estimate.axis.axis.name,
        "signature": estimate.axis.signature,
        "left_out": left_out_dict(estimate.axis),
        "record": {
            **origin_dict(estimate.provenance),
            "assumed": list(estimate.provenance.assumed),
            "samples": estimate.samples,
            "sample_period": estimate.period,
        },
        "prefilter": prefilter_dict(
            Sampling(prefilter=estimate.prefilter, samples=estimate.samples, period=estimate.period)
        ),
        "parameters": {name: value_dict(v) for name, v in estimate.parameters.items()},
        "beyond_bounds": estimate.beyond_bounds or None,
        "time_base": estimate.time_base or None,
        "rows": estimate.rows,
        "lags": estimate.lags,
        "equation_error_percent": estimate.equation_error_percent,
        "condition_number": finite(estimate.condition_number),
    }
