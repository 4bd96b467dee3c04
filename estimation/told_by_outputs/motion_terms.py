"""Forces along a motion that a model may lack, as controls of the size of the control."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from axisid.estimation.predictions import Motion
from axisid.support.arrays import Array

_SLOW, _SLOWER = 0.3, 0.1  # of the largest speed, over which friction at low speed falls
_WAVES = (1, 2)  # over twice the travel


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaled:
    """A motion in shares of the travel and of the largest speed of all motions, (N,) each.

    It is that at which the control of each sample acts, so that a force of it is one of its time.
    """

    time: Array
    place: Array
    speed: Array
    acceleration: Array
    control: Array
    rising: Array

    @property
    def direction(self) -> Array:
        """Of the motion; 0 at rest."""
        return np.sign(self.speed)


def _slow(scaled: Scaled, share: float) -> Array:
    return np.asarray(scaled.direction * np.exp(-np.abs(scaled.speed) / share))


def _wave(scaled: Scaled, number: int, *, shifted: bool) -> Array:
    phase = np.pi * number * scaled.place
    return np.asarray(np.sin(phase) if shifted else np.cos(phase))


_OF_PLACE = "{} that differs with the position"
_OFFSET = "a constant force: declare offset"
_COULOMB = "Coulomb friction: declare coulomb"
_VISCOUS = "viscous friction: declare viscous"
_INERTIA = "a force by the acceleration: another inertia"
_STRIBECK = "friction that is higher or lower at low speed: declare stribeck"
_ASYMMETRIC = (
    "viscous friction that differs with the direction: declare asymmetric_viscous in place of "
    "viscous"
)
_OTHER_STRIBECK = "friction at low speed: another velocity or exponent of stribeck"
_LATER = "another lag or delay of the drive, or a limited rate that noise reaches"
_OTHER_BAND = "another dead band of the drive"
_CHANGES = "{} that changes with time: warming up, or another load"

#: What a model may lack, in words, with the force's shape; several shapes may be the same in words.
TERMS: Sequence[tuple[str, Callable[[Scaled], Array]]] = (
    (_OFFSET, lambda s: np.ones_like(s.speed)),
    (_COULOMB, lambda s: s.direction),
    (_VISCOUS, lambda s: s.speed),
    (_ASYMMETRIC, lambda s: np.abs(s.speed)),
    ("friction by the square of the speed: declare quadratic", lambda s: s.speed * abs(s.speed)),
    (_STRIBECK, lambda s: _slow(s, _SLOW)),
    (_STRIBECK, lambda s: _slow(s, _SLOWER)),
    (_INERTIA, lambda s: s.acceleration),
    ("a force by the position: declare spring", lambda s: s.place),
    *(
        (_OF_PLACE.format("a force"), lambda s, k=k, b=b: _wave(s, k, shifted=b))
        for k in _WAVES
        for b in (False, True)
    ),
    *(
        (
            _OF_PLACE.format("friction"),
            lambda s, k=k, b=b: s.direction * _wave(s, k, shifted=b),
        )
        for k in _WAVES
        for b in (False, True)
    ),
    (_CHANGES.format("a constant force"), lambda s: s.time),
    (_CHANGES.format("friction"), lambda s: s.time * s.direction),
    (_CHANGES.format("viscous friction"), lambda s: s.time * s.speed),
    (_CHANGES.format("an inertia"), lambda s: s.time * s.acceleration),
    (_LATER, lambda s: s.rising),
    (_OTHER_BAND, lambda s: np.sign(s.control)),
)

_OF_CONTROL = (_LATER, _OTHER_BAND)  # that act where the control does, before the lag

#: Of `TERMS` those that nearly any axis has: a loop turns a little elsewhere with them than with
#: the declared ones.
PLAIN = frozenset({_OFFSET, _COULOMB, _VISCOUS, _INERTIA})


def subject_of(number: int, *, has_stribeck: bool) -> str:
    """What is said of a term, by its number in `TERMS`, beside what is declared."""
    subject = TERMS[number][0]
    return _OTHER_STRIBECK if has_stribeck and subject == _STRIBECK else subject


def terms_of(motions: Sequence[Motion]) -> Mapping[int, tuple[Array, ...]]:
    """Controls of each shape along the motions, (N,) each, by the number in `TERMS`.

    Each is of the size of the control over all of them.
    """
    control = np.concatenate([m.control for m in motions])
    size = float(np.sqrt(np.mean(control**2)))
    scaled, found = _scaled(motions), {}
    for number, (subject, shape) in enumerate(TERMS):
        pieces = [shape(each) for each in scaled]
        own = float(np.sqrt(np.mean(np.concatenate(pieces) ** 2)))
        if own > 0 and np.isfinite(own):
            found[number] = tuple(
                size / own * (piece if subject in _OF_CONTROL else m.commanded(piece))
                for m, piece in zip(motions, pieces, strict=True)
            )
    return MappingProxyType(found)


def _scaled(motions: Sequence[Motion]) -> list[Scaled]:
    places = np.concatenate([m.position for m in motions])
    middle, reach = (places.max() + places.min()) / 2, max(np.ptp(places) / 2, 1e-300)
    fastest = float(np.abs(np.concatenate([m.velocity for m in motions])).max()) or 1.0
    last = float(np.concatenate([m.time for m in motions]).max()) or 1.0
    return [
        Scaled(
            time=m.time / last - 0.5,
            place=m.when_it_acts((m.position - middle) / reach),
            speed=m.when_it_acts(m.velocity / fastest),
            acceleration=m.when_it_acts(m.rate_of(m.velocity / fastest)),
            control=m.control,
            rising=np.gradient(m.control, m.time),
        )
        for m in motions
    ]
