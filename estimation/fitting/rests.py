"""Which samples a fit leaves out: near rests and reversals, as regressions leave out rows.

At rest friction takes any force, so that such samples tell nothing of the parameters; under a law
with an integral the control is undetermined there. Behind an encoder they mislead: it is silent at
rest, and record and loop come to rest and leave it at different times.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.identification import bound_records
from axisid.estimation.predictions import Predictions
from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.arrays import Array, covered
from axisid.support.errors import AxisidError


@dataclass(frozen=True, slots=True)
class Rests:
    """What is near a rest or a reversal of records, or of their simulated loops.

    Attributes
    ----------
    data : mapping of int to FilteredRecord
        By record, under the default filter, which says how near; none of records whose samples are
        all kept.
    """

    data: Mapping[int, FilteredRecord] = field(default_factory=dict)

    @classmethod
    def of(
        cls, axes: Sequence[GeneratedAxis], records: Sequence[Record], into: Sequence[Array]
    ) -> "Rests":
        """Those of records; none where these together show too little without them.

        Arguments as of `show_too_little`. Friction that remembers is shown near reversals alone,
        and records that are too short for the filter are kept whole.
        """
        served = list[int]()
        for i, (axis, record) in enumerate(zip(axes, records, strict=True)):
            if not axis.states:
                with suppress(AxisidError):
                    FilteredRecord.bind(axis, record, Prefilter(reversals="keep"))
                    served.append(i)
        if not served:
            return cls()
        own, of_all = [axes[i] for i in served], [into[i] for i in served]
        data = bound_records(own, [records[i] for i in served], Prefilter(), of_all)
        return cls(dict(zip(served, data, strict=True)))

    @property
    def count(self) -> bool:
        """Whether samples near rests count, as without them a parameter is hardly shown."""
        kept = [data for data in self.data.values() if not data.excluded]
        return any(data.rows_near_turns.any() for data in kept)

    def counted(self, predictions: Predictions, physical: Array | None = None) -> Array:
        """1 for rows that count, 0 near rests of the records, and of their loops there, (n,).

        Parameters
        ----------
        predictions : Predictions
        physical : (P,) array, optional
            Of the loops; without it rests are those of the records. A loop that never moves is none
            of a record that does.
        """
        counted = predictions.counted
        if not any(data.excluded for data in self.data.values()):
            return counted
        with np.errstate(all="ignore"):
            loops = () if physical is None else predictions.velocities(physical)
        near = np.concatenate(
            [
                self._near(r, samples, loops[r] if loops else None)
                for r, samples in enumerate(predictions.samples)
            ]
        )
        return np.where(np.repeat(near, len(predictions.units)), 0.0, counted)

    def _near(
        self, number: int, samples: NDArray[np.intp], loops: Array | None
    ) -> NDArray[np.bool_]:
        """Which samples are near a rest of a record, or of its loops by their velocity."""
        data = self.data.get(number)
        if data is None:
            return np.zeros(len(samples), dtype=bool)
        turns = data.excluded
        if turns and loops is not None:
            velocity = np.zeros(len(data))
            velocity[samples] = loops
            turns += data.sampling.turns(velocity, data.fastest)
        near = covered(turns, len(data))[samples]
        return covered(data.excluded, len(data))[samples] if near.all() else near
