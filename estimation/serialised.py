"""Results as plain numbers, texts and lists. The names are a contract with other programs."""

import math
from collections.abc import Iterable
from typing import Any

from axisid.codegen import Quantity

from .arrays import Array
from .estimate import Estimate, Value
from .law_check import LawCheck
from .prefilter import Prefilter
from .record import Record


def record_dict(record: Record) -> dict[str, Any]:
    """Provenance and size of a record."""
    return {
        "source": record.provenance.source,
        "sha256": record.provenance.sha256 or None,
        "columns": dict(record.provenance.columns),
        "truth": dict(record.provenance.truth) or None,
        "samples": len(record),
        "sample_period": record.period,
    }


def prefilter_dict(prefilter: Prefilter, period: float) -> dict[str, Any]:
    """Settings of a prefilter; `drop` as it was applied."""
    return {
        "cutoff": prefilter.cutoff,
        "order": prefilter.order,
        "decimate": prefilter.decimate,
        "decimation": prefilter.decimation,
        "drop": list(prefilter.dropped(period)),
        "hold": prefilter.hold,
    }


def law_check_dict(check: LawCheck | str) -> dict[str, Any]:
    """The control law's check; `passed` is null where it could not be made."""
    if isinstance(check, str):
        return {"passed": None, "meaning": f"not evaluated: {check}"}
    return {
        "passed": check.passed,
        "factors": dict(check.factors),
        "residual_percent": check.residual_percent,
        "fitted_residual_percent": check.fitted_residual_percent,
        "delay": check.delay,
        "meaning": check.meaning,
    }


def estimate_dict(estimate: Estimate) -> dict[str, Any]:
    """One estimate; numbers that are not finite become null."""
    direct = bool(estimate.ddm_quantities)
    return {
        "method": estimate.method,
        "parameters": {name: _value(v) for name, v in estimate.parameters.items()},
        "theta_ddm": {
            q.name: {**_value(estimate.ddm_parameters[q.name]), "expression": q.expression}
            for q in estimate.ddm_quantities
        }
        or None,
        "covariance": estimate.covariance.tolist(),
        "covariance_robust": estimate.covariances["robust"].tolist(),
        "covariance_hac": estimate.covariances["hac"].tolist(),
        "theta_ddm_covariance": estimate.ddm_covariance.tolist() if direct else None,
        "theta_ddm_covariance_hac": estimate.ddm_covariances["hac"].tolist() if direct else None,
        "correlation": estimate.correlation.tolist(),
        "covariance_names": dict(estimate.covariance_names),
        "equation_error_percent": estimate.equation_error_percent,
        "simulation_error_percent": estimate.simulation_error_percent,
        "rows": len(estimate.y),
        "condition_number": estimate.condition_number,
        "iterations": [_named(estimate.quantities, i.physical) for i in estimate.iterates],
        "theta_ddm_iterations": [
            _named(estimate.ddm_quantities, i.theta) for i in estimate.iterates
        ]
        if direct
        else None,
        "iteration_simulation_errors_percent": [
            i.simulation_error_percent for i in estimate.iterates
        ],
        "remarks": list(estimate.remarks),
    }


def _value(value: Value) -> dict[str, Any]:
    return {
        "value": value.value,
        "unit": value.unit,
        "sd": value.sd,
        "relative_sd_percent": value.relative_sd_percent
        if math.isfinite(value.relative_sd_percent)
        else None,
        "sd_robust": value.sd_robust,
        "sd_hac": value.sd_hac,
        "interval_95": list(value.interval),
        "sd_gain": value.sd_gain,
    }


def _named(quantities: Iterable[Quantity], values: Array) -> dict[str, float]:
    return {q.name: float(value) for q, value in zip(quantities, values, strict=True)}
