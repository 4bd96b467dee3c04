"""Several records of a document, read back."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.diagnostics import Apart
from axisid.estimation.identification import OfRecord
from axisid.estimation.joint import Layout, known_of, layout_of
from axisid.presentation.schema import WrittenApart
from axisid.support.arrays import Array, frozen
from axisid.support.missing import Missing


def read_apart(written: WrittenApart | None) -> Apart | Missing:
    """A record alone beside all of them; without the units, which the estimates have."""
    if written is None:
        return Missing("the record alone does not tell the parameters")
    return Apart(
        names=tuple(written.own),
        units=("",) * len(written.own),
        own=_values(written.own),
        common=_values(written.common),
        deviations=_values(written.deviations),
        statistic=written.statistic,
        freedom=written.freedom,
        p_value=written.p_value,
        share_percent=written.share_percent,
    )


def saved_layout(
    axis: GeneratedAxis,
    records: Sequence[OfRecord],
    local: Iterable[str],
    gain: float | None,
) -> Layout:
    """How the parameters of a file were shared by its records.

    Parameters
    ----------
    axis : GeneratedAxis
    records : sequence of OfRecord
    local : iterable of str
    gain : float or None
        The declared drive gain where it was identified.
    """
    names = [*records[0].known]
    told = {name: [of_one.known[name] for of_one in records] for name in names}
    known = known_of(told, len(records))
    return layout_of(axis, len(records), known, local, commanded=gain is not None)


def _values(written: Mapping[str, float]) -> Array:
    return frozen(np.array([*written.values()], dtype=float))
