"""Which samples a fit leaves out: near rests and reversals, as regressions leave out rows.

At rest friction takes any force, so that such samples tell nothing of the parameters; under a law
with an integral the control is undetermined there. Behind an encoder they mislead: it is silent at
rest, and record and loop come to rest and leave it at different times.
"""

from collections.abc import Sequence
from dataclasses import dataclass

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
    data : tuple of FilteredRecord
        Under the default filter, which says how near; none where all samples are kept.
    """

    data: tuple[FilteredRecord, ...] = ()

    @classmethod
    def of(cls, axes: Sequence[GeneratedAxis], records: Sequence[Record]) -> "Rests":
        """Those of records; of one that shows too little without them none.

        Friction that remembers is shown near reversals alone, and records that are too short for
        the filter are kept whole.
        """
        if any(axis.states for axis in axes):
            return cls()
        try:
            return cls(bound_records(axes, records, Prefilter()))
        except AxisidError:
            return cls()

    @property
    def count(self) -> bool:
        """Whether samples near rests count, as without them a parameter is hardly shown."""
        return any(not data.excluded and data.rows_near_turns.any() for data in self.data)

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
        if not any(data.excluded for data in self.data):
            return counted
        with np.errstate(all="ignore"):
            motions = () if physical is None else predictions.motions(physical) or ()
        near = np.concatenate(
            [
                self._near(data, samples, [m.velocity for m in motions if m.record == r])
                for r, (data, samples) in enumerate(
                    zip(self.data, predictions.samples, strict=True)
                )
            ]
        )
        return np.where(np.repeat(near, len(predictions.units)), 0.0, counted)

    @staticmethod
    def _near(
        data: FilteredRecord, samples: NDArray[np.intp], loops: Sequence[Array]
    ) -> NDArray[np.bool_]:
        """Which samples are near a rest of a record, or of its loops by their velocities."""
        turns = data.excluded
        if turns and loops:
            velocity = np.zeros(len(data))
            velocity[samples] = np.concatenate(loops)
            turns += data.sampling.turns(velocity, data.fastest)
        near = covered(turns, len(data))[samples]
        return covered(data.excluded, len(data))[samples] if near.all() else near
