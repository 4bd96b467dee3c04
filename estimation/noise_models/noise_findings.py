"""The sources of a noise model with their sizes and units, as findings and studies report them."""

from dataclasses import dataclass
from typing import Literal

from axisid.estimation.findings import Finding

from .noise_model import Chain

Source = Literal[
    "position step",
    "position",
    "velocity step",
    "velocity",
    "acceleration",
    "jitter",
    "control step",
    "control",
    "disturbance",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseSource:
    """One source of noise.

    Attributes
    ----------
    kind : str
        The measured quantity with the noise or the quantisation; or a disturbance, which adds to
        the control and is not logged.
    size : float
        Standard deviation, or quantisation step.
    unit : str
        Unit of the size; SI for the step of a control, which may be that of a force.
    correlation_time : float or None
        Correlation time of an autoregression, s; 0 for white noise, None for every other source.
    """

    kind: Source
    size: float
    unit: str
    correlation_time: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseSources(Finding):
    """The noise of a record.

    Attributes
    ----------
    sources : tuple of NoiseSource
        Empty for no noise.
    is_measured_by_law : bool
        True if the control law reads the position with its steps, noise and jitter.
    """

    sources: tuple[NoiseSource, ...]
    is_measured_by_law: bool = True


def noise_sources(chain: Chain, unit: str, control_unit: str) -> NoiseSources:
    """Return the sources of a record's noise that are present, with sizes and units.

    Parameters
    ----------
    chain : Chain
        Noise of the record.
    unit, control_unit : str
        Units of the coordinate and of the control.
    """
    sizes: tuple[tuple[Source, float | None, str], ...] = (
        ("position step", chain.position_step, unit),
        ("position", chain.position, unit),
        ("velocity step", chain.velocity_step, f"{unit}/s"),
        ("velocity", chain.velocity, f"{unit}/s"),
        ("acceleration", chain.acceleration, f"{unit}/s^2"),
        ("jitter", chain.jitter, "s"),
        ("control step", chain.control_step, "SI"),
    )
    found = [NoiseSource(kind=kind, size=size, unit=of) for kind, size, of in sizes if size]
    parts: tuple[tuple[Source, tuple[tuple[float, float], ...]], ...] = (
        ("control", chain.control),
        ("disturbance", chain.disturbances),
    )
    for kind, autoregressions in parts:
        for time, deviation in autoregressions:
            found.append(
                NoiseSource(kind=kind, size=deviation, unit=control_unit, correlation_time=time)
            )
    return NoiseSources(sources=tuple(found), is_measured_by_law=chain.is_measured_by_law)
