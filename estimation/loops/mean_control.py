"""What a drive does between the samples of a log that is slower than its law.

The log shows the control at its samples alone. Its mean until the next is what moves the axis: of a
reference that is held from sample to sample the control is a sawtooth, of which the log sees one
edge. The law itself, run along the recorded reference and position, tells the one from the other.
"""

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.support.arrays import Array

from .clocks import two_clocks
from .law_run import control_at_ticks
from .law_ticks import law_ticks
from .start_memory import start_of_law


def mean_until_next(axis: GeneratedAxis, record: Record) -> Array | None:
    """By how much the mean of the control until the next sample is more than that at each, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record

    Returns
    -------
    (N,) array or None
        None where the law is evaluated at the samples or seldomer, where the reference is not held
        between them, so that the control is no sawtooth, or where the law cannot be run.
    """
    law = axis.axis.control
    if law is None or record.reference is None or record.control is None:
        return None
    pieces = [_of_segment(axis, record, span) for span in record.spans]
    controls = [piece for piece in pieces if piece is not None]
    return np.concatenate(controls) if len(controls) == len(pieces) else None


def _of_segment(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> Array | None:
    clocks = two_clocks(axis, record, span)
    if clocks is None or clocks.between != "held" or clocks.law_period > clocks.log_period:
        return None
    ticks = law_ticks(axis, record, span)
    control = control_at_ticks(axis, ticks, start_of_law(axis, record, span, ticks))
    # Each is held until the next evaluation; the last beyond the last sample.
    edges = np.append(clocks.times, clocks.times[-1] + clocks.law_period / clocks.log_period)
    until = np.concatenate([[0.0], np.cumsum(control * np.diff(edges))])
    samples = np.arange(clocks.samples + 1)
    mean = np.diff(np.interp(samples, edges, until))
    mean[-1] = control[ticks.held[-1]]  # it goes on beyond the record
    change = mean - control[ticks.held]
    return np.where(np.isfinite(change), change, 0.0)
