"""The experiment of an axis's twin: which motion is commanded, and what is measured.

A twin is a simulated record of the declared axis with known parameters. It shows what an estimator
does where the truth is known.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from .errors import ModelError


@dataclass(frozen=True, slots=True)
class Move:
    """A move with trapezoidal velocity, from rest to rest.

    Attributes
    ----------
    distance : float
        Signed, in the coordinate's unit.
    speed, acceleration : float
        Largest absolute values, per second and per second squared.
    """

    distance: float
    speed: float
    acceleration: float

    def __post_init__(self) -> None:
        numbers = (self.distance, self.speed, self.acceleration)
        if not all(map(math.isfinite, numbers)) or min(self.speed, self.acceleration) <= 0:
            raise ModelError(
                f"{self} is not a move: give a finite distance, a positive speed and a positive "
                "acceleration."
            )


def back_and_forth(
    *, speeds: tuple[float, ...], acceleration: float, seconds: float, repeat: int = 1
) -> tuple[Move, ...]:
    """Moves there and back at each speed, each long enough to cruise.

    A record that identifies friction needs several speeds in both directions; one that identifies
    inertia needs acceleration in between.

    Parameters
    ----------
    speeds : tuple of float
        Cruise speeds, coordinate unit per second.
    acceleration : float
        Coordinate unit per second squared.
    seconds : float
        Distance of each move over its speed, s.
    repeat : int
        How often the whole programme is run.
    """
    once = (
        Move(sign * speed * seconds, speed, acceleration) for speed in speeds for sign in (1, -1)
    )
    return tuple(once) * repeat


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """What the twin does.

    Attributes
    ----------
    moves : tuple of Move
        The commanded motion, one after the other without a pause.
    truth : mapping of str to float
        The twin's parameters by name, SI; the nominal value where one is not named.
    position_noise : float
        Standard deviation of the white noise on the measured position, inside the loop, in the
        coordinate's unit.
    seed : int
        Of the noise.
    """

    moves: tuple[Move, ...]
    truth: Mapping[str, float] = field(default_factory=dict)
    position_noise: float = 0.0
    seed: int = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "moves", tuple(self.moves))
        object.__setattr__(self, "truth", MappingProxyType(dict(self.truth)))
        if not self.moves:
            raise ModelError("an experiment needs at least one move.")
        if not (math.isfinite(self.position_noise) and self.position_noise >= 0):
            raise ModelError(f"the position noise is {self.position_noise!r}; give 0 or more.")
