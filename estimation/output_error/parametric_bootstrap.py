"""Simulated replicas of a fit, and the moves of its parameters by a wrong control law.

Twins are its loops with the noise that is measured in the records.

The simulated loop answers to a law that is a little other as to what that adds to its control: each
term of the law with a factor of ``1 + eps`` is the loop with ``eps`` times that term injected. So
two lanes a term tell the slopes of the outputs, and with them what every percent of a term moves
each parameter by.
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
from axisid.support.errors import EstimationError, Missing
from axisid.support.settings import setting

from .covariance import Sandwich


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordLoops:
    """A record's simulated loops at a fit, and its noise.

    Attributes
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of its axis.
    chain : Chain
    quiet : Record
        The same without noise.
    """

    data: FilteredRecord
    physical: Array
    chain: Chain
    quiet: Record

    @classmethod
    def at(cls, form: ExtendedForm, physical: Array, place: int, record: Record) -> "RecordLoops":
        """Simulate the loops of the record at a place with parameters (P,), and measure its noise.

        Raises
        ------
        EstimationError
            There are too few rows, or its loops cannot be simulated.
        """
        axis, theta = axis_at(form.axes[place], form, physical), form.own(physical, place)
        # Friction that remembers has no rows near turns that others would do without.
        prefilter = Prefilter(reversals="keep" if axis.states else None)
        data = FilteredRecord.bind(axis, record, prefilter)
        data = data.by_position or data
        loops = recorded_loops(data, theta)
        chain, quiet = measured_noise(data, theta, loops), noise_free_record(data, loops).record
        return cls(data=data, physical=theta, chain=chain, quiet=quiet)

    def twins(self, chain: Chain, count: int, *, paired: bool) -> list[Record]:
        """Return replicas with a chain's noise that can be simulated; quiet ones without noise."""
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
    """Return the outputs of a fit by the noise of the records, (n, R).

    Parameters
    ----------
    records : sequence of RecordLoops or Missing
    physical : (P,) array
    predictions : OutputResiduals
        Of the records, settled there.
    count : int
    disturbed : bool
        Whether twins have the forces beside the control, or the noise of what is measured alone.
    paired : bool
        Whether they come in pairs of opposite noise.

    Raises
    ------
    EstimationError
        A record's noise could not be measured, or more than half of the twins cannot be simulated.
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
            f"Leave them out with {setting('bootstrap', '0')}.",
            code="noise",
        )
    still = predictions.outputs_of(quiet, physical)
    # As many of each record as the one with the fewest has.
    rows = [
        still
        if all(one is other for one, other in zip(each, quiet, strict=True))
        else predictions.outputs_of(each, physical)
        for each in zip(*twins, strict=False)
    ]
    return np.reshape(rows, (-1, len(still))).T - still[:, None]


def calibrated_covariance(
    sandwich: Sandwich, errors: Array, estimates: Array, residuals: Array
) -> Array:
    """Return the covariance by replicas, (k, k), with HAC of the scores as the pivot.

    The bootstrap-t of [EfronTibshirani1993]_: the covariance of ``h (theta_r - mean) / h_r``, with
    the HAC deviations ``h_r`` of the twins and ``h`` of the records. Intervals from it are
    Student's, with the degrees of freedom of `noise_models.pair_freedom`.

    Parameters
    ----------
    sandwich : Sandwich
    errors : (n,) array
        Weighted, of the records.
    estimates : (k, R) array
        What noise moves the parameters of the twins by.
    residuals : (n, R) array
        Weighted errors of the twins, less what their parameters make of them.
    """
    every = np.arange(len(errors))
    pieces = [every[rows][sandwich.counted[rows]] for rows in map(record_rows, sandwich.spans)]
    neighbours, chosen = RowTimes.joined([*map(RowTimes, pieces)]), np.concatenate(pieces)
    columns = sandwich.jacobian[chosen] @ sandwich.inverse

    def deviations(errors: Array) -> Array:
        applied = Hac().of_scores(columns * errors[chosen, None], neighbours)
        return np.sqrt(np.maximum(np.diag(applied.matrix), 0.0))

    of_errors, of_twins = deviations(errors), np.array([*map(deviations, residuals.T)])
    t = (estimates.T - estimates.mean(axis=1)) / np.where(of_twins > 0, of_twins, np.inf)
    return np.atleast_2d(np.cov((t * of_errors).T))


PERCENT = 0.01
_TWINS = 8
_LEVEL = 0.975  # at which eight twins are as sure as the normal law has it


def laws_in_twins(
    law: LawAgreement | Missing, loops: RecordLoops | Missing, found: EstimatedGains
) -> Sequence[LawAgreement]:
    """Return the law's agreement with replicas under the declared law; none without replicas.

    A control that answers to noise within a sample is no sum of its terms, and their deviations
    know of what stands in the rows alone.

    Parameters
    ----------
    law : LawAgreement or Missing
    loops : RecordLoops or Missing
        Of the record.
    found : EstimatedGains
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


#: What differs between the control and the law -> what that moves the parameters by, (P,), and
#: its deviations, (P,).
MovesByExplanation = Mapping[tuple[str, ...], tuple[Array, Array]]


def moves_by_explanation(
    slopes: Sequence[Mapping[str, Array]],
    laws: Sequence[LawAgreement | Missing],
    every: Sequence[RecordLoops | Missing],
    found: EstimatedGains,
) -> MovesByExplanation:
    """Return the moves of the parameters by each explanation of law and control.

    Each record moves them by its own values, minus what those of its twins do in the mean; one that
    does not tell them is taken for the mean of those that do.

    Parameters
    ----------
    slopes : sequence of mapping of str to (P,) array
        By record: change of the parameters per unit of each value of an `Explanation`.
    laws : sequence of LawAgreement or Missing
    every : sequence of RecordLoops or Missing
        Of the records, whose twins tell how sure the values are; `Explanation.deviations` do
        where there are none.
    found : EstimatedGains

    Returns
    -------
    mapping of tuple of str to ((P,) array, (P,) array)
        By kind of explanation, those of the gains alone and the plausible ones; none that no record
        tells.
    """
    kinds: list[tuple[str, ...]] = [(GAINS,)]
    kinds += [each.kind for law in laws if isinstance(law, LawAgreement) for each in law.plausible]
    twins = [laws_in_twins(law, loops, found) for law, loops in zip(laws, every, strict=True)]
    terms = [name for name in slopes[0] if name not in (SCALE, CONSTANT, DRIFT)]
    moves: dict[tuple[str, ...], tuple[Array, Array]] = {}
    for kind in dict.fromkeys(kinds):
        names = [name for name in kind if name != GAINS] + terms * (GAINS in kind)
        told = [_told(law, kind) for law in laws]
        # Nothing speaks against a declared limit that no record shows.
        limits = [each[LIMIT] for each in told if LIMIT in each] or [0.0]
        values = [_values(each, names, float(np.mean(limits))) for each in told]
        telling = [each for each in values if each is not None]
        if not telling or not names:
            continue
        mean, shifts, variances = np.mean(telling, axis=0), [], []
        for of_record, law, others, by in zip(values, laws, twins, slopes, strict=True):
            by_name = np.array([by[name] for name in names])
            shift = (mean if of_record is None else of_record) @ by_name
            in_twins = [_values(_told(each, kind), names, 0.0) for each in others]
            of_twins = [each @ by_name for each in in_twins if each is not None]
            if 2 * len(of_twins) >= _TWINS:
                count = len(of_twins)
                shift = shift - np.mean(of_twins, axis=0)
                widened = (1 + 1 / count) * (stdtrit(count - 1, _LEVEL) / ndtri(_LEVEL)) ** 2
                variances.append(widened * np.var(of_twins, axis=0, ddof=1))
            elif isinstance(law, LawAgreement):
                sure = next((e.deviations for e in law.explanations if e.kind == kind), {})
                deviations = np.array([sure.get(name, 0.0) for name in names])
                variances.append(deviations**2 @ by_name**2)
            shifts.append(shift)
        moves[kind] = (np.asarray(np.sum(shifts, axis=0)), np.sqrt(np.sum(variances, axis=0)))
    return moves


def _told(law: LawAgreement | Missing, kind: tuple[str, ...]) -> Mapping[str, float]:
    """Return values of an explanation of a kind; none where the law has none."""
    explanations = () if isinstance(law, Missing) else law.explanations
    for each in explanations:
        if each.kind == kind and not each.turns_a_sign:
            return each.values
    return {}


def _values(told: Mapping[str, float], names: Sequence[str], limit: float) -> Array | None:
    """Return values by name, (k,), with that of a limit that is not shown; None without."""
    values = {LIMIT: limit, **told}
    if not told or not {*names} <= {*values}:
        return None
    return np.array([values[name] for name in names])
