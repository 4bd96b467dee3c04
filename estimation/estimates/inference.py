"""How far an estimate may be from the truth, and what moves it."""

from collections.abc import Mapping
from dataclasses import dataclass

from axisid.estimation.problems import NoiseFree
from axisid.estimation.twins import Chain
from axisid.support.arrays import Array, Exact


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inference(Exact):
    """What takes further simulated loops to know of an estimate, so that it waits to be asked for.

    Attributes
    ----------
    covariances : dict of str to (p, p) array
        Of the physical parameters, by name: ``iid``, ``robust`` and ``hac``; by the delta method
        for a direct model. ``hac`` as twins scatter, where there are any.
    covariance_names : dict of str to str
        What each covariance is, with lags and corrections, for the notes of a table.
    ddm_covariances : dict of str to (m, m) array
        Of a direct model's own parameters; empty for an inverse model.
    gain_slopes : (p,) array or None
        Of the physical parameters by the logarithm of the gain; None where it is exact.
    theta_gain_slopes : (k,) array or None
        The same of the regression's own parameters.
    noise_free : NoiseFree or None
        The rows of the loops simulated with the estimate, behind the same filter: from the records'
        references, or following them where they have none. None where they could not be simulated,
        or move otherwise than the records.
    bias : (p,) array or None
        What filter and noise move the physical parameters by, as twins tell; None without twins.
    chains : tuple of Chain
        The noise of each record, as its twins have it; none without twins.
    """

    covariances: Mapping[str, Array]
    covariance_names: Mapping[str, str]
    ddm_covariances: Mapping[str, Array]
    gain_slopes: Array | None = None
    theta_gain_slopes: Array | None = None
    noise_free: NoiseFree | None = None
    bias: Array | None = None
    chains: tuple[Chain, ...] = ()
