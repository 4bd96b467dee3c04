"""An estimate of a log that was read in blocks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.diagnostics.estimates import bounds_note
from axisid.estimation.estimates import Iterate, NamedValues, Value, student_interval
from axisid.estimation.signals import Prefilter
from axisid.estimation.tables import Provenance
from axisid.support.arrays import Array, Exact
from axisid.support.presentable import Presentable
from axisid.support.remedy import Note


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class StreamedEstimate(Presentable, Exact):
    """An estimate of a log of any length.

    Attributes
    ----------
    axis : GeneratedAxis
    method : str
        ``idm-ls`` or ``idm-iv``.
    prefilter : Prefilter
    provenance : Provenance
    samples, rows : int
        Of the log, and of the regression.
    period : float
        s
    physical : (p,) array
    covariances : mapping of str to (p, p) array
        ``iid``, ``robust`` and ``hac``, as `Estimate` has them.
    lags : int
        Of the HAC covariance.
    freedom : (p,) array
        Its degrees of freedom.
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||``
    simulation_error_percent : float or None
        Of the force, by the loop that is simulated with the last iterate; None without instruments.
    iterates : tuple of Iterate
        The start of the instruments' iteration and every iterate.
    started : str
        Where it started, of `STARTS`; empty without instruments.
    remarks : tuple of Note
        On the iteration.
    condition_number : float
        Of the regressor.
    excluded_samples : int
        Samples near reversals that were left out.
    time_base : Note or None
        What speaks against the log's sampling period.
    """

    axis: GeneratedAxis
    method: str = "idm-ls"
    prefilter: Prefilter
    provenance: Provenance
    samples: int
    period: float
    rows: int
    physical: Array
    covariances: Mapping[str, Array]
    lags: int
    freedom: Array
    equation_error_percent: float
    condition_number: float
    excluded_samples: int
    simulation_error_percent: float | None = None
    iterates: tuple[Iterate, ...] = ()
    started: str = ""
    remarks: tuple[Note, ...] = ()
    time_base: Note | None = None

    def __getitem__(self, name: str) -> Value:
        """One of `parameters`."""
        return self.parameters[name]

    @property
    def parameters(self) -> NamedValues:
        """Parameters by name; intervals are HAC."""
        sds = {name: np.sqrt(np.diag(c)) for name, c in self.covariances.items()}
        values = (
            Value(
                value=float(self.physical[i]),
                unit=q.unit,
                deviations={name: float(sd[i]) for name, sd in sds.items()},
                interval=student_interval(
                    float(self.physical[i]), float(sds["hac"][i]), float(self.freedom[i])
                ),
            )
            for i, q in enumerate(self.axis.parameters)
        )
        return NamedValues(zip(self.axis.names, values, strict=True))

    @property
    def beyond_bounds(self) -> Note | None:
        """Which parameters are outside their declared bounds; None for none."""
        declared = zip(self.axis.axis.parameters, self.physical, strict=True)
        outside = {p: float(v) for p, v in declared if not p.is_inside(float(v))}
        return bounds_note(outside) if outside else None

    def __repr__(self) -> str:
        return f"{self.method} in blocks: {self.parameters.listed()}"
