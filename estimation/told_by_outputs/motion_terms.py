"""Forces along simulated motions that a model may lack, as controls of the size of the control.

Of each term the errors choose the place of its grid where it takes most of them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, groupby
from operator import itemgetter

import numpy as np

from axisid.estimation.lacking import DRIFTS, Along, Kind, Term, said_of, terms_for
from axisid.estimation.predictions import Motion, Predictions
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .missing import Asking, Left

_OF_CONTROL: tuple[Kind, ...] = ("delay", "dead band")  # that act where the control does
_AT_ONCE = 150_000  # numbers that are added side by side: of more, copies leave the cache


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Force:
    """A force that a model may lack.

    Attributes
    ----------
    term : Term
    at : float
        Its place on the term's grid.
    slopes : (n,) array
        Of the outputs, by so much of it as has the size of the control.
    scale : float
        Of that in the control's unit, by the term's own columns.
    gain : float
        Sum of squares that it takes of the errors.
    asking : Asking
    """

    term: Term
    at: float
    slopes: Array
    scale: float
    gain: float
    asking: Asking

    def subject(self, axis: Axis, factor: float) -> str:
        """In words, of an axis that lacks so much of it."""
        more = factor * self.scale * abs(axis.drive.gain)
        return ": ".join(said_of(self.term, self.at, axis, more, swings="one of the loop"))


def forces_of(
    axis: Axis, predictions: Predictions, physical: Array, left: Left
) -> list[Force] | Missing:
    """Of each term the force that takes most of the errors, between the places of its grid too.

    Parameters
    ----------
    axis : Axis
    predictions : Predictions
    physical : (P,) array
        The estimate.
    left : Left
    """
    motions = predictions.motions(physical)
    if motions is None:
        return Missing("the motion cannot be simulated sample by sample")
    search = _Search(predictions, physical, left, motions)
    terms = (*terms_for(axis, commanded=True), *DRIFTS)
    grids = {term: term.places(search.whole) for term in terms}
    found = search.strongest(grids)
    if found is None:
        return Missing("the motion cannot be simulated with a force beside the model")
    between = {t: t.between(grids[t], f.at) for t, f in found.items() if t.between is not None}
    nearer = search.strongest(between) or {}
    return [
        replace(nearer.get(t, force), asking=replace(force.asking, tried=len(grids[t])))
        for t, force in found.items()
    ]


class _Search:
    """Errors that are asked for forces along motions.

    Each motion is that at which the control of each sample acts, so that a force of it is one of
    its time.
    """

    def __init__(
        self, predictions: Predictions, physical: Array, left: Left, motions: Sequence[Motion]
    ) -> None:
        self._predictions, self._physical, self._left = predictions, physical, left
        places = np.concatenate([m.position for m in motions])
        middle = float(places.max() + places.min()) / 2
        ends = [(m.record, end) for m in motions for end in m.time[[0, -1]]]
        spans = {r: [end for own, end in ends if own == r] for r, _ in ends}
        self._motions = motions
        self._along = [
            _along(m, middle, (min(spans[m.record]) + max(spans[m.record])) / 2) for m in motions
        ]
        self.whole = _joined(self._along)
        self._size = float(np.sqrt(np.mean(self.whole.force**2)))

    def strongest(self, grids: Mapping[Term, Array]) -> dict[Term, Force] | None:
        """The best place of each grid; None where the motion cannot be simulated with forces."""
        entries = [(term, at) for term, places in grids.items() for at in places]
        at_once = max(_AT_ONCE // len(self.whole.time), 1)
        found = dict[Term, Force]()
        for first in range(0, len(entries), at_once):
            some = groupby(entries[first : first + at_once], key=itemgetter(0))
            blocks = [(term, np.array([at for _, at in own])) for term, own in some]
            added = [self._controls(term, places) for term, places in blocks]
            ends = np.cumsum([len(m.time) for m in self._motions])[:-1]
            slopes = self._predictions.slopes_by_added(
                self._physical, np.split(np.hstack(added), ends)
            )
            if slopes is None or not np.all(np.isfinite(slopes)):
                return None
            columns = np.cumsum([each.shape[1] for each in added])[:-1]
            own = zip(blocks, added, np.split(slopes, columns, axis=1), strict=True)
            for force in chain.from_iterable(self._forces(*block, *rest) for block, *rest in own):
                if force.term not in found or force.gain > found[force.term].gain:
                    found[force.term] = force
        return found

    def _controls(self, term: Term, places: Array) -> Array:
        """What resists, as controls (N, m g) of all motions."""
        pieces = []
        for m, s in zip(self._motions, self._along, strict=True):
            columns = -term.columns(s, places).reshape(len(m.time), -1)
            if m.lag and term.kind not in _OF_CONTROL:
                columns = np.column_stack([m.commanded(column) for column in columns.T])
            pieces.append(columns)
        return np.concatenate(pieces)

    def _forces(self, term: Term, places: Array, added: Array, slopes: Array) -> Iterator[Force]:
        """A force at each place, the sum of its columns that takes most of the errors."""
        net, _ = self._left.beside(self._left.weights[:, None] * slopes)
        asking = Asking(width=term.width, is_positive=term.is_positive, is_last=term.is_last)
        for i, at in enumerate(places):
            one = slice(i * term.width, (i + 1) * term.width)
            told = net[:, one].T @ self._left.errors
            factors = -np.linalg.lstsq(net[:, one].T @ net[:, one], told, rcond=None)[0]
            sum_of = factors / np.linalg.norm(factors) if term.width > 1 else np.ones(1)
            size = float(np.sqrt(np.mean((added[:, one] @ sum_of) ** 2)))
            if size > 0 and np.isfinite(size):
                scale = self._size / size
                yield Force(
                    term=term,
                    at=float(at),
                    slopes=scale * slopes[:, one] @ sum_of,
                    scale=scale,
                    gain=0.0 if term.is_positive and factors[0] < 0 else -float(factors @ told),
                    asking=asking,
                )


def _along(m: Motion, middle: float, half_time: float) -> Along:
    """A motion about a position, and about the middle of its record's time."""
    long, velocity = len(m.time) // m.windows, m.when_it_acts(m.velocity)
    return Along(
        time=m.time - half_time,
        position=m.when_it_acts(m.position - middle),
        velocity=velocity,
        acceleration=m.when_it_acts(m.rate_of(m.velocity)),
        direction=np.sign(velocity),
        force=m.control,
        spans=[(i * long, (i + 1) * long) for i in range(m.windows)],
        row_period=float(m.time[1] - m.time[0]),
    )


def _joined(pieces: Sequence[Along]) -> Along:
    """One of all samples, for what all of them reach."""

    def joined(name: str) -> Array:
        return np.concatenate([getattr(piece, name) for piece in pieces])

    return Along(
        time=joined("time"),
        position=joined("position"),
        velocity=joined("velocity"),
        acceleration=joined("acceleration"),
        direction=joined("direction"),
        force=joined("force"),
        spans=(),
        row_period=pieces[0].row_period,
    )
