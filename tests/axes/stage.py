"""A stage with a payload and an offset, which one record does not tell from M, and its records."""

from dataclasses import replace
from functools import cache

from records import machine, stage, twin

from axisid import Record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis

TRUTH = stage().experiment.truth


def generated() -> GeneratedAxis:
    """The stage with the drive's own gain."""
    return machine(stage().drive.gain)


@cache
def stage_record(seed: int, gain: float = stage().drive.gain, **truth: float) -> Record:
    """A twin of the stage; equal arguments give one record."""
    made = twin(seed, gain, **truth)
    return replace(made, provenance=replace(made.provenance, source=f"run {seed}"))
