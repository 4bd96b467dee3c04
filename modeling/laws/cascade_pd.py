"""Cascades of a position loop over a velocity loop, without an integral.

The paper's law and the one recovered from the EMPS record.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from axisid.modeling.declaration import ControlLaw, gain
from axisid.modeling.quantities import MEASURED_POSITION, REFERENCE

from .velocity import formed_velocity


def cascade_pd(*, kp: float, kv: float, period: float, continuous: bool = False) -> ControlLaw:
    """Position loop over a velocity loop, with an ideal velocity sensor.

    ``control = kv (kp (reference - q) - dq)``, evaluated once a period and held.

    Parameters
    ----------
    kp : float
        Position gain, 1/s.
    kv : float
        Velocity gain, control over velocity (V/(m/s)).
    period : float
        Sampling period, s.
    continuous : bool
        Evaluate it all the time in place of holding it: the equations as they are written.

    References
    ----------
    Equations (6) and (7) of [Brunot2015]_.
    """
    law = _cascade("ideal", "ideal velocity", kp=kp, kv=kv, period=period)
    return replace(law, continuous=continuous)


def cascade_pd_averaged(*, kp: float, kv: float, period: float) -> ControlLaw:
    """The same cascade, its velocity from the encoder: the law the EMPS drive follows.

    The velocity is the difference of the means of two successive positions,
    ``(q[k] - q[k-2]) / (2 period)``. Recovered from the record of [Janot2019]_, whose control it
    reproduces to 0.24 % of its norm.
    """
    return _cascade("averaged", "averaged encoder velocity", kp=kp, kv=kv, period=period)


def cascade_pd_difference(*, kp: float, kv: float, period: float) -> ControlLaw:
    """The same cascade, its velocity the difference of two successive encoder positions.

    ``(q[k] - q[k-1]) / period``, as simple drives form it: half a sample late, and coarse.
    """
    return _cascade("difference", "encoder difference", kp=kp, kv=kv, period=period)


def _cascade(how: str, said: str, *, kp: float, kv: float, period: float) -> ControlLaw:
    formed, _ = formed_velocity(how)
    return ControlLaw(
        name=f"cascade PD, {said}",
        period=period,
        output=gain("kv") * (gain("kp") * (REFERENCE - MEASURED_POSITION) - formed.value),
        gains={"kp": kp, "kv": kv},
        memory=formed.memory,
    )


#: The cascades by name: they differ by how the drive forms its velocity.
CASCADES: Mapping[str, Callable[..., ControlLaw]] = MappingProxyType(
    {law.__name__: law for law in (cascade_pd, cascade_pd_difference, cascade_pd_averaged)}
)


def velocity_variants(law: ControlLaw) -> dict[str, ControlLaw]:
    """A cascade with its velocity formed otherwise, by the name of its law; empty for others."""
    if set(law.gains) != {"kp", "kv"} or law.continuous or law.delay:
        return {}
    made = {name: of(**law.gains, period=law.period) for name, of in CASCADES.items()}
    if all(variant.output != law.output for variant in made.values()):
        return {}
    return {name: variant for name, variant in made.items() if variant.output != law.output}
