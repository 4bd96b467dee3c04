"""Sentences of the repeating residual, of the simulated loop, and of the noise of a record."""

from collections.abc import Mapping

from axisid.estimation.diagnostics import (
    LoopNotSimulated,
    ResidualAtRepeats,
    SimulatedLoop,
)
from axisid.estimation.noise_models import NoiseSource, NoiseSources
from axisid.estimation.signals import RestingAxis
from axisid.support.mappings import grouped
from axisid.support.settings import setting

from .dispatch import sentence

_CORRECT_MODEL = "Correct the model first (see model), which may cause this"
#: Names of the sources of noise, by kind.
_NOISE: Mapping[str, str] = {
    "position step": "quantisation of the position",
    "position": "white noise of the position",
    "velocity step": "quantisation of the velocity",
    "velocity": "white noise of the velocity",
    "acceleration": "white noise of the acceleration",
    "jitter": "jitter of the sampling",
    "control step": "quantisation of the recorded control or force",
    "control": "noise of the recorded control",
    "disturbance": "disturbance of the control",
}


@sentence.register
def residual_at_repeats(finding: ResidualAtRepeats) -> str:
    """Return the part of the residual that repeats with the motion, and the part that is noise.

    `finding.left` is the regressed quantity: force or acceleration.
    """
    repeats = "repeats with the motion"
    if finding.period is not None:
        repeats += f" every {finding.period:.4g} s"
    unit, regressed = finding.unit, finding.left
    share = f"{finding.percent:.0f} % of the power of the residual"
    noise = f"{finding.noise:.2g} {unit} (rms) is noise"
    parts = (
        f"{finding.repeated:.2g} {unit} (rms, {finding.repeated_percent:.2g} % of the {regressed}) "
        f"{repeats}; {noise}"
    )
    if finding.nature == "systematic":
        return f"{share} is systematic: {parts}"
    if finding.nature == "steps":
        return f"{share} repeats but jumps from row to row, as with encoder steps: {parts}"
    if finding.nature == "small":
        return (
            f"most of the residual is noise; {finding.percent:.0f} % of its power is systematic: "
            f"{parts}"
        )
    return (
        f"the residual is noise; no significant part of its power ({finding.percent:.0f} %) "
        f"{repeats}: {noise}"
    )


@sentence.register
def loop_not_simulated(finding: LoopNotSimulated) -> str:
    """Return the reason why the closed loop cannot be simulated with the estimate."""
    text = (
        "the closed loop cannot be simulated with this estimate, although the recorded axis moved: "
        f"{finding.reason}"
    )
    return f"{text}. {_CORRECT_MODEL}" if finding.is_misspecified else text


@sentence.register
def simulated_loop(finding: SimulatedLoop) -> str:
    """Return the simulation error of the closed loop; a large error has a cause and a remedy."""
    error = f"{finding.percent:.3g} % of the {finding.left}"
    if finding.reproduces:
        return (
            "the simulated closed loop reproduces the recorded motion: the simulation error is "
            f"{error}"
        )
    text = f"the simulated closed loop leaves {error} unexplained"
    if finding.rest is not None:
        return f"{text}: {sentence(finding.rest)}"
    if finding.is_misspecified:
        return f"{text}. {_CORRECT_MODEL}"
    noise = ""
    if finding.noise is not None:
        noise = f" ({sentence(finding.noise)})"
    return (
        f"{text}. Check the control law, the signs and the units. If they are right, the record is "
        f"mostly noise{noise}, or has a motion that the model does not describe"
    )


@sentence.register
def resting_axis(finding: RestingAxis) -> str:
    """Return the share of samples at standstill, and the instruction to exclude them."""
    return (
        f"the axis stands still in {finding.percent:.0f} % of the samples of the fit. At "
        "standstill sticking friction can have any value, which no model predicts. First exclude "
        f"these samples with {setting('reversals', 'leave-out')}, and raise the cut-off if too few "
        "samples remain"
    )


@sentence.register
def noise_sources(finding: NoiseSources) -> str:
    """Return the sources of noise by kind, each with its sizes; ``no noise`` without any."""
    sizes = grouped((_NOISE[each.kind], _noise_size(each)) for each in finding.sources)
    kinds = [f"{kind} {', '.join(of_kind)}" for kind, of_kind in sizes.items()]
    text = "; ".join(kinds) or "no noise"
    if finding.is_measured_by_law:
        return text
    return f"{text}; the control law reads another position"


def _noise_size(source: NoiseSource) -> str:
    """Return the size of one source of noise with its correlation time."""
    text = f"{source.size:.3g} {source.unit}"
    if source.correlation_time is None:
        return text
    if source.correlation_time == 0:
        return f"{text} (white)"
    return f"{text} (correlation time {source.correlation_time:g} s)"
