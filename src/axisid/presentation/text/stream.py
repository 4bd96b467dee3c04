"""What comes of a log that was read in blocks, as text."""

from axisid.estimation.studies import StreamedEstimate
from axisid.modeling.declaration import left_out_text

from .identification import failed
from .quantity import number_with_sd
from .tables import heading_text, numbered, text_table


def stream_text(estimate: StreamedEstimate) -> str:
    """The estimate as text, with notes."""
    source, f, declared = estimate.provenance, estimate.prefilter, estimate.axis.axis
    heading = heading_text(
        {
            "axis": declared.name + (f": {declared.title}" if declared.title else ""),
            "left out": left_out_text(estimate.axis.declared),
            "record": f"{source.source}, {estimate.samples} samples of "
            f"{1e3 * estimate.period:.6g} ms, read in blocks",
            "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
            "assumed": "; ".join(source.assumed),
        }
    )
    rows = [[n, v.unit, *number_with_sd(v)] for n, v in estimate.parameters.items()]
    rows.append(["equation error", "%", f"{estimate.equation_error_percent:.4f}", "", "", ""])
    rows.append(["condition number", "", f"{estimate.condition_number:.3f}", "", "", ""])
    table = text_table(["", "unit", "IDM-LS", "sd [1]", "rel. sd", "i.i.d. [2]"], rows)
    start, end = f.dropped(estimate.period)
    quiet = f"are left out, {estimate.silenced} samples"
    if f.reversals == "keep":
        biased = (
            ", where the low-pass rounds friction and biases it"
            if estimate.axis.has_direction
            else ""
        )
        quiet = f"are kept{biased}"
    notes = (
        f"HAC, Bartlett kernel, {estimate.lags} lags (plug-in rule), times n/(n - k).",
        f"i.i.d., residual variance with n - 1 = {estimate.rows - 1}.",
        f"{estimate.rows} rows: {start} samples dropped at the start, {end} at the end, one in "
        f"{f.decimate} kept; Butterworth {f.cutoff:g} Hz, order {f.order}; hold {f.hold}. "
        f"Reversals {quiet}.",
        "Not checked: instruments, control law, timing and residuals need the whole log in "
        "memory, as a piece of it is. Identify such a piece without --stream too.",
    )
    faults = {"control law": estimate.time_base, "bounds": estimate.beyond_bounds}
    verdict = "".join(f"{failed(name, why)}\n\n" for name, why in faults.items() if why)
    listed = "\n".join(numbered(i, note) for i, note in enumerate(notes, 1))
    return f"{heading}\n\n{table}\n\n{verdict}{listed}\n"
