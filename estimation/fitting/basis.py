"""What a fit is judged from, once it is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, Levels
from axisid.estimation.diagnostics.law import LawCheck, law_check
from axisid.estimation.lacking import Lack
from axisid.estimation.predictions import Predictions
from axisid.estimation.records import Record
from axisid.estimation.searches import Elsewhere, Found
from axisid.estimation.thresholds import NOTICEABLE_BIAS
from axisid.estimation.twins import Chain
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .spread import Scores

MIN_MOVED_BY_START = 1.0  # deviations by the start of a loop, were that free, which then count


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovedByStart:
    """What parameters would move by if first positions and velocities were free with them.

    Attributes
    ----------
    moved, far : (P,) array
        In their units, and in their deviations; 0 where that matters to none.
    """

    moved: Array
    far: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitBasis:
    """What a fit is judged from.

    Attributes
    ----------
    axes : tuple of GeneratedAxis
        By record.
    own : tuple of (p,) array
        Parameters of each record's axis.
    chains : tuple of Chain
        The noise of each record; none without twins.
    predictions : Predictions
    best : Found
        The search that is told.
    ends : tuple of Found
        All searches.
    influence : (P, n) array
        Of the errors on the parameters.
    beyond : mapping of str to float
        How far beyond its bound each parameter at one would be without it, in deviations.
    scores : Scores
        At the end.
    weights : (n,) array
        Of the errors.
    inner : (P,) array of bool
        Which parameters the scores are of: free ones that are at no bound.
    known : tuple of str
        Names of what was known of each record.
    alone : mapping of str to (float, float)
        What the records say, with deviations, of what was known before; empty where they do not
        show every parameter.
    moved : (P,) array or None
        What noise in the loop moved the parameters by, and was taken off.
    why_not_moved : str
        Why no twins tell that; empty where they do, or none were asked for.
    by_start : MovedByStart
    elsewhere : Elsewhere or None
        A place as good as the end that is claimed to be far from it.
    of_start : (P,) array of bool
        Which parameters are first positions and velocities of loops.
    rests_count : bool
        Whether samples near rests count, as without them a parameter is hardly shown.
    """

    axes: tuple[GeneratedAxis, ...]
    own: tuple[Array, ...]
    chains: tuple[Chain, ...]
    predictions: Predictions
    best: Found
    ends: tuple[Found, ...]
    influence: Array
    beyond: Mapping[str, float]
    scores: Scores
    weights: Array
    inner: NDArray[np.bool_]
    known: tuple[str, ...]
    alone: Mapping[str, tuple[float, float]]
    moved: Array | None
    why_not_moved: str
    by_start: MovedByStart
    elsewhere: Elsewhere | None
    of_start: NDArray[np.bool_]
    rests_count: bool

    @property
    def without_twins(self) -> "FitBasis":
        """Without what noise and steps make of the errors: many times what the record holds."""
        return replace(self, scores=replace(self.scores, twins=None))


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """What a fit is judged by."""

    outputs: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    physical: Array
    deviations: Array
    basis: FitBasis
    at_bound: Mapping[str, str]
    unseen: tuple[str, ...]
    law: LawCheck | Missing
    found_gains: tuple[str, ...]  # of the law
    law_moves: Mapping[str, Array]
    law_move: tuple[Array, Array] | Missing | None
    percents: tuple[float, ...]
    beyond_noise: tuple[float, ...]
    followed: tuple[str, ...]
    lacks: tuple[tuple[Lack, ...] | Missing, ...]  # by record
    prior: Mapping[str, tuple[float, float]]
    records: tuple[Record, ...]
    horizon: float | None
    searched: int  # parameters that are free
    levels: Levels

    @property
    def law_check(self) -> Check | Missing:
        """What the declared law is against the recorded control.

        What factors of the law tell counts once, by what they move the parameters by.
        """
        found = law_check(self.law)
        if isinstance(found, Check) and self.is_law_nearly_right:
            return replace(found, status="note")
        return found

    @property
    def is_law_wrong(self) -> bool:
        """Whether the recorded control is not the declared law's."""
        return isinstance(self.law, LawCheck) and not self.law.passed

    @property
    def is_law_nearly_right(self) -> bool:
        """Whether factors explain a control that is not the law's, and move nothing by much.

        Nor would the scale of the recorded control, from which the law does not tell factors.
        """
        law = self.law
        if not isinstance(law, LawCheck) or not isinstance(self.law_move, tuple):
            return False
        most = np.maximum(NOTICEABLE_BIAS.value * np.abs(self.physical), self.deviations)
        near = (np.abs(self.law_move[0]) <= most) | self.basis.of_start
        small = all(abs(each - 1) <= NOTICEABLE_BIAS.value for each in law.factors.values())
        return not law.passed and law.is_told_by_factors and small and bool(near.all())
