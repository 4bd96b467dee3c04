"""One of several records of a file: its axis, and the parameters that it has of those of all."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.estimates import NamedValues, value_with_interval
from axisid.estimation.identification import OfRecord, RecordInfo
from axisid.estimation.parameters import JointForm, Layout
from axisid.estimation.regression import InverseForm, delta_method
from axisid.estimation.signals import Prefilter
from axisid.support.arrays import Array

from .estimate import SavedEstimate


@dataclass(frozen=True, kw_only=True)
class PartEstimate:
    """An estimate of several records in the parameters of the axis that one of them has.

    With the drive gain among the parameters of all, those of the record are of the declared gain,
    as in the part of a live result.

    Attributes
    ----------
    whole : SavedEstimate
    joint : JointForm
    place : int
        Of the record, from 0.
    """

    whole: SavedEstimate
    joint: JointForm
    place: int

    @property
    def form(self) -> InverseForm:
        """Of the record's axis."""
        return InverseForm(self.joint.layout.members[self.place].axis)

    @property
    def method(self) -> str:
        """See `SavedEstimate`."""
        return self.whole.method

    @property
    def chosen(self) -> str:
        """See `SavedEstimate`."""
        return self.whole.chosen

    @property
    def equation_error_percent(self) -> float:
        """Of all records."""
        return self.whole.equation_error_percent

    @property
    def simulation_error_percent(self) -> float | None:
        """Of all records."""
        return self.whole.simulation_error_percent

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Those of the record's axis, length p."""
        return self.form.axis.parameters

    @property
    def physical(self) -> Array:
        """Parameters of the record's axis, (p,)."""
        return self.joint.own(self.whole.physical, self.place)

    @cached_property
    def _slopes(self) -> Array:
        """Of these by the parameters of all, (p, P)."""
        jacobian = self.joint.physical(self.joint.regressed(self.whole.physical))[1]
        return np.asarray(self.joint.slopes(self.place) @ np.linalg.inv(jacobian))

    @property
    def covariances(self) -> Mapping[str, Array]:
        """Of `physical`, (p, p), by name."""
        return {name: delta_method(c, self._slopes) for name, c in self.whole.covariances.items()}

    @property
    def freedom(self) -> Mapping[str, Array]:
        """Degrees of freedom of the variances of `physical`, (p,), by name."""
        return {
            name: np.min(np.where(self._slopes != 0, freedom, np.inf), axis=1)
            for name, freedom in self.whole.freedom.items()
        }

    @property
    def filter_bias(self) -> Array | None:
        """What filter and noise move `physical` by, (p,), as twins tell."""
        bias = self.whole.filter_bias
        return None if bias is None else np.asarray(self._slopes @ bias)

    @property
    def corrected(self) -> Array:
        """Values less the bias of filter and noise, (p,)."""
        bias = self.filter_bias
        return self.physical if bias is None else self.physical - bias

    @property
    def gain_relative_sd(self) -> float:
        """Of the drive gain that scaled the force."""
        return self.whole.gain_relative_sd

    @property
    def gain_slopes(self) -> Array | None:
        """Of `physical` by the logarithm of the gain, (p,), where that is not exact."""
        slopes = self.whole.gain_slopes
        return None if slopes is None else np.asarray(self._slopes @ slopes)

    @property
    def parameters(self) -> NamedValues:
        """Parameters of the record's axis by name."""
        bias, variances = self.filter_bias, self.covariances
        slopes = self.gain_slopes
        moved = np.zeros(len(self.physical)) if slopes is None else self.gain_relative_sd * slopes
        return NamedValues(
            {
                q.name: value_with_interval(
                    self,
                    float(value),
                    q.unit,
                    {name: float(c[j, j]) for name, c in variances.items()},
                    abs(float(moved[j])),
                    None if bias is None else float(bias[j]),
                    float(self.freedom[self.chosen][j]),
                )
                for j, (q, value) in enumerate(zip(self.quantities, self.physical, strict=True))
            }
        )


@dataclass(frozen=True, kw_only=True)
class SavedPart:
    """A saved result as one of its records has it: what can be exported, and held against another.

    Attributes
    ----------
    requested : Prefilter or None
    preferred_method : str
        That is judged.
    estimates : mapping of str to PartEstimate
        By method.
    of_record : OfRecord
    layout : Layout
    place : int
    """

    requested: Prefilter | None
    preferred_method: str
    estimates: Mapping[str, PartEstimate]
    of_record: OfRecord
    layout: Layout
    place: int

    @property
    def axis(self) -> GeneratedAxis:
        """With what is known of the record put in."""
        return self.layout.members[self.place].axis

    @property
    def record(self) -> RecordInfo:
        """The record, without its samples."""
        return self.of_record.record

    @property
    def prefilter(self) -> Prefilter:
        """Of the record."""
        return self.of_record.sampling.prefilter

    @property
    def of_records(self) -> tuple[OfRecord, ...]:
        """None beside this one."""
        return ()

    @property
    def local_names(self) -> Mapping[str, tuple[str, ...]]:
        """None, as what is the record's own is a parameter of its axis."""
        return {}
