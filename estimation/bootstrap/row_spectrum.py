"""Power by bands of frequencies of a record's rows, of what no column of the model explains."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .noise_model import spectrum

_DRAWS = 16  # of a disturbance, through filter and projection
_BANDS = 22
_MOST_LEVERAGE = 0.8  # of a frequency: where columns take nearly all, nothing is told
_RANK = 1e-6
_ROWS_A_COLUMN = 4
_HIGHEST = 0.6  # of the frequencies of rows: what the filter leaves as it is


@dataclass(frozen=True, kw_only=True)
class RowSpectrum:
    """A record's rows in time, without what columns explain of them.

    Attributes
    ----------
    places : (n,) array of int
        Of the rows, among those that no rest and no gap leaves out.
    basis : (n, r) array
        Orthonormal, of the columns.
    bands : (b + 1,) array of int
        First frequency of each band, and the one after the last.
    counts : (b,) array
        Frequencies of each, less what the columns take.
    """

    places: NDArray[np.int64]
    basis: Array
    bands: NDArray[np.int64]
    counts: Array

    @classmethod
    def of(cls, data: FilteredRecord, quiet: FilteredRecord) -> "RowSpectrum":
        """Of a record, with the columns of its loop.

        Raises
        ------
        EstimationError
            There are too few rows for a band.
        """
        numbers = np.round(data.sampling.rows).astype(np.int64)
        places = (numbers - numbers[:1]) // data.prefilter.decimate
        count = int(places.max(initial=0)) + 1
        if _HIGHEST * count / 2 < _BANDS:
            raise EstimationError("its rows are too few to tell their noise.", code="too-short")
        bands = np.unique(np.geomspace(1.0, _HIGHEST * count / 2, _BANDS + 1).astype(np.int64))
        rows = cls(
            places=places,
            basis=_basis(data, quiet),
            bands=bands,
            counts=np.ones(len(bands) - 1),
        )
        taken = np.sum(np.abs(rows._transform(rows.basis)) ** 2, axis=1) / len(places)
        taken = np.minimum(taken, _MOST_LEVERAGE)
        return replace(rows, counts=rows._by_band(1 - taken))

    def power(self, rows: Array, others: Array | None = None) -> Array:
        """Mean power by band of rows, (n,) or of several (n, m), (b,); or what others share of it.

        Of what the columns do not explain of either.
        """
        every = (rows,) if others is None else (rows, others)
        lacking = [self._transform(each - self.basis @ (self.basis.T @ each)) for each in every]
        power = np.real(np.conj(lacking[0]) * lacking[-1]).mean(axis=1) / len(rows)
        return self._by_band(power) / self.counts

    def _by_band(self, values: Array) -> Array:
        """Sums of values by frequency."""
        return np.asarray(np.add.reduceat(values, self.bands)[:-1], dtype=float)

    def _transform(self, rows: Array) -> NDArray[np.complex128]:
        """Of rows (n,) or columns (n, m), by frequency, (f, m)."""
        placed = np.zeros((self.places[-1] + 1, *rows.shape[1:]))
        placed[self.places] = rows
        return np.asarray(np.fft.rfft(placed.reshape(len(placed), -1), axis=0))

    def power_of_disturbances(self, data: FilteredRecord, times: Sequence[float]) -> Array:
        """Power by band of disturbances of deviation 1 and correlation times, (m, b).

        White ones pass the record's filter; others have their colour put on the rows.
        """
        whole, rng = data.without(()), np.random.default_rng(0)
        first, every = round(float(data.sampling.rows[0])), data.prefilter.decimate
        places = (np.round(whole.sampling.rows).astype(np.int64) - first) // every
        white = np.zeros((int(places[-1] - places[0]) + 1, _DRAWS))
        for draw in range(_DRAWS):
            noise = rng.standard_normal(len(data))
            white[places - places[0], draw] = whole.reduce(whole.force_by(noise))
        here = self.places - places[0]
        weights = data.sampling.weights / whole.sampling.weights.max()
        transformed = np.fft.rfft(white, axis=0)
        powers = []
        for time in times:
            colour = spectrum(time / data.period, len(white), every)
            rows = np.fft.irfft(transformed * np.sqrt(colour)[:, None], len(white), axis=0)
            powers.append(self.power(weights[:, None] * rows[here]))
        return np.array(powers)


def _basis(data: FilteredRecord, quiet: FilteredRecord) -> Array:
    """Orthonormal columns of the model and what it may lack, with what changes each, (n, r)."""
    signals = quiet.signals
    time = np.linspace(-1.0, 1.0, len(data))
    ones, speed = np.ones_like(time), np.abs(signals.velocity)
    lacking = [ones, signals.position, signals.velocity, signals.direction]
    forces = np.abs(signals.force), np.gradient(signals.force)
    declared = InverseForm(data.axis).equations(signals).regressor
    columns = np.column_stack([declared, *lacking, *forces])
    changing = [ones, time, np.sign(time), signals.position, speed, signals.direction]
    most = max(len(data.sampling.rows) // (_ROWS_A_COLUMN * columns.shape[1]), 1)
    # One after the other: all samples of all columns are much more than their rows.
    every = np.hstack([data.reduce(columns * each[:, None]) for each in changing[:most]])
    norms = np.linalg.norm(every, axis=0)
    basis, sizes, _ = np.linalg.svd(every[:, norms > 0] / norms[norms > 0], full_matrices=False)
    return np.asarray(basis[:, sizes > _RANK * sizes[0]])
