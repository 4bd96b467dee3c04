"""Twins of a fit, and what a control law that is not the drive's moves it by.

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

from .covariance import Sandwich


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordLoops:
    """A record's loops at a fit, and the noise that it has beside them.

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
        """As many with a chain's noise as can be simulated; of a silent one all are quiet."""
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
    """What the noise of records makes of the outputs of a fit, (n, R).

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
            f"{fewest} of {count} twins could be simulated with the noise of the records; leave "
            "the bootstrap out.",
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
    """Covariance of parameters, (k, k), by twins, the HAC covariance of scores as the pivot.

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


def factors_in_twins(
    law: LawAgreement | Missing, loops: RecordLoops | Missing, found: EstimatedGains
) -> Sequence[Mapping[str, float]]:
    """Factors that the law has in twins, which are under the declared one; none without twins.

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
        or not law.factors
        or loops.chain.is_silent
    ):
        return []
    twins = loops.twins(loops.chain, _TWINS, paired=False)
    checked = (found_law_agreement(loops.data.axis, twin, found) for twin in twins)
    factors = [each.factors for each in checked if isinstance(each, LawAgreement)]
    same = [each for each in factors if each.keys() == law.factors.keys()]
    return same if 2 * len(same) >= _TWINS else []


def move_by_record(
    of_records: Sequence[Mapping[str, Array]],
    laws: Sequence[LawAgreement | Missing],
    every: Sequence[RecordLoops | Missing],
    found: EstimatedGains,
) -> tuple[Array, Array] | None:
    """What the law as the records have it, less the declared one, moves the parameters by, (P,).

    Each record moves them by its own factors, less what those of its twins do in the mean; one that
    does not tell them is taken for the mean of those that do.

    Parameters
    ----------
    of_records : sequence of mapping of str to (P,) array
        Of each term, 1 % larger, by its gains.
    laws : sequence of LawAgreement or Missing
    every : sequence of RecordLoops or Missing
        Of the records, whose twins tell how sure the factors are; `LawAgreement.deviations` do
        where there are none.
    found : EstimatedGains

    Returns
    -------
    ((P,) array, (P,) array) or None
        With its deviations, of how sure the factors are. None where no record tells the law's
        factors, or only those of another sign.
    """
    names = [*of_records[0]]
    told = [law.factors if isinstance(law, LawAgreement) else {} for law in laws]
    # Nothing speaks against a declared limit that no record shows.
    shown = [each[LIMIT] for each in told if each.get(LIMIT, 0.0) > 0] or [1.0]
    factors = [{LIMIT: float(np.mean(shown))} | each for each in told]
    # Of a law with another sign, straight lines from the declared one tell nothing.
    factors = [f if all(f.get(name, 0.0) > 0 for name in names) else {} for f in factors]
    telling = [each for each in factors if each]
    if not telling or not names:
        return None
    mean = {name: float(np.mean([each[name] for each in telling])) for name in names}
    shifts, variances = [], []
    for moves, of_record, law, loops in zip(of_records, factors, laws, every, strict=True):
        twins = factors_in_twins(law, loops, found)
        table = np.array([[f.get(n, 1.0) for n in names] for f in (of_record or mean, *twins)])
        slopes = np.array([moves[n] for n in names]) / PERCENT
        shift, *of_twins = (table - 1) @ slopes
        if twins:
            count = len(twins)
            shift = shift - np.mean(of_twins, axis=0)
            widened = (1 + 1 / count) * (stdtrit(count - 1, _LEVEL) / ndtri(_LEVEL)) ** 2
            variances.append(widened * np.var(of_twins, axis=0, ddof=1))
        elif isinstance(law, LawAgreement):
            deviations = np.array([law.deviations.get(n, 0.0) for n in names])
            variances.append(deviations**2 @ slopes**2)
        shifts.append(shift)
    return np.asarray(np.sum(shifts, axis=0)), np.sqrt(np.sum(variances, axis=0))
