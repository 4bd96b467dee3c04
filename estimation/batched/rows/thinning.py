"""The filter before decimation as a sum of modes, so that only the rows that are kept are made.

Forward and backward, the filter's response is that of its poles, each once running forward and once
backward. Of such a sum a row in so many costs a few products of the samples in between, where the
sections one after the other make every sample. What the sections have at the ends of a stretch, the
modes have too: the forward pass starts as after a long time of the first value, the backward pass
as after one of the last that the forward pass made.
"""

import math

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.native import Thinning
from axisid.estimation.signals import DECIMATION_PADDING, SampledFilter
from axisid.support.arrays import Array

Modes = NDArray[np.complex128]


def thinning_of(sampled: SampledFilter, samples: int) -> Thinning:
    """Which rows a filter keeps of so many samples, and by what sums.

    Parameters
    ----------
    sampled : SampledFilter
        That decimates.
    samples : int
    """
    every = sampled.settings.decimate
    start, end = sampled.cut
    kept = samples - start - end
    ends = sampled.weightless_ends(samples)
    low, high = (ends[0][1], ends[1][0]) if ends else (0, kept)
    rows = sampled.rows_between(samples, 0, samples) - start
    first = int(rows[0])
    skipped = max(0, math.ceil((first - every + DECIMATION_PADDING) / every))
    begin = first - every * skipped
    last = kept - 1 + DECIMATION_PADDING
    blocks = math.ceil((last - begin) / every) + 1
    beyond = begin + every * (blocks - 1) - last
    poles, residues, gains, direct = _modes(sampled.decimation.sections)
    powers = poles ** np.arange(every + 1)[:, None]
    return Thinning(
        sizes=np.array(
            [
                start,
                kept,
                low,
                high,
                DECIMATION_PADDING,
                every,
                begin,
                skipped,
                blocks,
                len(rows),
            ],
            dtype=np.int64,
        ),
        powers=_pairs(powers),
        gains=_pairs(2 * gains.conj()),  # the real part of a product
        settled=_pairs(1 / (1 - poles)),
        ends=_ends(poles, residues, gains, beyond),
        direct=direct,
    )


def _modes(sections: Array) -> tuple[Modes, Modes, Modes, float]:
    """One pole of each pair, its residue, its gain forward and backward, and what is direct."""
    pairs = np.array([np.roots(section[3:]) for section in sections])
    poles: Modes = np.where(pairs[:, 0].imag > 0, pairs[:, 0], pairs[:, 1])
    every = np.concatenate([poles, poles.conj()])

    def numerator(delays: Modes) -> Modes:
        powers = delays[:, None, None] ** np.arange(3)
        return np.asarray(np.prod((powers * sections[:, :3]).sum(axis=-1), axis=-1))

    others = [np.prod(1 - every[every != pole] / pole) for pole in poles]
    residues = numerator(np.asarray(1 / poles, dtype=complex)) / np.array(others)
    behind = numerator(poles) / np.prod(1 - poles[:, None] * every, axis=1)
    first = float(np.prod(sections[:, 0]))
    last = float(np.prod(sections[:, 2] / sections[:, 5]))
    return poles, residues, residues * behind, first * last


def _ends(poles: Modes, residues: Modes, gains: Modes, beyond: int) -> Array:
    """What modes that run backward start from, by how far the forward ones are from settled.

    Both `beyond` samples after the last value, which goes on there.
    """
    ahead = np.concatenate([poles, poles.conj()])[None, :]
    weights = np.concatenate([residues, residues.conj()])
    own = poles[:, None]
    sums = own / (1 - own) - own * ahead / (1 - own * ahead)
    found = (residues / gains)[:, None] * own**-beyond * weights * ahead**-beyond * sums
    same, other = found[:, : len(poles)], found[:, len(poles) :]
    real, imaginary = same + other, 1j * (same - other)  # of the forward modes' parts
    matrix = np.empty((2 * len(poles),) * 2)
    matrix[0::2, 0::2], matrix[1::2, 0::2] = real.real, real.imag
    matrix[0::2, 1::2], matrix[1::2, 1::2] = imaginary.real, imaginary.imag
    return matrix


def _pairs(values: Modes) -> Array:
    """Real and imaginary parts in turn along the last axis."""
    parts = np.stack([values.real, values.imag], axis=-1)
    return parts.reshape(*values.shape[:-1], -1)
