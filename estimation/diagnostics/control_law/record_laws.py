"""Comparison of the declared control law with each of several records, made once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.verdict_checks import unless_faulty
from axisid.support.arrays import Exact, Uncached
from axisid.support.missing import Missing

from .law_agreement import LawAgreement, law_agreement


@dataclass(frozen=True, repr=False, eq=False)
class RecordLaws(Uncached, Exact):
    """The declared control law compared with each record.

    Attributes
    ----------
    records : tuple of (GeneratedAxis, Record)
        The records, each with its axis.
    """

    records: tuple[tuple[GeneratedAxis, Record], ...]

    @classmethod
    def of(cls, data: Sequence[FilteredRecord]) -> "RecordLaws":
        """Return the comparison of the law with each record of a problem; it is made when used."""
        return cls(tuple((each.axis, each.record) for each in data))

    @cached_property
    def agreements(self) -> tuple[LawAgreement | Missing, ...]:
        """Comparison of the law with each record, or the reason why it is unavailable."""
        return tuple(
            unless_faulty(partial(law_agreement, axis, record)) for axis, record in self.records
        )

    @property
    def hold(self) -> bool:
        """True if every recorded control follows the declared law."""
        return all(isinstance(law, LawAgreement) and law.passed for law in self.agreements)
