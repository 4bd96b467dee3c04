"""One of several records of a file: its axis, and the parameters that it has of those of all."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.estimates import NamedValues, SamplingDistribution
from axisid.estimation.identification import RecordInfo, RecordResult
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
    method : str
    whole : SavedEstimate
    joint : JointForm
    place : int
        Of the record, from 0.
    equation_error_percent, simulation_error_percent : float
        Of all records; the latter None where they could not be simulated.
    """

    method: str
    whole: SavedEstimate
    joint: JointForm
    place: int
    equation_error_percent: float
    simulation_error_percent: float | None

    @property
    def form(self) -> InverseForm:
        """Of the record's axis."""
        return InverseForm(self.joint.members[self.place].axis)

    @cached_property
    def distribution(self) -> SamplingDistribution:
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
    record : RecordInfo
        Without its samples.
    prefilter : Prefilter
        Of the record.
    axis : GeneratedAxis
        With what is known of the record put in.
    of_records, local_names
        Nothing beside this one: what is the record's own is a parameter of its axis.
    """

    requested: Prefilter | None
    preferred_method: str
    estimates: Mapping[str, PartEstimate]
    record: RecordInfo
    prefilter: Prefilter
    axis: GeneratedAxis
    of_records: tuple[RecordResult, ...] = ()
    local_names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
