"""A stage with a payload and an offset, and its records."""

from dataclasses import replace
from functools import cache
from typing import Any

from axisid import Parameter, Record, build, load_axis, twin_record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.modeling.declaration.axis import Axis

TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8, "tau0": 0.0, "m_add": 0.0}


@cache
def stage() -> Axis:
    """The paper's axis with an offset and a payload, which one record does not tell from M."""
    axis = load_axis("emps2015")
    payload, offset = Parameter("m_add", "kg", lower=0.0), Parameter("tau0", "N")
    return replace(
        axis,
        name="stage",
        parameters=(*axis.parameters, offset, payload),
        force=axis.force + payload * axis.coordinate.acceleration + offset.symbol,
        experiment=replace(axis.experiment, truth=TRUTH),
        columns={"time": "t", "position": "q", "reference": "r", "control": "u"},
    )


@cache
def generated(gain: float = 35.15) -> GeneratedAxis:
    """The stage with a drive of some gain."""
    return build(replace(stage(), drive=replace(stage().drive, gain=gain)))


@cache
def stage_record(seed: int, gain: float = 35.15, **truth: float) -> Record:
    """A twin of the stage; equal arguments give one record."""
    axis = generated(gain)
    experiment = stage().experiment
    values = {**TRUTH, **truth}
    base = axis.base.at([values[p.name] for p in stage().parameters])
    named: dict[str, Any] = dict(zip((p.name for p in axis.axis.parameters), base, strict=True))
    own = replace(axis.axis, experiment=replace(experiment, seed=seed, truth=named))
    made = twin_record(replace(axis, axis=own))
    return replace(made, provenance=replace(made.provenance, source=f"run {seed}"))
