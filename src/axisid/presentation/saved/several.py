"""Several records of a document, read back."""

from collections.abc import Mapping

import numpy as np

from axisid.estimation.diagnostics import Apart
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


def _values(written: Mapping[str, float]) -> Array:
    return frozen(np.array([*written.values()], dtype=float))
