"""A comparison of candidates as plain data."""

from dataclasses import asdict
from typing import Any

from axisid.estimation.studies import Candidate, Comparison, HeldOut
from axisid.support.arrays import finite_tree

from .identification import estimate_dict, left_out_dict, prefilter_dict, record_dict

_SCHEMA = "axisid.comparison/1"


def comparison_dict(comparison: Comparison) -> dict[str, Any]:
    """The comparison as plain numbers and texts; what is not finite becomes null."""
    c = comparison
    result = {
        "schema": _SCHEMA,
        "record": record_dict(c.record),
        "prefilter": prefilter_dict(c.data.sampling),
        "method": c.method,
        "rows": len(c.candidates[0].estimate.y),
        "held_out": {"blocks": c.blocks, "gap_rows": c.gap},
        "candidates": [_candidate_dict(each) for each in c.candidates],
        "failures": dict(c.failures),
        "tests": [asdict(test) for test in c.tests],
        "same": [list(pair) for pair in c.same],
        "recommended": c.recommended,
        "tied": list(c.tied),
        "reason": c.reason,
    }
    return {key: finite_tree(value) for key, value in result.items()}


def _candidate_dict(candidate: Candidate) -> dict[str, Any]:
    return {
        "name": candidate.name,
        "axis": candidate.axis.axis.name,
        "signature": candidate.axis.signature,
        "left_out": left_out_dict(candidate.axis),
        "estimate": estimate_dict(candidate.estimate),
        "criteria": asdict(candidate.criteria),
        "held_out_equation": _held_out_dict(candidate.equation),
        "held_out_simulation": None
        if candidate.simulation is None
        else _held_out_dict(candidate.simulation),
        "no_simulation": candidate.reason or None,
        "parameter_checks": [asdict(check) for check in candidate.checks],
    }


def _held_out_dict(held_out: HeldOut) -> dict[str, Any]:
    return {
        "error_percent": held_out.error_percent,
        "squares_by_block": held_out.squares.tolist(),
    }
