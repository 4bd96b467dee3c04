"""One of several records of a file: its axis, and the parameters that it has of those of all."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.estimates import Distribution, NamedValues
from axisid.estimation.identification import OfRecord, RecordInfo
from axisid.estimation.parameters import JointForm
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import Prefilter

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
        return InverseForm(self.joint.members[self.place].axis)

    @property
    def method(self) -> str:
        """See `SavedEstimate`."""
        return self.whole.method

    @property
    def equation_error_percent(self) -> float:
        """Of all records."""
        return self.whole.equation_error_percent

    @property
    def simulation_error_percent(self) -> float | None:
        """Of all records."""
        return self.whole.simulation_error_percent

    @cached_property
    def distribution(self) -> Distribution:
        """Of the parameters of the record's axis."""
        whole = self.whole.distribution
        jacobian = self.joint.physical(self.joint.regressed(whole.theta))[1]
        return whole.through(
            self.form.axis.parameters,
            self.joint.own(whole.theta, self.place),
            self.joint.slopes(self.place) @ np.linalg.inv(jacobian),
        )

    @property
    def parameters(self) -> NamedValues:
        """Parameters of the record's axis by name."""
        return self.distribution.values


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
    axis : GeneratedAxis
        With what is known of the record put in.
    """

    requested: Prefilter | None
    preferred_method: str
    estimates: Mapping[str, PartEstimate]
    of_record: OfRecord
    axis: GeneratedAxis

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
