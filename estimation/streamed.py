"""What comes of a log that was read in blocks."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from axisid.codegen import GeneratedAxis
from axisid.modeling import left_out_text

from .arrays import Array, finite
from .motion_checks import beyond_bounds, is_outside
from .prefilter import Prefilter
from .provenance import Provenance
from .serialised import left_out_dict, origin_dict, prefilter_dict, value_dict
from .summary import failed, heading_text, number_with_sd, numbered, text_table
from .value import Named, Value, student_interval

#: Name and version of what `StreamedEstimate.to_dict` gives.
STREAM_SCHEMA = "axisid.stream/1"


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class StreamedEstimate:
    """IDM-LS of a log of any length.

    Attributes
    ----------
    axis : GeneratedAxis
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
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||``
    condition_number : float
        Of the regressor.
    silenced : int
        Samples near reversals that were left out.
    time_base : str
        What speaks against the log's sampling period; empty where nothing does.
    """

    axis: GeneratedAxis
    prefilter: Prefilter
    provenance: Provenance
    samples: int
    period: float
    rows: int
    physical: Array
    covariances: Mapping[str, Array]
    lags: int
    equation_error_percent: float
    condition_number: float
    silenced: int
    time_base: str = ""

    @property
    def parameters(self) -> Named:
        """Parameters by name; intervals are HAC."""
        sds = {name: np.sqrt(np.diag(c)) for name, c in self.covariances.items()}
        dof = self.rows - len(self.physical)
        values = (
            Value(
                value=float(self.physical[i]),
                unit=q.unit,
                sd=float(sds["iid"][i]),
                sd_robust=float(sds["robust"][i]),
                sd_hac=float(sds["hac"][i]),
                interval=student_interval(float(self.physical[i]), float(sds["hac"][i]), dof),
            )
            for i, q in enumerate(self.axis.parameters)
        )
        return Named(zip(self.axis.names, values, strict=True))

    @property
    def beyond_bounds(self) -> str:
        """Which parameters are outside their declared bounds; empty for none."""
        declared = zip(self.axis.axis.parameters, self.physical, strict=True)
        outside = {p: float(v) for p, v in declared if is_outside(p, float(v))}
        return beyond_bounds(outside) if outside else ""

    def __repr__(self) -> str:
        values = (
            f"{n} = {v.value:.6g} +- {v.sd_hac:.2g} {v.unit}" for n, v in self.parameters.items()
        )
        return f"idm-ls in blocks: {', '.join(values)}"

    def __str__(self) -> str:
        return self.summary()

    def summary(self) -> str:
        """The estimate as text, with notes."""
        source, f, declared = self.provenance, self.prefilter, self.axis.axis
        heading = heading_text(
            {
                "axis": declared.name + (f": {declared.title}" if declared.title else ""),
                "left out": left_out_text(self.axis.declared),
                "record": f"{source.source}, {self.samples} samples of {1e3 * self.period:.6g} ms, "
                "read in blocks",
                "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
                "assumed": "; ".join(source.assumed),
            }
        )
        rows = [[n, v.unit, *number_with_sd(v)] for n, v in self.parameters.items()]
        rows.append(["equation error", "%", f"{self.equation_error_percent:.4f}", "", "", ""])
        rows.append(["condition number", "", f"{self.condition_number:.3f}", "", "", ""])
        table = text_table(["", "unit", "IDM-LS", "sd [1]", "rel. sd", "i.i.d. [2]"], rows)
        start, end = f.dropped(self.period)
        quiet = f"are left out, {self.silenced} samples"
        if f.reversals == "keep":
            biased = (
                ", where the low-pass rounds friction and biases it"
                if self.axis.has_direction
                else ""
            )
            quiet = f"are kept{biased}"
        notes = (
            f"HAC, Bartlett kernel, {self.lags} lags (plug-in rule), times n/(n - k).",
            f"i.i.d., residual variance with n - 1 = {self.rows - 1}.",
            f"{self.rows} rows: {start} samples dropped at the start, {end} at the end, one in "
            f"{f.decimate} kept; Butterworth {f.cutoff:g} Hz, order {f.order}; hold {f.hold}. "
            f"Reversals {quiet}.",
            "Not checked: instruments, control law, timing and residuals need the whole log in "
            "memory, as a piece of it is. Identify such a piece without --stream too.",
        )
        faults = {"control law": self.time_base, "bounds": self.beyond_bounds}
        verdict = "".join(f"{failed(name, why)}\n\n" for name, why in faults.items() if why)
        listed = "\n".join(numbered(i, note) for i, note in enumerate(notes, 1))
        return f"{heading}\n\n{table}\n\n{verdict}{listed}\n"

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes."""
        return {
            "schema": STREAM_SCHEMA,
            "axis": self.axis.axis.name,
            "signature": self.axis.signature,
            "left_out": left_out_dict(self.axis),
            "record": {
                **origin_dict(self.provenance),
                "assumed": list(self.provenance.assumed),
                "samples": self.samples,
                "sample_period": self.period,
            },
            "prefilter": prefilter_dict(self.prefilter, self.period),
            "parameters": {name: value_dict(v) for name, v in self.parameters.items()},
            "beyond_bounds": self.beyond_bounds or None,
            "time_base": self.time_base or None,
            "rows": self.rows,
            "lags": self.lags,
            "equation_error_percent": self.equation_error_percent,
            "condition_number": finite(self.condition_number),
        }
