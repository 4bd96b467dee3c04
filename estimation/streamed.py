"""What comes of a log that was read in blocks."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from axisid.codegen import GeneratedAxis

from .arrays import Array, finite
from .prefilter import Prefilter
from .provenance import Provenance
from .serialised import prefilter_dict
from .summary import heading_text, text_table

#: Name and version of what `StreamedEstimate.to_dict` gives.
STREAM_SCHEMA = "axisid.stream/1"


@dataclass(frozen=True, slots=True, kw_only=True)
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
    covariance, covariance_hac : (p, p) array
        For independent residuals, and for autocorrelated ones.
    lags : int
        Of the HAC covariance.
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||``
    condition_number : float
        Of the regressor.
    """

    axis: GeneratedAxis
    prefilter: Prefilter
    provenance: Provenance
    samples: int
    period: float
    rows: int
    physical: Array
    covariance: Array
    covariance_hac: Array
    lags: int
    equation_error_percent: float
    condition_number: float

    def __str__(self) -> str:
        return self.summary()

    def summary(self) -> str:
        """The estimate as text, with notes."""
        source, f = self.provenance, self.prefilter
        heading = heading_text(
            {
                "axis": self.axis.axis.name,
                "record": f"{source.source}, {self.samples} samples of {1e3 * self.period:.6g} ms, "
                "read in blocks",
                "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
                "assumed": "; ".join(source.assumed),
            }
        )
        sd, iid = (np.sqrt(np.diag(c)) for c in (self.covariance_hac, self.covariance))
        cells = zip(self.axis.parameters, self.physical, sd, iid, strict=True)
        rows = [[q.name, q.unit, f"{v:.6g}", f"{s:.3g}", f"{i:.3g}"] for q, v, s, i in cells]
        rows.append(["equation error", "%", f"{self.equation_error_percent:.4f}", "", ""])
        rows.append(["condition number", "", f"{self.condition_number:.3f}", "", ""])
        start, end = f.dropped(self.period)
        notes = (
            f"[1] HAC, Bartlett kernel, {self.lags} lags (plug-in rule), times n/(n - k)\n"
            f"[2] i.i.d., residual variance with n - 1 = {self.rows - 1}\n"
            f"[3] {self.rows} rows: {start} samples dropped at the start, {end} at the end, one in "
            f"{f.decimate} kept; Butterworth {f.cutoff:g} Hz, order {f.order}; hold {f.hold}.\n"
            "    Reversals are kept. Instruments and the verdict need the whole log in memory."
        )
        table = text_table(["", "unit", "IDM-LS", "sd [1]", "i.i.d. [2]"], rows)
        return f"{heading}\n\n{table}\n\n{notes}\n"

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes."""
        sd, iid = (np.sqrt(np.diag(c)) for c in (self.covariance_hac, self.covariance))
        cells = zip(self.axis.parameters, self.physical, iid, sd, strict=True)
        return {
            "schema": STREAM_SCHEMA,
            "axis": self.axis.axis.name,
            "signature": self.axis.signature,
            "record": {
                "source": self.provenance.source,
                "sha256": self.provenance.sha256 or None,
                "columns": dict(self.provenance.columns),
                "assumed": list(self.provenance.assumed),
                "samples": self.samples,
                "sample_period": self.period,
            },
            "prefilter": prefilter_dict(self.prefilter, self.period),
            "parameters": {
                q.name: {"value": float(v), "unit": q.unit, "sd": float(i), "sd_hac": float(s)}
                for q, v, i, s in cells
            },
            "rows": self.rows,
            "lags": self.lags,
            "equation_error_percent": self.equation_error_percent,
            "condition_number": finite(self.condition_number),
        }
