"""Results as plain numbers, texts and lists. The names are a contract with other programs."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.estimates import Estimate, Physical, Value
from axisid.estimation.identification import Identification
from axisid.estimation.records import Record
from axisid.estimation.signals import Sampling
from axisid.estimation.tables import Provenance
from axisid.support.arrays import Array, finite

from .diagnosis import diagnosis_dict, residual_dict

#: Name and version of what `Identification.to_dict` gives; the version rises when a name goes or
#: changes its meaning.
SCHEMA = "axisid.identification/1"


def identification_dict(result: Identification, draws: int = 0) -> dict[str, Any]:
    """What ``--json`` writes: plain numbers, texts and lists; see `Identification.to_dict`."""
    diagnosis, physical = result.diagnosis, result.physical
    return {
        "schema": SCHEMA,
        "axis": result.axis.axis.name,
        "signature": result.axis.signature,
        "left_out": left_out_dict(result.axis),
        "record": record_dict(result.record),
        "prefilter": prefilter_dict(result.data.sampling),
        "estimates": [
            {
                **estimate_dict(e),
                "drawn": drawn_dict(e, draws) if draws else None,
                **physical_dict(physical.get(name)),
            }
            for name, e in result.estimates.items()
        ],
        **diagnosis_dict(diagnosis, result.axis.names),
        "skipped": dict(result.skipped),
        "failed": dict(result.failed),
    }


def record_dict(record: Record) -> dict[str, Any]:
    """Provenance and size of a record."""
    return {
        **origin_dict(record.provenance),
        "truth": dict(record.provenance.truth) or None,
        "assumed": list(record.provenance.assumed),
        "repairs": [asdict(repair) for repair in record.provenance.repairs],
        "segments": [list(span) for span in record.segments],
        "masked": [list(span) for span in record.masked],
        "samples": len(record),
        "sample_period": record.period,
    }


def origin_dict(provenance: Provenance) -> dict[str, Any]:
    """Which file a record comes from, if from one, and which of its columns."""
    return {
        "source": provenance.source,
        "given": provenance.given or None,
        "path": provenance.path or None,
        "sha256": provenance.sha256 or None,
        "columns": dict(provenance.columns),
    }


def prefilter_dict(sampling: Sampling) -> dict[str, Any]:
    """Settings of a prefilter; `drop` as it was applied."""
    prefilter = sampling.prefilter
    return {
        "cutoff": prefilter.cutoff,
        "order": prefilter.order,
        "decimate": prefilter.decimate,
        "decimation": prefilter.decimation,
        "drop": list(prefilter.dropped(sampling.period)),
        "hold": prefilter.hold,
        "reversals": prefilter.reversals,
        "silent": sampling.excluded_samples,
    }


def estimate_dict(estimate: Estimate) -> dict[str, Any]:
    """One estimate; numbers that are not finite become null."""
    direct = bool(estimate.ddm_quantities)
    return {
        "method": estimate.method,
        "parameters": {name: value_dict(v) for name, v in estimate.parameters.items()},
        "theta_ddm": {
            q.name: {**value_dict(estimate.ddm_parameters[q.name]), "expression": q.expression}
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
        "chosen_covariance": estimate.chosen,
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
        "curvatures": {
            q.name: finite(c) for q, c in zip(estimate.quantities, estimate.curvatures, strict=True)
        },
        "residual_tests": residual_dict(estimate.residual_tests),
        "remarks": list(estimate.remarks),
    }


def drawn_dict(estimate: Estimate, draws: int) -> dict[str, Any]:
    """Every parameter over draws; null where no draw gave an axis."""
    drawn = {name: estimate.propagate(name, draws=draws) for name in estimate.parameters}
    return {
        name: {
            "median": finite(d.median),
            "interval_95": [finite(x) for x in d.interval],
            "draws": d.draws,
            "lost": d.lost,
            "seed": d.seed,
        }
        for name, d in drawn.items()
    }


def physical_dict(physical: Physical | None) -> dict[str, Any]:
    """The member ``physical`` of an estimate; nothing where the estimate is of these already."""
    if physical is None:
        return {}
    base = physical.base
    return {
        "physical": {
            "parameters": {name: value_dict(v) for name, v in physical.parameters.items()},
            "covariance_hac": physical.covariances["hac"].tolist(),
            "base": {p.name: p.description for p, _ in base.combined},
            "fixed": {p.name: {"value": p.known, "sd": p.known_sd} for p in base.known},
            "unsettled": list(physical.unsettled),
            "statistic": physical.statistic,
            "dof": physical.dof,
            "p_value": physical.p_value,
            "remarks": list(physical.remarks),
        }
    }


def left_out_dict(axis: GeneratedAxis) -> dict[str, float | None]:
    """What stands for the parameters that were left out, by name."""
    return {p.name: p.known for p in axis.declared.left_out}


def value_dict(value: Value) -> dict[str, Any]:
    """A number with unit, deviations and interval."""
    return {
        "value": value.value,
        "unit": value.unit,
        "sd": value.sd,
        "relative_sd_percent": finite(value.relative_sd_percent),
        "sd_robust": value.sd_robust,
        "sd_hac": value.sd_hac,
        "interval_95": list(value.interval),
        "sd_gain": value.sd_gain,
        "filter_bias": value.filter_bias,
    }


def _named(quantities: Iterable[Quantity], values: Array) -> dict[str, float]:
    return {q.name: float(value) for q, value in zip(quantities, values, strict=True)}
