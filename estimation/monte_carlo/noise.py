"""The noise of a study by the names that its options, and its files, have for it."""

import math
from dataclasses import replace

from axisid.estimation.twins import Autoregressions, Chain


def declared_chain(
    chain: Chain,
    *,
    position: float | None = None,
    resolution: float | None = None,
    anywhere: bool = False,
    velocity: float | None = None,
    acceleration: float | None = None,
    control: float | None = None,
    disturbance: float | None = None,
    correlation_time: float | None = None,
) -> Chain:
    """A chain with what is given.

    Parameters
    ----------
    chain : Chain
        The experiment's, as `Chain.of_experiment` has it.
    position, resolution : float, optional
        Of the encoder, in the coordinate's unit; the chain's by default.
    anywhere, velocity, acceleration
        As of a `Chain`.
    control, disturbance : float, optional
        In the drive's unit; none by default.
    correlation_time : float, optional
        Of both, s; white by default.
    """

    def coloured(deviation: float | None) -> Autoregressions:
        return ((correlation_time or 0.0, deviation),) if deviation else ()

    return replace(
        chain,
        position=chain.position if position is None else position,
        position_step=chain.position_step if resolution is None else resolution,
        anywhere=anywhere,
        velocity=velocity,
        acceleration=acceleration,
        control=coloured(control),
        disturbances=coloured(disturbance),
    )


def declared_figures(chain: Chain) -> dict[str, float | bool | None]:
    """The figures of a chain by these names: of several autoregressions their sum's deviation."""
    control, disturbance = (
        math.hypot(*(sd for _, sd in parts)) for parts in (chain.control, chain.disturbances)
    )
    return {
        "position": chain.position,
        "resolution": chain.position_step,
        "anywhere": chain.anywhere,
        "velocity": chain.velocity,
        "acceleration": chain.acceleration,
        "control": control,
        "disturbance": disturbance,
        "correlation_time": max(
            (time for time, _ in (*chain.control, *chain.disturbances)), default=0.0
        ),
    }
