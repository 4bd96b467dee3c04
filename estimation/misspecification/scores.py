"""Residuals of a record and of its twins, and tests of columns that the model has not.

A column beside the model is told by ``s = C'e``: C less what the instruments span, and e the
residuals of instrumental variables. What s is under the model, the twins say: the loop simulated
with the noise of the record, and solved alike. So noise that shakes friction, the steps of an
encoder and the filter's own error are allowed for, whatever estimator is judged.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth
from scipy.special import fdtrc

from axisid.estimation.estimates import Estimate
from axisid.estimation.noise_models import DEFAULT_TWIN_COUNT, Chain, noise_free_record, twins_of
from axisid.estimation.regression import (
    Equations,
    Hac,
    InverseForm,
    hotelling_p_value,
    loop_carries_noise,
    recorded_loops,
)
from axisid.estimation.signals import FilteredRecord, Signals
from axisid.support.arrays import Array
from axisid.support.errors import Missing

from .terms import Along

_FEWEST_ROWS = 8  # for each column: twins tell what chance makes of so few
_RANK = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnTests:
    """Tests of blocks of g columns beside the model, one for each of m places.

    Attributes
    ----------
    p_values : (m,) array
        Of each block by itself; 1 where the model's own columns span it.
    values : (m, g) array
        Factors of the columns.
    covariances : (m, g, g) array
        Of the factors.
    powers : (m,) array
        Mean square that each takes of the residuals.
    """

    p_values: Array
    values: Array
    covariances: Array
    powers: Array

    @property
    def whole_powers(self) -> Array:
        """What the first column of each takes where its factor is 1, (m,)."""
        first = self.values[:, 0]
        sizes = np.where(first == 0, np.inf, first)
        return np.asarray(self.powers * (2 / sizes - 1 / sizes**2))


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordScores:
    """Residuals of a record and of its twins beside the columns of a model.

    Attributes
    ----------
    basis : (n, r) array
        Orthonormal: what instruments, and columns that were added to them, span.
    columns : (n, k + j) array
        Of the free parameters, as they were measured, and those that were added.
    free : (k,) array of int
        Which parameters of the axis these are.
    regressor : (n, p) array
        Of the loop without noise, by all parameters.
    residuals : (n, 1 + R) array
        Of the record, then of its twins.
    force : (n,) array
        The left side.
    form : InverseForm
    physical : (p,) array
        The estimate that twins are at.
    signals : Signals
        The motion of which columns are made, of the loop where there is one.
    along, measured : Along
        The same with what rows make of it, and the motion as it was measured.
    data, quiet : FilteredRecord
        The record, and the same as its loop has it, where there is one.
    """

    basis: Array
    columns: Array
    free: NDArray[np.int64]
    regressor: Array
    residuals: Array
    force: Array
    form: InverseForm
    physical: Array
    signals: Signals
    along: Along
    measured: Along
    data: FilteredRecord
    quiet: FilteredRecord

    @property
    def twins(self) -> int:
        """How many there are."""
        return int(self.residuals.shape[1]) - 1

    @property
    def by_loop(self) -> bool:
        """Whether instruments and columns are of the simulated loop."""
        return self.signals is not self.data.signals

    @cached_property
    def net_residuals(self) -> Array:
        """Residuals beyond twins', less what is in the basis, of record and twins, (n, 1 + R)."""
        net_residuals = self.residuals - self.basis @ (self.basis.T @ self.residuals)
        if self.twins:
            net_residuals -= net_residuals[:, 1:].mean(axis=1, keepdims=True)
            # The mean holds a twin itself, and the record not: beside the mean of the others.
            net_residuals[:, 1:] *= self.twins / max(self.twins - 1, 1)
        return net_residuals

    def with_columns(self, columns: Array) -> "RecordScores":
        """With columns (n, g) taken into the model."""
        own = columns - self.basis @ (self.basis.T @ columns)
        sizes, least = np.linalg.norm(own, axis=0), _RANK * np.linalg.norm(columns, axis=0)
        shown = sizes > least  # none of a column that the model spans, or that no row shows
        return replace(
            self,
            basis=np.hstack([self.basis, np.linalg.qr(own[:, shown] / sizes[shown])[0]]),
            columns=np.hstack([self.columns, columns]),
        )

    def nearest(self, instruments: Array, columns: Array) -> int:
        """The place of columns (n, m, g) that fits the residuals best, by their instruments.

        What is measured stands in the columns, noise and all; the instruments, of the same shape,
        are of the loop.
        """
        span = instruments.reshape(len(instruments), -1)
        # Instruments of near places differ by less.
        u = orth(span - self.basis @ (self.basis.T @ span), 1e-3)
        left, taken = u.T @ self.net_residuals[:, 0], list[float]()
        for own in np.moveaxis(columns, 1, 0):
            seen = u.T @ (own - self.basis @ (self.basis.T @ own))
            taken.append(float(left @ seen @ np.linalg.lstsq(seen, left, rcond=None)[0]))
        return int(np.argmax(taken))

    def moved_by(self, columns: Array, values: Array) -> Array:
        """What the free parameters move by where so much of columns (n, g) is taken in, (k,)."""
        by = self.basis.T @ (columns @ values)
        moved = np.linalg.lstsq(self.basis.T @ self.columns, by, rcond=_RANK)[0]
        return -np.asarray(moved[: len(self.free)])

    def test(self, columns: Array) -> ColumnTests:
        """Test columns, (n, m, g), those of each place beside the model."""
        (n, m, g), flat = columns.shape, columns.reshape(len(columns), -1)
        of_place = np.ascontiguousarray(np.moveaxis(columns, 0, 1))
        whole, within = of_place.transpose(0, 2, 1) @ of_place, flat.T @ self.basis
        own = whole - (by_place := within.reshape(m, g, -1)) @ by_place.transpose(0, 2, 1)
        scores = (flat.T @ self.residuals - within @ (self.basis.T @ self.residuals)).reshape(
            m, g, -1
        )
        # Of which the model's columns do not span a block, nor its own each other.
        sizes = np.sqrt(np.einsum("mgg->mg", whole))
        is_there = np.all(sizes > 0, axis=1)
        sizes = np.where(is_there[:, None], sizes, 1.0)
        correlations = own / sizes[:, :, None] / sizes[:, None, :]
        # A twentieth of a column is its own: beside less its deviation is twenty times as large.
        is_own = is_there & (np.linalg.eigvalsh(correlations)[:, 0] > 0.05**2)
        own = np.where(is_own[:, None, None], own, np.eye(g))
        away = scores[:, :, 0] - (scores[:, :, 1:].mean(axis=2) if self.twins else 0.0)
        values = np.asarray(np.linalg.solve(own, away[:, :, None])[:, :, 0], dtype=float)
        powers = np.where(is_own, np.einsum("mg,mg->m", away, values) / n, 0.0)
        p_values, spread = (
            self._by_twins(away, scores[:, :, 1:], is_own)
            if self.twins
            else self._by_hac(columns, values, own, powers)
        )
        inverse = np.linalg.inv(own)
        return ColumnTests(
            p_values=np.where(is_own, p_values, 1.0),
            values=np.where(is_own[:, None], values, 0.0),
            covariances=inverse @ spread @ inverse,
            powers=powers,
        )

    def _by_twins(
        self, away: Array, scores: Array, is_own: NDArray[np.bool_]
    ) -> tuple[Array, Array]:
        """Hotelling's test of each block, and the covariance of its scores, (m, g, g)."""
        _, g, count = scores.shape
        apart = scores - scores.mean(axis=2, keepdims=True)
        spread = np.einsum("mgr,mhr->mgh", apart, apart) / (count - 1)
        spread = np.where(is_own[:, None, None], spread, np.eye(g))
        square = np.einsum("mg,mg->m", away, np.linalg.solve(spread, away[:, :, None])[:, :, 0])
        square *= count / (count + 1) * (count - g) / (g * (count - 1))
        return np.asarray(fdtrc(g, count - g, square)), spread

    def _by_hac(
        self, columns: Array, values: Array, own: Array, powers: Array
    ) -> tuple[Array, Array]:
        """Wald's test, HAC, of the block that takes most, which the score test has to confirm.

        Wald's alone is misled by few rows in slow noise; the score test knows nothing of what is
        nearly all of the residuals.
        """
        m, g = values.shape
        p_values, spread, place = np.ones(m), np.zeros((m, g, g)), int(np.argmax(powers))
        if not powers[place] > 0:
            return p_values, spread
        block = columns[:, place] - self.basis @ (self.basis.T @ columns[:, place])
        residuals, away, chances = self.net_residuals[:, 0], own[place] @ values[place], []
        for left in (residuals - block @ values[place], residuals):
            run = Hac().long_run(block * left[:, None], self.data.sampling.neighbours)
            square = float(away @ np.linalg.solve(run.matrix, away))
            chances.append((hotelling_p_value(square, g, float(np.min(run.freedom))), run.matrix))
        (wald, spread[place]), (score, _) = chances
        # Where it is most of the residuals, their covariance is that of the term itself.
        mostly = powers[place] > 0.8 * np.mean(residuals**2)
        p_values[place] = wald if mostly or score <= 0.01 else max(wald, score)
        return p_values, spread


def scores_of(
    data: FilteredRecord,
    physical: Array,
    chain: Chain | None,
    free: Sequence[int],
    *,
    by_loop: bool = False,
) -> RecordScores | Missing:
    """Residuals of a record and of twins at an estimate.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of the record's axis, less their bias.
    chain : Chain or None
        The record's noise; None where it could not be measured.
    free : sequence of int
        Which of the parameters are estimated; the others have the values that are given.
    by_loop : bool
        Whether the simulated loop gives the instruments without a chain too, from which no twins
        are made then.
    """
    if loop_carries_noise(data):
        return Missing(
            "the control law reads a velocity that is in no record, without which noise of the "
            "position is in the loop that follows it: record the reference"
        )
    form, quiet, moved = InverseForm(data.axis).at(physical), data, None
    twins: Iterable[FilteredRecord] = ()
    if chain is not None or by_loop:
        loops = recorded_loops(data, physical)
        quiet = noise_free_record(data, loops)
        # Without rows near rests and reversals of the loop, if rows are left then.
        moving = data.turning_as(quiet.record.position, also=True)
        if len(moving.sampling.rows) >= _FEWEST_ROWS * (len(data.axis.parameters) + 1):
            data = moving
        twins = () if chain is None else twins_of(data, physical, chain, DEFAULT_TWIN_COUNT)
        moved = Signals(
            position=quiet.record.position,
            velocity=np.concatenate([loop.velocity for loop in loops]),
            acceleration=np.concatenate([loop.acceleration for loop in loops]),
            force=np.concatenate([loop.force for loop in loops]),
            direction=np.concatenate([loop.direction for loop in loops]),
            recorded=data.recorded,
        )
        quiet = replace(quiet, prefilter=data.prefilter, excluded=data.excluded)
    k, n = len(free), len(data.sampling.rows)
    if n < _FEWEST_ROWS * (k + 1):
        return Missing(
            f"{n} rows in motion are too few to tell what the model lacks, which takes "
            f"{_FEWEST_ROWS * (k + 1)}; record a longer motion"
        )
    rows = form.equations(data.signals).reduced(data)
    clean = form.equations(quiet.signals).reduced(data)
    instruments = clean.regressor[:, free]
    sizes = np.linalg.norm(instruments, axis=0)
    basis = orth(instruments[:, sizes > 0] / sizes[sizes > 0], _RANK)
    # What the filter itself leaves of a loop.
    by_filter = 0.0 if moved is None else _residuals(clean, physical, free, basis)
    of_twins = [
        _residuals(form.equations(each.signals).reduced(data), physical, free, basis) - by_filter
        for each in twins
    ]
    if 2 * len(of_twins) < DEFAULT_TWIN_COUNT:
        of_twins = []  # which do not tell how they scatter
    return RecordScores(
        basis=basis,
        columns=rows.regressor[:, free],
        free=np.array(free, dtype=np.int64),
        regressor=clean.regressor,
        residuals=np.column_stack([_residuals(rows, physical, free, basis) - by_filter, *of_twins]),
        force=rows.left - rows.intercept,
        form=form,
        physical=physical,
        signals=moved or data.signals,
        measured=_along(data.signals, data),
        along=_along(moved or data.signals, data),
        data=data,
        quiet=quiet,
    )


def _residuals(rows: Equations, physical: Array, free: Sequence[int], basis: Array) -> Array:
    """Of instrumental variables, (n,), the parameters that are not free as they are."""
    residuals = rows.residuals(physical)
    columns = rows.regressor[:, free]
    change = np.linalg.lstsq(basis.T @ columns, basis.T @ residuals, rcond=_RANK)[0]
    return np.asarray(residuals - columns @ change)


def _along(s: Signals, data: FilteredRecord) -> Along:
    sampling = data.sampling
    rows = sampling.rows.astype(np.int64)
    time = data.period * np.arange(len(s.position), dtype=float)
    return Along(
        time=time - time[rows].mean(),
        position=s.position - (middle := float(s.position[rows].mean())),
        middle=middle,
        velocity=s.velocity,
        acceleration=s.acceleration,
        direction=s.direction,
        force=s.force,
        spans=sampling.spans,
        rows=rows,
        reduce=sampling.reduce,
        period=data.period,
        row_period=data.row_period,
    )


def scores_at(
    data: FilteredRecord, preferred: Estimate, *, by_loop: bool = False
) -> RecordScores | Missing:
    """Residuals of a record and of its twins at the judged estimate, as by `scores_of`."""
    chain = next(iter(preferred.inference.chains), None)
    at = preferred.physical if chain is None else preferred.corrected
    return scores_of(data, at, chain, range(len(at)), by_loop=by_loop)
