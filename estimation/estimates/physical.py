"""Physical parameters from base parameters and from what is known apart from the record.

Classical minimum distance: with ``z = (beta_hat, fixed values)`` and its covariance V, the
parameters minimise ``(z - h)' V^-1 (z - h)`` with ``h(theta) = (beta(theta), theta_fixed)``. What
is fixed exactly is no unknown. Where z has more members than there are unknowns, the minimum tells
whether what was fixed contradicts the record: Hotelling's T squared, of the degrees of freedom of
V. For that beta_hat must be where the truth is expected and V say how far: its bias is taken off,
and what the drive gain's deviation adds is in V.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from axisid.codegen.artefacts import Quantity
from axisid.estimation.parameters import JointForm
from axisid.estimation.regression import Form, delta_method, joint_p
from axisid.modeling.derivation import BaseModel
from axisid.modeling.wording import describe_undetermined, undetermined_names
from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError
from axisid.support.user_values import is_among, quoted

from .base_distance import Distance
from .value import Distribution, NamedValues

# deviations^2 from the estimate, up to which physical parameters reproduce it
_MAX_EXACT_DISTANCE = 1e-6
# smallest singular value of the scaled map to base parameters, by the largest; below, physical
# ones do not follow
_MIN_SENSITIVITY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Physical(Exact):
    """Physical parameters of one estimate.

    Attributes
    ----------
    method : str
        Of the estimate.
    base : BaseModel
    parameters : NamedValues
        The declared parameters that follow, by name.
    covariances : mapping of str to array
        Of these, in their order: ``iid``, ``robust`` and ``hac``.
    undetermined : tuple of str
        In words, which parameters do not follow and what would have to be known.
    statistic, dof, p_value : float, int, float or None
        The minimum distance, Hotelling's T squared with `dof` restrictions, and how likely a larger
        one is; None where nothing contradicts whatever is fixed.
    remarks : tuple of str
        Other values that fit as well, bounds that are violated.
    """

    method: str
    base: BaseModel
    parameters: NamedValues
    covariances: Mapping[str, Array]
    undetermined: tuple[str, ...]
    statistic: float
    dof: int
    p_value: float | None
    remarks: tuple[str, ...]

    @property
    def shows_more(self) -> bool:
        """Whether it says anything that the base parameters do not."""
        own = {p.name for p in self.base.axis.parameters}
        return bool(self.parameters) and bool(self.base.known or set(self.parameters) - own)


P = TypeVar("P")


class PhysicalByMethod(dict[str, P]):
    """Physical parameters by method; one that is not among them is told with those that are."""

    def __getitem__(self, method: str) -> P:
        name = method.lower() if isinstance(method, str) else method
        if is_among(name, self):
            return super().__getitem__(name)
        if not self:
            raise UsageError(
                f"there is no {quoted(method)} among the physical parameters, as the estimates are "
                "of the declared ones already; take result[METHOD].parameters.",
                code="no-physical",
            )
        raise UsageError(
            f"physical parameters are by method, and there is no {quoted(method)}; choose from "
            f"{', '.join(self)}, and of its parameters by name.",
            code="no-such-physical",
        )


def physical_parameters(method: str, form: Form, of_base: Distribution) -> Physical | None:
    """Physical parameters from an estimate and what its axis declares as known.

    Parameters
    ----------
    method : str
        That it was estimated by.
    form : Form
        Of the axis that the parameters are of.
    of_base : Distribution
        Of the base parameters.

    Returns
    -------
    Physical or None
        None where the estimate is of the physical parameters already and none is known, and of
        records that have parameters for themselves, of which each has its own.

    References
    ----------
    [NeweyMcFadden1994]_.
    """
    base = form.axis.base
    if isinstance(form, JointForm) or not (base.changed or base.known):
        return None
    # About the truth, base parameters scatter by noise and by the drive gain.
    expected, by_gain = of_base.covariances[of_base.chosen], of_base.by_gain
    if by_gain is not None:
        expected = expected + np.outer(by_gain, by_gain)
    distance = Distance(base, of_base.corrected, expected)
    found = distance.minimum()
    lost = undetermined_names(base)
    rank = len(distance.free) - len(base.undetermined)
    dof = len(distance.target) - rank
    reason = _no_solution(found.cost, dof, distance, found.theta, rank)
    if reason:
        return Physical(
            method=method,
            base=base,
            parameters=NamedValues(),
            covariances={name: np.zeros((0, 0)) for name in of_base.covariances},
            undetermined=(*describe_undetermined(base), reason),
            statistic=0.0,
            dof=0,
            p_value=None,
            remarks=(),
        )
    declared = base.declared.parameters
    freedom = float(np.min(of_base.freedom[of_base.chosen]))
    kept = [j for j, p in enumerate(declared) if p.name not in lost]
    influence = distance.influence(found.theta, rank)[kept]
    made = Distribution(
        quantities=tuple(Quantity(name=declared[j].name, unit=declared[j].unit) for j in kept),
        theta=found.theta[kept],
        covariances={
            name: delta_method(distance.covariance(c), influence)
            for name, c in of_base.covariances.items()
        },
        freedom={name: np.full(len(kept), np.min(each)) for name, each in of_base.freedom.items()},
        chosen=of_base.chosen,
        by_gain=None if by_gain is None else influence[:, : len(by_gain)] @ by_gain,
    )
    return Physical(
        method=method,
        base=base,
        parameters=made.values,
        covariances=made.covariances,
        undetermined=describe_undetermined(base),
        statistic=found.cost if dof else 0.0,
        dof=dof,
        p_value=joint_p(found.cost, dof, freedom) if dof else None,
        remarks=(
            *_others(distance, found.theta, kept),
            *(
                declared[j].out_of_bounds(found.theta[j])
                for j in kept
                if not declared[j].allows(found.theta[j]) and declared[j].known is None
            ),
        ),
    )


def _no_solution(cost: float, dof: int, distance: Distance, theta: Array, rank: int) -> str:
    """Why there are no physical parameters; empty if there are."""
    if not np.isfinite(cost) or (dof == 0 and cost > _MAX_EXACT_DISTANCE):
        return (
            "no values of the physical parameters give the base parameters as they are estimated: "
            "check the equation of motion and what was fixed, or start from better nominal values"
        )
    if distance.sharpness(theta, rank) < _MIN_SENSITIVITY:
        return (
            "at this estimate the base parameters hardly change with the physical ones, which "
            "therefore do not follow: fix others"
        )
    return ""


def _others(distance: Distance, theta: Array, kept: list[int]) -> list[str]:
    """Other physical parameters within their bounds that fit as well."""
    names = [p.name for p in distance.base.declared.parameters]
    remarks = []
    for other in distance.others(theta):
        alike = distance.alike(theta, other)
        moved = [j for j in kept if not alike[j]]
        if moved:
            values = ", ".join(f"{names[j]} = {other[j]:.4g}" for j in moved)
            remarks.append(
                f"{values} would fit as well; what is given is nearer the nominal values, bounds "
                "tell the two apart"
            )
    return remarks
