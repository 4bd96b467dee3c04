"""The result object: estimates with what they were made from."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from axisid.codegen import GeneratedAxis

from .estimate import Estimate
from .law_check import LawCheck, check_law
from .prefilter import Prefilter
from .record import Record
from .serialised import estimate_dict, law_check_dict, prefilter_dict, record_dict
from .summary import summary_text
from .verdict import Check, verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Identification:
    """The estimates of one axis from one record.

    Attributes
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
    estimates : mapping of str to Estimate
        By method.
    skipped : mapping of str to str
        Methods that were not asked for by name and that axis or record do not allow, with the
        reason.
    failed : mapping of str to str
        Methods that were not asked for by name and came to nothing, with the reason.
    """

    axis: GeneratedAxis
    record: Record
    prefilter: Prefilter
    estimates: Mapping[str, Estimate]
    skipped: Mapping[str, str]
    failed: Mapping[str, str]

    def __getitem__(self, method: str) -> Estimate:
        return self.estimates[method]

    @property
    def law_check(self) -> LawCheck | str:
        """The control law against the record, or why it cannot be checked."""
        return check_law(self.axis, self.record)

    @property
    def verdict(self) -> tuple[Check, ...]:
        """What was checked, against what, and what it means."""
        return verdict(self.axis, self.record, self.prefilter, self.estimates, self.law_check)

    def summary(self) -> str:
        """The estimates side by side as text, with numbered notes."""
        return summary_text(
            self.axis,
            self.record,
            self.prefilter,
            tuple(self.estimates.values()),
            {**self.skipped, **self.failed},
            self.verdict,
        )

    def __str__(self) -> str:
        return self.summary()

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes: plain numbers, texts and lists."""
        law = self.law_check
        return {
            "axis": self.axis.axis.name,
            "signature": self.axis.signature,
            "record": record_dict(self.record),
            "prefilter": prefilter_dict(self.prefilter, self.record.period),
            "estimates": [estimate_dict(estimate) for estimate in self.estimates.values()],
            "law_check": law_check_dict(law),
            "verdict": [
                asdict(check)
                for check in verdict(self.axis, self.record, self.prefilter, self.estimates, law)
            ],
            "skipped": dict(self.skipped),
            "failed": dict(self.failed),
        }
