"""Residuals of a record and of its simulated replicas, and tests of columns not in the model.

The columns that are tested come in blocks: a block has the columns of one hypothesis at one place,
such as cosine and sine of one period.

A column that is not in the model is tested by the score ``s = C'e``, with C the part of the column
that the instruments do not span, and e the residuals of instrumental variables. The distribution of
s for a correct model is that of simulated replicas: the loop is simulated with the noise of the
record, and solved in the same way. The test therefore allows for noise that changes friction, for
encoder steps and for the error of the filter, whatever the reported estimator is.
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
from axisid.support.missing import Missing

from .terms import Along

_FEWEST_ROWS = 8  # for each column; replicas give the distribution for so few rows
_RANK = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnTests:
    """Tests of blocks of g columns that are added to the model, one block for each of m places.

    Attributes
    ----------
    p_values : (m,) array
        P-value of each block alone; 1 where the columns of the model span it.
    values : (m, g) array
        Factors of the columns.
    covariances : (m, g, g) array
        Covariance of the factors.
    powers : (m,) array
        Mean square of the residuals that each block explains with the fitted factors.
    """

    p_values: Array
    values: Array
    covariances: Array
    powers: Array

    @property
    def whole_powers(self) -> Array:
        """Mean square of the residuals that the first column of each block explains, (m,).

        The column has a factor of 1, not the fitted factor.
        """
        first = self.values[:, 0]
        sizes = np.where(first == 0, np.inf, first)
        return np.asarray(self.powers * (2 / sizes - 1 / sizes**2))


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordScores:
    """Residuals of a record and of its simulated replicas, with the columns of the model.

    Attributes
    ----------
    basis : (n, r) array
        Orthonormal basis of the instruments and of the columns that were added to the model.
    columns : (n, k + j) array
        Measured columns of the free parameters, and added columns.
    free : (k,) array of int
        Indices of the free parameters of the axis.
    regressor : (n, p) array
        Regressor of all parameters along the loop without noise.
    residuals : (n, 1 + R) array
        Residuals of the record, then of its replicas.
    force : (n,) array
        Left side of the inverse model, minus its intercept.
    form : InverseForm
        Inverse model, at the estimate.
    physical : (p,) array
        Estimate that the replicas are simulated with.
    signals : Signals
        Motion for the columns: that of the simulated loop, or the measured motion without a loop.
    along, measured : Along
        The motion of `signals`, and the measured motion, each with the reduction to the rows.
    data, quiet : FilteredRecord
        The record, and the record with the motion of its simulated loop; the record itself without
        a loop.
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
        """Number of simulated replicas."""
        return int(self.residuals.shape[1]) - 1

    @property
    def by_loop(self) -> bool:
        """True if instruments and columns are those of the simulated loop."""
        return self.signals is not self.data.signals

    @cached_property
    def net_residuals(self) -> Array:
        """Residuals that the model cannot explain, minus the mean of the replicas, (n, 1 + R).

        The part of the residuals in `basis` is removed. The first column is of the record, the
        others are of its replicas.
        """
        net_residuals = self.residuals - self.basis @ (self.basis.T @ self.residuals)
        if self.twins:
            net_residuals -= net_residuals[:, 1:].mean(axis=1, keepdims=True)
            # The mean contains the replica itself, so it is compared with the mean of the others.
            net_residuals[:, 1:] *= self.twins / max(self.twins - 1, 1)
        return net_residuals

    def with_columns(self, columns: Array) -> "RecordScores":
        """Return the residuals and columns of a model with g further columns, (n, g).

        Columns that the model spans, or that are zero, do not extend the basis.
        """
        own = columns - self.basis @ (self.basis.T @ columns)
        sizes, least = np.linalg.norm(own, axis=0), _RANK * np.linalg.norm(columns, axis=0)
        shown = sizes > least
        return replace(
            self,
            basis=np.hstack([self.basis, np.linalg.qr(own[:, shown] / sizes[shown])[0]]),
            columns=np.hstack([self.columns, columns]),
        )

    def nearest(self, instruments: Array, columns: Array) -> int:
        """Return the index of the place whose measured columns fit the residuals best.

        The columns are fitted by two-stage least squares, because the measured motion has noise.

        Parameters
        ----------
        instruments : (n, m, g) array
            Columns of the simulated loop, at m places.
        columns : (n, m, g) array
            Columns of the measured motion, at the same places.
        """
        span = instruments.reshape(len(instruments), -1)
        # Instruments of neighbouring places differ by less than the tolerance, and count once.
        u = orth(span - self.basis @ (self.basis.T @ span), 1e-3)
        left, taken = u.T @ self.net_residuals[:, 0], list[float]()
        for own in np.moveaxis(columns, 1, 0):
            seen = u.T @ (own - self.basis @ (self.basis.T @ own))
            taken.append(float(left @ seen @ np.linalg.lstsq(seen, left, rcond=None)[0]))
        return int(np.argmax(taken))

    def moved_by(self, columns: Array, values: Array) -> Array:
        """Return the change of the free parameters, (k,), if columns are added to the model.

        `columns` are (n, g), and `values`, (g,), are their factors.
        """
        projected = self.basis.T @ (columns @ values)
        moved = np.linalg.lstsq(self.basis.T @ self.columns, projected, rcond=_RANK)[0]
        return -np.asarray(moved[: len(self.free)])

    def test(self, columns: Array) -> ColumnTests:
        """Return the tests of m blocks of columns, (n, m, g), each block alone added to the model.

        The scores of each block are computed, with the parts of the columns that the model does not
        span. The factors follow from the scores of the record minus the mean of the replicas. The
        test is by the scatter of the replicas, or by HAC without replicas.
        """
        (n, m, g), flat = columns.shape, columns.reshape(len(columns), -1)
        # Products of the columns of each block: whole, and of the parts that the model does not
        # span (`own`); and the scores of these parts.
        of_place = np.ascontiguousarray(np.moveaxis(columns, 0, 1))
        whole, within = of_place.transpose(0, 2, 1) @ of_place, flat.T @ self.basis
        by_place = within.reshape(m, g, -1)
        own = whole - by_place @ by_place.transpose(0, 2, 1)
        scores = (flat.T @ self.residuals - within @ (self.basis.T @ self.residuals)).reshape(
            m, g, -1
        )
        # Blocks that are independent of the model's columns, and whose columns are independent.
        sizes = np.sqrt(np.einsum("mgg->mg", whole))
        is_there = np.all(sizes > 0, axis=1)
        sizes = np.where(is_there[:, None], sizes, 1.0)
        correlations = own / sizes[:, :, None] / sizes[:, None, :]
        # A twentieth of a column must be independent: with less, the standard error of its factor
        # is more than 20 times as large.
        is_independent = is_there & (np.linalg.eigvalsh(correlations)[:, 0] > 0.05**2)
        own = np.where(is_independent[:, None, None], own, np.eye(g))
        # Factors of the columns, and the power of the residuals that they explain.
        away = scores[:, :, 0] - (scores[:, :, 1:].mean(axis=2) if self.twins else 0.0)
        values = np.asarray(np.linalg.solve(own, away[:, :, None])[:, :, 0], dtype=float)
        powers = np.where(is_independent, np.einsum("mg,mg->m", away, values) / n, 0.0)
        if self.twins:
            p_values, spread = self._by_replicas(away, scores[:, :, 1:], is_independent)
        else:
            p_values, spread = self._by_hac(columns, values, own, powers)
        inverse = np.linalg.inv(own)
        return ColumnTests(
            p_values=np.where(is_independent, p_values, 1.0),
            values=np.where(is_independent[:, None], values, 0.0),
            covariances=inverse @ spread @ inverse,
            powers=powers,
        )

    def _by_replicas(
        self, away: Array, scores: Array, is_independent: NDArray[np.bool_]
    ) -> tuple[Array, Array]:
        """Return the p-values of m blocks, (m,), and the covariances of their scores, (m, g, g).

        The test is Hotelling's, with the covariance of the replicas' scores. A block has g columns,
        and there are R replicas. Blocks that are not independent of the model's columns get the
        identity as covariance, so that it can be inverted; the caller ignores their p-values.

        Parameters
        ----------
        away : (m, g) array
            Scores of the record minus the mean of the replicas.
        scores : (m, g, R) array
            Scores of the replicas.
        is_independent : (m,) array of bool
            True for blocks that are independent of the model's columns.
        """
        _, g, R = scores.shape
        deviations = scores - scores.mean(axis=2, keepdims=True)
        spread = np.einsum("mgr,mhr->mgh", deviations, deviations) / (R - 1)
        spread = np.where(is_independent[:, None, None], spread, np.eye(g))
        square = np.einsum("mg,mg->m", away, np.linalg.solve(spread, away[:, :, None])[:, :, 0])
        square *= R / (R + 1) * (R - g) / (g * (R - 1))
        return np.asarray(fdtrc(g, R - g, square)), spread

    def _by_hac(
        self, columns: Array, values: Array, own: Array, powers: Array
    ) -> tuple[Array, Array]:
        """Return the p-values of m blocks, (m,), and the covariances of their scores, (m, g, g).

        Only the block that explains most is tested; the p-values of the others are 1. The test is
        Wald's with a HAC covariance, and is confirmed by the score test: the larger p-value of the
        two counts, unless the score test is significant or the block makes most of the residuals.
        Wald's test alone is misled by few rows in slow noise. The score test alone does not detect
        a term that makes nearly all of the residuals.

        Parameters
        ----------
        columns : (n, m, g) array
        values : (m, g) array
            Factors of the columns.
        own : (m, g, g) array
            Products of the parts of the columns that the model does not span.
        powers : (m,) array
            Mean square of the residuals that each block explains.
        """
        m, g = values.shape
        p_values, spread, place = np.ones(m), np.zeros((m, g, g)), int(np.argmax(powers))
        if not powers[place] > 0:
            return p_values, spread
        block = columns[:, place] - self.basis @ (self.basis.T @ columns[:, place])
        # Wald's test has the residuals with the block in the model, the score test those without.
        residuals, away, chances = self.net_residuals[:, 0], own[place] @ values[place], []
        for left in (residuals - block @ values[place], residuals):
            run = Hac().long_run(block * left[:, None], self.data.sampling.neighbours)
            square = float(away @ np.linalg.solve(run.matrix, away))
            chances.append((hotelling_p_value(square, g, float(np.min(run.freedom))), run.matrix))
        (wald, spread[place]), (score, _) = chances
        # If the term makes most of the residuals, their covariance is that of the term itself.
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
    """Return the residuals of a record and of its simulated replicas at an estimate.

    A loop without noise is simulated with the estimate, and gives the instruments. The replicas
    have the noise of the record. The record and each replica are solved by instrumental variables,
    and the residual of the loop without noise, which is due to the filter, is subtracted. Missing
    if the loop would follow the noise of the position, or if the record is too short.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of the record's axis, minus their bias.
    chain : Chain or None
        Noise of the record, for the replicas; None if the noise could not be measured.
    free : sequence of int
        Indices of the estimated parameters; the others have given values.
    by_loop : bool
        True if the simulated loop gives the instruments even without a chain, and thus without
        replicas.
    """
    if loop_carries_noise(data):
        return Missing(
            "the reference was not recorded, and the control law reads a velocity that is not in "
            "the record, so the simulated loop would follow the noise of the position. Record the "
            "reference"
        )
    # The loop without noise, its motion, and the replicas.
    form, quiet, loop_motion = InverseForm(data.axis).at(physical), data, None
    twins: Iterable[FilteredRecord] = ()
    if chain is not None or by_loop:
        loops = recorded_loops(data, physical)
        quiet = noise_free_record(data, loops)
        # Rows near rests and reversals of the loop are left out if enough rows remain.
        moving = data.turning_as(quiet.record.position, also=True)
        if len(moving.sampling.rows) >= _FEWEST_ROWS * (len(data.axis.parameters) + 1):
            data = moving
        twins = () if chain is None else twins_of(data, physical, chain, DEFAULT_TWIN_COUNT)
        loop_motion = Signals(
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
            f"the record has {n} rows in motion, but the search for missing terms needs at least "
            f"{_FEWEST_ROWS * (k + 1)} rows. Record a longer motion"
        )
    # Rows of the measured motion, and of the loop without noise, which gives the instruments.
    rows = form.equations(data.signals).reduced(data)
    clean = form.equations(quiet.signals).reduced(data)
    instruments = clean.regressor[:, free]
    sizes = np.linalg.norm(instruments, axis=0)
    basis = orth(instruments[:, sizes > 0] / sizes[sizes > 0], _RANK)
    # Residual of the simulated loop by the filter.
    by_filter = 0.0 if loop_motion is None else _residuals(clean, physical, free, basis)
    of_twins = [
        _residuals(form.equations(each.signals).reduced(data), physical, free, basis) - by_filter
        for each in twins
    ]
    if 2 * len(of_twins) < DEFAULT_TWIN_COUNT:
        of_twins = []  # too few for a covariance
    return RecordScores(
        basis=basis,
        columns=rows.regressor[:, free],
        free=np.array(free, dtype=np.int64),
        regressor=clean.regressor,
        residuals=np.column_stack([_residuals(rows, physical, free, basis) - by_filter, *of_twins]),
        force=rows.left - rows.intercept,
        form=form,
        physical=physical,
        signals=loop_motion or data.signals,
        measured=_along(data.signals, data),
        along=_along(loop_motion or data.signals, data),
        data=data,
        quiet=quiet,
    )


def _residuals(rows: Equations, physical: Array, free: Sequence[int], basis: Array) -> Array:
    """Return the residuals, (n,), of the free parameters' instrumental-variable estimate.

    Parameters
    ----------
    rows : Equations
    physical : (p,) array
        Parameters of the axis; parameters that are not in `free` keep these values.
    free : sequence of int
        Indices of the parameters that are estimated.
    basis : (n, r) array
        Orthonormal basis of the instruments.
    """
    residuals = rows.residuals(physical)
    columns = rows.regressor[:, free]
    change = np.linalg.lstsq(basis.T @ columns, basis.T @ residuals, rcond=_RANK)[0]
    return np.asarray(residuals - columns @ change)


def _along(s: Signals, data: FilteredRecord) -> Along:
    """Return the motion of signals `s`, with the reduction to the rows of the record `data`.

    Time and position are relative to their means over the rows.
    """
    sampling = data.sampling
    rows = sampling.rows.astype(np.int64)
    time = data.period * np.arange(len(s.position), dtype=float)
    middle = float(s.position[rows].mean())
    return Along(
        time=time - time[rows].mean(),
        position=s.position - middle,
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
    """Return the residuals of a record and of its replicas at the reported estimate, `preferred`.

    `data` and `by_loop` are those of `scores_of`, and so is Missing. The replicas have the first
    noise of the estimate; the parameters are then minus their bias.
    """
    chain = next(iter(preferred.inference.chains), None)
    at = preferred.physical if chain is None else preferred.corrected
    return scores_of(data, at, chain, range(len(at)), by_loop=by_loop)
