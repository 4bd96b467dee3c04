"""What comes of a log that was read in blocks, as a document."""

from axisid.estimation.signals import SampledFilter
from axisid.estimation.streaming import StreamedEstimate
from axisid.modeling.declaration import left_out_text
from axisid.presentation.blocks import (
    Cell,
    CheckGroup,
    Checks,
    Column,
    Document,
    Heading,
    Notes,
    Table,
    text_columns,
)
from axisid.support.remedy import Remedy, Setting, Wording, as_arguments

from .estimate import iterations, quantity
from .identification import PARTS

_UNCHECKED = (
    "Not checked: {}control law, timing and residuals need the whole log in memory, as a piece of "
    "it is."
)
_PIECE = Remedy.of("For such a piece, ", Setting("stream", given=False), " too.")


def stream_document(estimate: StreamedEstimate, *, wording: Wording = as_arguments) -> Document:
    """Heading, estimates, faults if there are any, and notes."""
    faults = {"control law": estimate.time_base, "bounds": estimate.beyond_bounds}
    return (
        _heading(estimate, wording),
        _table(estimate),
        *(
            Checks(judged=(CheckGroup("fail", (name,), why.worded(wording)),))
            for name, why in faults.items()
            if why is not None
        ),
        Notes((*_notes(estimate, wording), f"{_unchecked(estimate)} {_PIECE.worded(wording)}")),
    )


def _unchecked(estimate: StreamedEstimate) -> str:
    return _UNCHECKED.format("" if estimate.iterates else "instruments, ")


def _heading(estimate: StreamedEstimate, wording: Wording) -> Heading:
    source, declared = estimate.provenance, estimate.axis.axis
    facts = {
        "axis": declared.name + (f": {declared.title}" if declared.title else ""),
        "left out": left_out_text(estimate.axis.declared),
        "record": f"{source.source}, {estimate.samples} samples of "
        f"{1e3 * estimate.period:.6g} ms, read in blocks",
        "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
        "assumed": "; ".join((*source.assumed, *(d.worded(wording) for d in source.doubts))),
    }
    return Heading(facts=tuple(facts.items()))


def _table(estimate: StreamedEstimate) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (name, value.unit, quantity(value)) for name, value in estimate.parameters.items()
    ]
    rows.append(("equation error", "%", f"{estimate.equation_error_percent:.4f}"))
    if estimate.simulation_error_percent is not None:
        rows.append(("simulation error", "%", f"{estimate.simulation_error_percent:.4f}"))
        rows.append(("iterations", "", iterations(estimate)))
    rows.append(("condition number", "", f"{estimate.condition_number:.3f}"))
    columns = (*text_columns(["", "unit"]), Column(estimate.method.upper(), parts=PARTS))
    return Table(columns=columns, rows=tuple(rows), labels=2)


def _notes(estimate: StreamedEstimate, wording: Wording) -> tuple[str, ...]:
    f = estimate.prefilter
    start, end = SampledFilter(f, estimate.period).dropped
    quiet = f"are left out, {estimate.excluded_samples} samples"
    if f.reversals == "keep":
        biased = (
            ", where the low-pass rounds friction and biases it"
            if estimate.axis.has_direction
            else ""
        )
        quiet = f"are kept{biased}"
    return (
        f"HAC, scores prewhitened by AR(1), Bartlett kernel, {estimate.lags} lags (plug-in rule), "
        "times n/(n - k).",
        f"i.i.d., residual variance with n - 1 = {estimate.rows - 1}.",
        f"{estimate.rows} rows: {start} samples dropped at the start, {end} at the end, one in "
        f"{f.decimate} kept; Butterworth {f.cutoff:g} Hz, order {f.order}; hold {f.hold}. "
        f"Reversals {quiet}.",
        *(f"{remark.worded(wording)}." for remark in estimate.remarks),
    )
