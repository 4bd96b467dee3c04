"""The experiment of an axis's synthetic twin: the commanded motion and the measured signals.

A twin is a simulated record of the declared axis with known parameters. It shows how an estimator
behaves when the true values are known.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from axisid.modeling.quantities import TIME, ConstantSymbol, expression, listed, number, settle
from axisid.support.checks import is_whole, refuse
from axisid.support.errors import ModelError
from axisid.support.mappings import FrozenMapping
from axisid.support.wording import quoted

_LONGEST = 1e4  # s
_MOST_REPEATS = 10_000


@dataclass(frozen=True, slots=True)
class Move:
    """A move with trapezoidal velocity, from rest to rest.

    Attributes
    ----------
    distance : float
        Signed, in the coordinate's unit.
    speed, acceleration : float
        Largest absolute values, per second and per second squared.
    dwell : float
        Time for which the command stays at the end of the move, s.
    """

    distance: float
    speed: float
    acceleration: float
    dwell: float = 0.0

    def __post_init__(self) -> None:
        names = ("distance", "speed", "acceleration", "dwell")
        settle(self, **{n: number(getattr(self, n), f"the {n} of a move") for n in names})
        refuse(
            ModelError,
            (not self.dwell >= 0, f"{self} has a negative dwell. Give 0 s or more", "twin"),
            (
                min(self.speed, self.acceleration) <= 0,
                f"{self} has a speed or an acceleration that is not positive. Give a positive "
                "speed and a positive acceleration",
            ),
        )
        if not self.duration < _LONGEST:
            raise ModelError(
                f"{self} takes {self.duration:g} s, but an experiment must take less than "
                f"{_LONGEST:g} s. Give a faster move."
            )

    @property
    def duration(self) -> float:
        """Return the duration of the move and its dwell, s.

        A short move reaches only a part of its speed.
        """
        distance = abs(self.distance)
        speed = min(self.speed, math.sqrt(distance * self.acceleration))
        return self.dwell + (distance / speed + speed / self.acceleration if speed else 0.0)


def back_and_forth(
    *,
    speeds: tuple[float, ...],
    acceleration: float,
    seconds: float,
    repeat: int = 1,
    dwell: float = 0.0,
) -> tuple[Move, ...]:
    """Return moves there and back at each speed, one after the other.

    To identify friction, a record needs several speeds in both directions. To identify inertia, it
    needs accelerations.

    Parameters
    ----------
    speeds : tuple of float
        Cruise speeds, coordinate unit per second.
    acceleration : float
        Coordinate unit per second squared.
    seconds : float
        Distance of each move divided by its speed, s. It must exceed the speed divided by the
        acceleration for the move to reach its speed.
    repeat : int
        Number of repetitions of the whole sequence.
    dwell : float
        Time for which the command rests after each move, s.

    Raises
    ------
    ModelError
        A speed is not positive, a dwell is negative, or there are too many repetitions.
    """
    if not (is_whole(repeat) and 1 <= repeat <= _MOST_REPEATS):
        raise ModelError(
            f"repeat is {quoted(repeat)}. Give a whole number from 1 to {_MOST_REPEATS}."
        )
    return repeat * tuple(
        Move(sign * speed * seconds, speed, acceleration, dwell)
        for speed in speeds
        for sign in (1, -1)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """Experiment of the synthetic twin.

    Attributes
    ----------
    moves : tuple of Move
        The commanded moves, one after the other.
    truth : mapping of str to float
        The twin's parameters by name, SI; a parameter that is not named has its nominal value.
    position_noise : float
        Standard deviation of the white noise on the measured position, inside the loop, in the
        coordinate's unit.
    resolution : float
        Resolution of the encoder, in the coordinate's unit: the twin's law measures whole counts,
        and its log contains them. 0 for none.
    seed : int
        Seed of the noise.
    signals : mapping of str to expression
        The recorded signals of the axis by name, SI, as numbers or functions of the time, `TIME`.
    """

    moves: tuple[Move, ...]
    truth: Mapping[str, float] = field(default_factory=dict)
    position_noise: float = 0.0
    seed: int = 1
    signals: Mapping[str, Any] = field(default_factory=dict)
    resolution: float = 0.0

    def __post_init__(self) -> None:
        of_time = {
            name: expression(value, f"the signal {name!r} of an experiment")
            for name, value in self.signals.items()
        }
        settle(
            self,
            signals=FrozenMapping(of_time),
            moves=listed(self.moves, Move, "the moves of an experiment contain"),
            truth=FrozenMapping(
                {name: number(v, f"the truth of {name!r}") for name, v in self.truth.items()}
            ),
            position_noise=number(self.position_noise, "the position noise"),
            resolution=number(self.resolution, "the encoder's resolution"),
        )
        duration = sum(move.duration for move in self.moves)
        refuse(
            ModelError,
            *(
                (
                    value.free_symbols - value.atoms(ConstantSymbol) - {TIME},
                    f"the signal {name!r} of an experiment is {value}. Use only {TIME} and numbers",
                    "twin",
                )
                for name, value in of_time.items()
            ),
            (
                not 0 < duration < _LONGEST,
                f"the moves of an experiment take {duration:g} s. Give moves that take more than 0 "
                f"and less than {_LONGEST:g} s",
            ),
            (
                not (is_whole(self.seed) and self.seed >= 0),
                f"the seed is {quoted(self.seed)}. Give a whole number of 0 or more",
            ),
            (
                not self.position_noise >= 0,
                f"the position noise is {self.position_noise!r}. Give a number of 0 or more",
            ),
            (
                not self.resolution >= 0,
                f"the encoder's resolution is {self.resolution!r}. Give a number of 0 or more",
                "twin",
            ),
        )
