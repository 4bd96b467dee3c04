"""Which parameters of a record differ from those of the others, and what they are in each.

Two sets of records are independent, so that where one parameter differs, the others' difference is
chance: parameters are named, the one that explains most first, until chance explains what is left
of the difference, or it makes no force to speak of.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.regression import joint_p
from axisid.estimation.thresholds import MAX_RECORD_CHANCE, MIN_RECORD_SHARE
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.remedy import Remedy, Setting

_LOAD_UNITS = ("kg", "kg m^2", "kg*m^2")


@dataclass(frozen=True, slots=True, kw_only=True)
class Differing:
    """Parameters that differ, length d.

    Attributes
    ----------
    names, units : tuple of str
    own, others : (d,) array
        As a record alone has them, and as the others have them without it.
    deviations, others_deviations : (d,) array
        HAC.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    own: Array
    others: Array
    deviations: Array
    others_deviations: Array

    def told(self, whose: str, rest: str) -> str:
        """What each is in the record and in the others."""
        pairs = zip(self.own, self.deviations, strict=True)
        rests = zip(self.others, self.others_deviations, strict=True)
        each = [
            f"{name} is {value:.4g} +- {sd:.1g} {unit} in {whose} and {other:.4g} +- {other_sd:.1g}"
            for name, unit, (value, sd), (other, other_sd) in zip(
                self.names, self.units, pairs, rests, strict=True
            )
        ]
        first = [f"{each[0]} in {rest}", *each[1:]]
        load = any(unit in _LOAD_UNITS for unit in self.units)
        return ", ".join(first) + ", as under another load" * load

    @property
    def remedy(self) -> Remedy:
        """What declares such a difference."""
        listed = ",".join(self.names)
        return Remedy.of(
            "say what is known to differ, as a payload that the axis declares (",
            Setting("known", "NAME=V1,V2"),
            "), or let each record have its own (",
            Setting("local", listed),
            ")",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A record's parameters, length p, beside those of other records that it is not among.

    Attributes
    ----------
    names, units : tuple of str
    own, others : (p,) array
    covariance, others_covariance : (p, p) array
        HAC; the two are independent.
    freedom : float
        Of their sum.
    regressor : (n, p) array
        Of the record.
    force : (n,) array
        Likewise.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    own: Array
    others: Array
    covariance: Array
    others_covariance: Array
    freedom: float
    regressor: Array
    force: Array

    def explained(self) -> Differing | None:
        """The fewest parameters that explain it; None where chance does, or it is too small."""
        left, chosen = [*range(len(self.names))], list[int]()
        while left and self._matters(left):
            best = min(left, key=lambda j: self._square([i for i in left if i != j]))
            left.remove(best)
            chosen.append(best)
        if not chosen:
            return None
        own, others = (
            np.sqrt(np.maximum(np.diag(each)[chosen], 0.0))
            for each in (self.covariance, self.others_covariance)
        )
        return Differing(
            names=tuple(self.names[j] for j in chosen),
            units=tuple(self.units[j] for j in chosen),
            own=self.own[chosen],
            others=self.others[chosen],
            deviations=own,
            others_deviations=others,
        )

    def _matters(self, left: list[int]) -> bool:
        """Whether parameters that are taken to be alike differ beyond chance, in force too."""
        change = self.regressor[:, left] @ (self.own - self.others)[left]
        if relative_error_percent(change, self.force) <= MIN_RECORD_SHARE.value:
            return False
        p_value = joint_p(self._square(left), len(left), self.freedom)
        return bool(p_value < MAX_RECORD_CHANCE.value)

    def _square(self, left: list[int]) -> float:
        """``d' V^-1 d`` of some parameters, whatever the others are."""
        if not left:
            return 0.0
        covariance = (self.covariance + self.others_covariance)[np.ix_(left, left)]
        scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
        apart = (self.own - self.others)[left] / scale
        return float(apart @ np.linalg.lstsq(covariance / np.outer(scale, scale), apart)[0])
