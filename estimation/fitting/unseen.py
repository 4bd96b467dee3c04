"""Which parameters no output shows, alone or together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.thresholds import MIN_SHOWN
from axisid.support.arrays import Array

# of the largest change of the outputs along a direction that they do not show; a parameter with
# as much is named
_MIN_PART = 0.1


@dataclass(frozen=True, slots=True)
class Unseen:
    """Directions in which parameters change and the outputs do not.

    Attributes
    ----------
    changes : (k, P) array
        What each parameter alone would change in the outputs, along each direction.
    moves : (k, P) array
        How the parameters move together.
    """

    changes: Array
    moves: Array

    @property
    def parts(self) -> NDArray[np.bool_]:
        """Which parameters are part of a direction, (k, P)."""
        size = np.abs(self.changes)
        return np.asarray(size > _MIN_PART * size.max(axis=1, keepdims=True, initial=0.0))

    def among(self, chosen: NDArray[np.bool_]) -> "Unseen":
        """The same of parameters of which these are the chosen ones."""
        into = np.eye(len(chosen))[chosen]
        return Unseen(self.changes @ into, self.moves @ into)

    def texts(self, names: Sequence[str]) -> tuple[str, ...]:
        """In words: ``Fc at all``, ``M and m apart (...)``."""
        pairs = zip(self.moves, self.parts, strict=True)
        return tuple(_said(moves, np.flatnonzero(parts), names) for moves, parts in pairs)


def unseen_directions(jacobian: Array, scale: Array) -> Unseen:
    """Directions in which the errors do not change.

    Parameters
    ----------
    jacobian : (n, P) array
        Of weighted errors, and of what was known before.
    scale : (P,) array
        Of the parameters.
    """
    scaled = jacobian * scale
    sizes = np.linalg.norm(scaled, axis=0)
    seen = sizes > MIN_SHOWN.value * sizes.max(initial=0.0)
    alone = np.eye(len(sizes))[~seen]
    if not seen.any():
        return Unseen(alone, alone)
    _, values, rows = np.linalg.svd(np.linalg.qr(scaled[:, seen] / sizes[seen], mode="r"))
    lost = rows[values <= MIN_SHOWN.value * values[0]]
    chosen = Unseen(lost, lost / sizes[seen] * scale[seen]).among(seen)
    return Unseen(np.vstack([alone, chosen.changes]), np.vstack([alone, chosen.moves]))


def _said(moves: Array, parts: NDArray[np.intp], names: Sequence[str]) -> str:
    named = [names[int(j)] for j in parts]
    if len(named) == 1:
        return f"{named[0]} at all"
    share = moves[parts] / moves[parts[0]]
    told = ", ".join(f"{m:+.3g} of {n}" for m, n in zip(share, named, strict=True))
    return f"{' and '.join(named)} apart ({told} together change nothing)"
