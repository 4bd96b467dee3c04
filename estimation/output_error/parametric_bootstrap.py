"""Simulated replicas of a fit, and the bias of its parameters by a wrong control law.

Replicas are the simulated loops with the noise that was measured in the records.

A small change of the law acts on the simulated loop like a signal added to its control: a term of
the law with a factor of ``1 + eps`` is the loop with ``eps`` times that term injected. Two
simulations per term therefore give the derivatives of the outputs, and with them the change of each
parameter per percent of a term.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri, stdtrit

from axisid.estimation.diagnostics.control_law import (
    CONSTANT,
    DRIFT,
    GAINS,
    SCALE,
    EstimatedGains,
    LawAgreement,
    found_law_agreement,
)
from axisid.estimation.law_replay import LIMIT
from axisid.estimation.noise_models import Chain, measured_noise, noise_free_record, twins_of
from axisid.estimation.output_residuals import OutputResiduals, record_rows
from axisid.estimation.records import Record
from axisid.estimation.regression import Hac, recorded_loops
from axisid.estimation.signals import FilteredRecord, Prefilter, RowTimes
from axisid.estimation.unknowns import ExtendedForm, axis_at
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.settings import setting

from .covariance import Sandwich


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordLoops:
    """A record's simulated loops at a fit, and its noise.

    Attributes
    ----------
    data : FilteredRecord
        The record, filtered, with measured velocity and acceleration left out.
    physical : (p,) array
        Parameters of the record's axis.
    chain : Chain
        Noise of the record.
    quiet : Record
        The simulated record without noise.
    """

    data: FilteredRecord
    physical: Array
    chain: Chain
    quiet: Record

    @classmethod
    def at(cls, form: ExtendedForm, physical: Array, place: int, record: Record) -> "RecordLoops":
        """Simulate the loops of a record with parameters (P,), and estimate its noise.

        Raises
        ------
        EstimationError
            There are too few rows, or its loops cannot be simulated.
        """
        axis, theta = axis_at(form.axes[place], form, physical), form.own(physical, place)
        # Friction with internal state needs the rows near velocity reversals.
        prefilter = Prefilter(reversals="keep" if axis.states else None)
        data = FilteredRecord.bind(axis, record, prefilter)
        data = data.by_position or data
        loops = recorded_loops(data, theta)
        chain, quiet = measured_noise(data, theta, loops), noise_free_record(data, loops).record
        return cls(data=data, physical=theta, chain=chain, quiet=quiet)

    def twins(self, chain: Chain, count: int, *, paired: bool) -> list[Record]:
        """Return simulated replicas of the record, at most `count`.

        Replicas that cannot be simulated are left out. For a chain without noise, all replicas are
        the simulated record itself.

        Parameters
        ----------
        chain : Chain
            Noise of the replicas.
        count : int
            Number of replicas.
        paired : bool
            True for pairs of replicas with opposite noise.
        """
        if chain.is_silent:
            return [self.quiet] * count
        twins = twins_of(self.data, self.physical, chain, count, paired=paired)
        return [twin.record for twin in twins]


def outputs_by_noise(
    records: Sequence[RecordLoops | Missing],
    physical: Array,
    predictions: OutputResiduals,
    count: int,
    *,
    disturbed: bool,
    paired: bool,
) -> Array:
    """Return the changes of the outputs of a fit by the noise of the records, (n, R).

    Parameters
    ----------
    records : sequence of RecordLoops or Missing
        Loops and noise of each record; Missing if the noise could not be estimated.
    physical : (P,) array
        Parameters of the fit.
    predictions : OutputResiduals
        Predictions for the records, settled at these parameters.
    count : int
        Number R of simulated replicas.
    disturbed : bool
        True for replicas with disturbance forces; False for measurement noise only.
    paired : bool
        True for pairs of replicas with opposite noise.

    Raises
    ------
    EstimationError
        The noise of a record could not be estimated, or more than half of the replicas cannot be
        simulated.
    """
    twins: list[list[Record]] = []
    quiet: list[Record] = []
    for of in records:
        if isinstance(of, Missing):
            raise EstimationError(of.reason, code="noise")
        chain = of.chain if disturbed else replace(of.chain.likeliest, disturbances=())
        twins.append(of.twins(chain, count, paired=paired))
        quiet.append(of.quiet)
    fewest = min(map(len, twins))
    if 2 * fewest < count:
        raise EstimationError(
            f"only {fewest} of {count} replicas could be simulated with the noise of the records. "
            f"Fit without replicas: {setting('bootstrap', '0')}.",
            code="noise",
        )
    without_noise = predictions.outputs_of(quiet, physical)
    # The same number of replicas of each record: the fewest of any record.
    rows: list[Array] = []
    for replica in zip(*twins, strict=False):
        if all(one is other for one, other in zip(replica, quiet, strict=True)):
            rows.append(without_noise)  # no record has noise
        else:
            rows.append(predictions.outputs_of(replica, physical))
    return np.reshape(rows, (-1, len(without_noise))).T - without_noise[:, None]


def calibrated_covariance(
    sandwich: Sandwich, errors: Array, estimates: Array, residuals: Array
) -> Array:
    """Return the covariance by replicas, (k, k), with HAC standard errors of scores as the pivot.

    It is the bootstrap-t of [EfronTibshirani1993]_: the covariance of ``h (theta_r - mean) / h_r``,
    with the HAC standard errors ``h_r`` of the replicas and ``h`` of the records. Intervals from
    this covariance are Student's, with the degrees of freedom of `noise_models.pair_freedom`.

    Parameters
    ----------
    sandwich : Sandwich
        Parts of the covariance of the fit to the records.
    errors : (n,) array
        Weighted errors of the records.
    estimates : (k, R) array
        Changes of the parameters of the replicas by noise.
    residuals : (n, R) array
        Weighted residuals of the replicas at their own parameters.
    """
    every = np.arange(len(errors))
    pieces = [every[rows][sandwich.counted[rows]] for rows in map(record_rows, sandwich.spans)]
    neighbours, chosen = RowTimes.joined([*map(RowTimes, pieces)]), np.concatenate(pieces)
    columns = sandwich.jacobian[chosen] @ sandwich.inverse

    def standard_errors(errors: Array) -> Array:
        """Return the HAC standard errors of the parameters, (k,), for weighted errors (n,)."""
        applied = Hac().of_scores(columns * errors[chosen, None], neighbours)
        return np.sqrt(np.maximum(np.diag(applied.matrix), 0.0))

    of_errors, of_twins = standard_errors(errors), np.array([*map(standard_errors, residuals.T)])
    t = (estimates.T - estimates.mean(axis=1)) / np.where(of_twins > 0, of_twins, np.inf)
    return np.atleast_2d(np.cov((t * of_errors).T))


#: Relative change of a term of the law, for which changes of the parameters are reported.
PERCENT = 0.01
_TWINS = 8  # simulated replicas for the uncertainty of an explanation
_LEVEL = 0.975  # probability at which Student's quantile replaces the normal quantile


def laws_in_twins(
    law: LawAgreement | Missing, loops: RecordLoops | Missing, found: EstimatedGains
) -> Sequence[LawAgreement]:
    """Return the agreement of the declared law with each simulated replica of a record.

    Replicas are needed because the control reacts to noise within a sample, which is not in the
    rows: the standard errors from the rows alone do not include this reaction. Empty if the law
    cannot be compared or has no explanations, or if there is no noise for replicas.

    Parameters
    ----------
    law : LawAgreement or Missing
        Agreement of the declared law with the record.
    loops : RecordLoops or Missing
        Simulated loops of the record.
    found : EstimatedGains
        Gains of the law that the fit estimated.
    """
    if (
        isinstance(law, Missing)
        or isinstance(loops, Missing)
        or not law.explanations
        or loops.chain.is_silent
    ):
        return []
    twins = loops.twins(loops.chain, _TWINS, paired=False)
    checked = [found_law_agreement(loops.data.axis, twin, found) for twin in twins]
    return [each for each in checked if isinstance(each, LawAgreement)]


#: Kind of an explanation -> changes of the parameters by it, (P,), and their standard errors, (P,).
MovesByExplanation = Mapping[tuple[str, ...], tuple[Array, Array]]


def moves_by_explanation(
    slopes: Sequence[Mapping[str, Array]],
    laws: Sequence[LawAgreement | Missing],
    every: Sequence[RecordLoops | Missing],
    found: EstimatedGains,
) -> MovesByExplanation:
    """Return the changes of the parameters by each explanation of the difference from the law.

    An explanation has values, such as factors of gains or an offset of the control. The values of
    each record, times the derivatives of the parameters, are the change that the record causes. The
    mean change of its simulated replicas is subtracted, and the changes of all records are added. A
    record without values is given the mean of the others.

    Parameters
    ----------
    slopes : sequence of mapping of str to (P,) array
        By record: change of the parameters per unit of each value of an `Explanation`.
    laws : sequence of LawAgreement or Missing
        Agreement of the declared law with each record.
    every : sequence of RecordLoops or Missing
        Simulated loops of the records. Their replicas give the standard errors; without replicas,
        the standard errors are those of `Explanation.deviations`.
    found : EstimatedGains
        Gains of the law that the fit estimated.

    Returns
    -------
    mapping of tuple of str to ((P,) array, (P,) array)
        Changes and their standard errors by kind of explanation: gains alone, and every plausible
        kind; without kinds for which no record has values.
    """
    kinds: list[tuple[str, ...]] = [(GAINS,)]
    kinds += [each.kind for law in laws if isinstance(law, LawAgreement) for each in law.plausible]
    twins = [laws_in_twins(law, loops, found) for law, loops in zip(laws, every, strict=True)]
    terms = [name for name in slopes[0] if name not in (SCALE, CONSTANT, DRIFT)]
    moves: dict[tuple[str, ...], tuple[Array, Array]] = {}
    for kind in dict.fromkeys(kinds):
        # Values of this explanation in each record.
        names = [name for name in kind if name != GAINS] + terms * (GAINS in kind)
        explained = [_explained(law, kind) for law in laws]
        # A declared limit that no record shows is taken as correct.
        limits = [each[LIMIT] for each in explained if LIMIT in each] or [0.0]
        values = [_values(each, names, float(np.mean(limits))) for each in explained]
        known = [each for each in values if each is not None]
        if not known or not names:
            continue
        # Change by each record, and its variance over replicas or from the rows.
        mean, shifts, variances = np.mean(known, axis=0), [], []
        for of_record, law, others, by in zip(values, laws, twins, slopes, strict=True):
            by_name = np.array([by[name] for name in names])
            shift = (mean if of_record is None else of_record) @ by_name
            in_twins = [_values(_explained(each, kind), names, 0.0) for each in others]
            of_twins = [each @ by_name for each in in_twins if each is not None]
            if 2 * len(of_twins) >= _TWINS:
                count = len(of_twins)
                shift = shift - np.mean(of_twins, axis=0)
                widened = (1 + 1 / count) * (stdtrit(count - 1, _LEVEL) / ndtri(_LEVEL)) ** 2
                variances.append(widened * np.var(of_twins, axis=0, ddof=1))
            elif isinstance(law, LawAgreement):
                stated = next((e.deviations for e in law.explanations if e.kind == kind), {})
                standard_errors = np.array([stated.get(name, 0.0) for name in names])
                variances.append(standard_errors**2 @ by_name**2)
            shifts.append(shift)
        moves[kind] = (np.asarray(np.sum(shifts, axis=0)), np.sqrt(np.sum(variances, axis=0)))
    return moves


def _explained(law: LawAgreement | Missing, kind: tuple[str, ...]) -> Mapping[str, float]:
    """Return the values of the explanation of one kind, by name of the value.

    Empty if the law cannot be compared, has no such explanation, or a gain would change its sign.
    """
    explanations = () if isinstance(law, Missing) else law.explanations
    for each in explanations:
        if each.kind == kind and not each.turns_a_sign:
            return each.values
    return {}


def _values(explained: Mapping[str, float], names: Sequence[str], limit: float) -> Array | None:
    """Return the values of an explanation in the order of k names, (k,).

    A limit of the drive that the record does not show has the value `limit`. None if another value
    is missing, or if there are no values.
    """
    values = {LIMIT: limit, **explained}
    if not explained or not {*names} <= {*values}:
        return None
    return np.array([values[name] for name in names])
