"""How a drive forms its velocity, and the reference's, for the laws that take them."""

from collections.abc import Callable, Mapping

from axisid.modeling.declaration import Memory, gain
from axisid.modeling.quantities import MEASURED_POSITION, MEASURED_VELOCITY, PERIOD, expression
from axisid.support.errors import ModelError

from .arguments import Amount, chosen, in_range
from .blocks import (
    Block,
    difference,
    low_pass,
    pll_velocity,
    reference_acceleration,
    reference_velocity,
)

#: How the velocity may be formed, first what laws do by default.
VELOCITIES = ("difference", "averaged", "pll", "ideal")


def formed_velocity(
    how: str = "difference", filter_time: float = 0.0, bandwidth: float = 0.0
) -> tuple[Block, dict[str, float]]:
    """How a law forms the measured velocity, and the numbers that it has, by name.

    Parameters
    ----------
    how : str
        ``difference`` of two encoder positions, ``averaged`` over two of these, ``pll`` (see
        `pll_velocity`), or ``ideal``, the velocity of an ideal sensor, which no log has.
    filter_time : float
        Time constant of a low-pass behind it, s; 0 for none.
    bandwidth : float
        Of the phase-locked loop, rad/s.
    """
    chosen(how, "the velocity of a law", VELOCITIES)
    in_range(filter_time, "the time constant velocity_filter")
    in_range(bandwidth, "the bandwidth pll_bandwidth", positive=how == "pll")
    if bandwidth and how != "pll":
        raise ModelError(
            f"pll_bandwidth is {bandwidth!r}, but the velocity is {how!r}; leave it out, or give "
            "velocity='pll'.",
            code="law",
        )
    formed = _FORMED[how]()
    if filter_time:
        smooth = low_pass(formed.value, time_constant=gain("velocity_filter"), name="velocity1")
        formed = Block(smooth.value, (*formed.memory, *smooth.memory))
    return formed, without_zeros({"pll_bandwidth": bandwidth, "velocity_filter": filter_time})


def _averaged() -> Block:
    q1 = Memory("q1", following=MEASURED_POSITION, start=MEASURED_POSITION)
    q2 = Memory("q2", following=q1.symbol, start=MEASURED_POSITION)
    return Block((MEASURED_POSITION - q2.symbol) / (2 * PERIOD), (q1, q2))


_FORMED: Mapping[str, Callable[[], Block]] = {
    "difference": lambda: difference(MEASURED_POSITION, name="q1", start=MEASURED_POSITION),
    "averaged": _averaged,
    "pll": lambda: pll_velocity(bandwidth=gain("pll_bandwidth")),
    "ideal": lambda: Block(MEASURED_VELOCITY),
}


def commanded(rate: str, recorded: Amount | None) -> Block:
    """The reference's velocity or acceleration: a recorded signal, else its difference."""
    if recorded is None:
        return reference_velocity() if rate == "velocity" else reference_acceleration()
    return Block(expression(recorded, f"the reference's {rate}"))


def joined(*parts: tuple[Memory, ...]) -> tuple[Memory, ...]:
    """The memories of several blocks, those that two have in common once."""
    return tuple({memory.name: memory for part in parts for memory in part}.values())


def without_zeros(gains: dict[str, float]) -> dict[str, float]:
    """The gains that are not 0: a law has no term that does nothing."""
    return {name: value for name, value in gains.items() if value}
