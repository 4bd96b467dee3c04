"""The declared control law compared with each of several records, once for all who ask."""

from dataclasses import dataclass
from functools import cached_property, partial

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.verdict_checks import unless_faulty
from axisid.support.arrays import Exact, Uncached
from axisid.support.errors import Missing

from .law_agreement import LawAgreement, law_agreement


@dataclass(frozen=True, repr=False, eq=False)
class RecordLaws(Uncached, Exact):
    """The declared control law compared with each record.

    Attributes
    ----------
    records : tuple of (GeneratedAxis, Record)
        Each with its axis.
    """

    records: tuple[tuple[GeneratedAxis, Record], ...]

    @cached_property
    def agreements(self) -> tuple[LawAgreement | Missing, ...]:
        """Agreement of each record with its law, or the reason why it cannot be checked."""
        return tuple(
            unless_faulty(partial(law_agreement, axis, record)) for axis, record in self.records
        )

    @property
    def hold(self) -> bool:
        """Whether every record's control is the declared law's."""
        return all(isinstance(law, LawAgreement) and law.passed for law in self.agreements)
