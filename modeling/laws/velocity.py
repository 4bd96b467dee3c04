"""How a drive forms its velocity, and the reference's, for the laws that take them."""

from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Velocity:
    """How a law forms the measured velocity.

    Attributes
    ----------
    how : str
        ``difference`` of two encoder positions, ``averaged`` over two of these, ``pll`` (see
        `pll_velocity`), or ``ideal``, the velocity of an ideal sensor, which no log has.
    filter_time : float
        Time constant of a low-pass behind it, s; 0 for none.
    bandwidth : float
        Of the phase-locked loop, rad/s.
    """

    how: str = "difference"
    filter_time: float = 0.0
    bandwidth: float = 0.0

    def __post_init__(self) -> None:
        chosen(self.how, "the velocity of a law", VELOCITIES)
        in_range(self.filter_time, "the time constant velocity_filter")
        in_range(self.bandwidth, "the bandwidth pll_bandwidth", positive=self.how == "pll")
        if self.bandwidth and self.how != "pll":
            raise ModelError(
                f"pll_bandwidth is {self.bandwidth!r}, but the velocity is {self.how!r}; leave it "
                "out, or give velocity='pll'.",
                code="law",
            )

    @property
    def gains(self) -> dict[str, float]:
        """The numbers that it has, by name."""
        given = {"pll_bandwidth": self.bandwidth, "velocity_filter": self.filter_time}
        return {name: value for name, value in given.items() if value}

    @property
    def block(self) -> Block:
        """What it computes."""
        formed = self._formed()
        if not self.filter_time:
            return formed
        smooth = low_pass(formed.value, time_constant=gain("velocity_filter"), name="velocity1")
        return Block(smooth.value, (*formed.memory, *smooth.memory))

    def _formed(self) -> Block:
        if self.how == "ideal":
            return Block(MEASURED_VELOCITY)
        if self.how == "pll":
            return pll_velocity(bandwidth=gain("pll_bandwidth"))
        if self.how == "difference":
            return difference(MEASURED_POSITION, name="q1", start=MEASURED_POSITION)
        q1 = Memory("q1", following=MEASURED_POSITION, start=MEASURED_POSITION)
        q2 = Memory("q2", following=q1.symbol, start=MEASURED_POSITION)
        return Block((MEASURED_POSITION - q2.symbol) / (2 * PERIOD), (q1, q2))


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
