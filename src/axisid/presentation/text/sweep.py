"""Estimates over the cut-off as text."""

from collections.abc import Sequence

from axisid.estimation.diagnostics import check_law
from axisid.estimation.estimates import METHODS
from axisid.estimation.identification import Identification
from axisid.estimation.studies import Sweep
from axisid.modeling.declaration import left_out_text

from .record import record_lines
from .tables import heading_text, text_table


def sweep_text(sweep: Sweep) -> str:
    """Values by cut-off and method as text, and the recommendation."""
    methods = [m for m in METHODS if any(m in r.estimates for r in sweep.results)]
    if "idm-iv" in methods:
        methods = [m for m in methods if m != "ddm-iv"]  # the same estimate
    first = sweep.results[0]
    heading = record_lines(first.record)
    told = heading_text(
        {
            "left out": left_out_text(first.axis.declared),
            **{name: heading[name] for name in ("assumed", "repaired")},
        }
    )
    blocks = [told] if told else []
    for quantity in first.axis.parameters:
        header = ["cut-off [Hz]", "1 of"]
        for method in methods:
            header += [f"{method.upper()} {quantity.name} [{quantity.unit}]", "sd"]
        blocks.append(text_table(header, [_row(r, quantity.name, methods) for r in sweep.results]))
    lines = ["Values are without the filter's own bias, where that is known."]
    lines += [f"{cutoff:g} Hz gave no estimate: {why}" for cutoff, why in sweep.failures.items()]
    law = check_law(first.axis, first.record)
    if not isinstance(law, str) and not law.passed:
        lines.append(f"believe nothing before this is mended: {law.meaning}.")
    lines.append(f"recommended: {sweep.recommended:g} Hz, {sweep.reason}.")
    return "\n\n".join([*blocks, "\n".join(lines)]) + "\n"


def _row(result: Identification, name: str, methods: Sequence[str]) -> list[str]:
    row = [f"{result.prefilter.cutoff:g}", str(result.prefilter.decimate)]
    for method in methods:
        estimate = result.estimates.get(method)
        value = estimate and estimate.parameters[name]
        row += [f"{value.corrected:.5g}", f"{value.deviation:.2g}"] if value else ["-", "-"]
    return row
