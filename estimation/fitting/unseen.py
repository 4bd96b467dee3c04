"""Which parameters, or sums of them, no output shows."""

from collections.abc import Sequence

import numpy as np

from axisid.estimation.thresholds.fitting import MIN_SHOWN
from axisid.support.arrays import Array

_PART = 0.1  # of a direction's largest component: below it a parameter is not named
_EXACT = 1e-9


def unseen_directions(jacobian: Array, scale: Array) -> Array:
    """Directions in which the errors do not change, (k, P), of parameters over their scales.

    Parameters
    ----------
    jacobian : (n, P) array
        Of weighted errors, and of what was known before.
    scale : (P,) array
    """
    scaled = jacobian * scale
    sizes = np.linalg.norm(scaled, axis=0)
    largest = float(sizes.max(initial=0.0))
    seen = sizes > MIN_SHOWN.value * largest
    alone = np.asarray(np.eye(len(sizes))[~seen])
    if not seen.any():
        return np.asarray(alone)
    triangle = np.linalg.qr(scaled[:, seen] / sizes[seen], mode="r")
    _, values, rows = np.linalg.svd(triangle)
    lost = rows[: len(values)][values <= MIN_SHOWN.value * values[0]]
    together = np.zeros((len(lost), len(sizes)))
    together[:, seen] = lost / sizes[seen]
    together /= np.maximum(np.abs(together).max(axis=1, keepdims=True), _EXACT) if len(lost) else 1
    return np.vstack([alone, together])


def unseen_text(directions: Array, names: Sequence[str], scale: Array) -> tuple[str, ...]:
    """The directions in words: ``Fc``, ``M and m_add, of which only M + m_add``."""
    return tuple(_said(direction, names, scale) for direction in directions)


def _said(direction: Array, names: Sequence[str], scale: Array) -> str:
    parts = np.flatnonzero(np.abs(direction) > _PART * np.abs(direction).max())
    named = [names[int(j)] for j in parts]
    if len(named) == 1:
        return f"{named[0]} at all"
    # Of what does not change the outputs: by how much each goes with the first.
    moves = direction[parts] * scale[parts]
    moves = moves / moves[np.argmax(np.abs(moves))]
    told = ", ".join(f"{m:+.3g} of {n}" for m, n in zip(moves, named, strict=True))
    return f"{' and '.join(named)} apart ({told} together change nothing)"
