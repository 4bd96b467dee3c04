"""Estimates over the cut-off as plain data."""

from typing import Any

from axisid.estimation.studies import Sweep

from .identification import identification_dict

_SCHEMA = "axisid.sweep/1"


def sweep_dict(sweep: Sweep) -> dict[str, Any]:
    """What ``--json`` writes."""
    return {
        "schema": _SCHEMA,
        "recommended_cutoff": sweep.recommended,
        "reason": sweep.reason,
        "failures": {f"{cutoff:g}": why for cutoff, why in sweep.failures.items()},
        "results": [identification_dict(result) for result in sweep.results],
    }
