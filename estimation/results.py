"""The result object: estimates with what they were made from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from axisid.codegen import GeneratedAxis

from .check import Check
from .diagnosis import Diagnosis, diagnose
from .estimate import Estimate
from .prefilter import Prefilter
from .record import Record
from .serialised import (
    SCHEMA,
    diagnosis_dict,
    drawn_dict,
    estimate_dict,
    prefilter_dict,
    record_dict,
)
from .summary import drawn_text, summary_text


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
    def diagnosis(self) -> Diagnosis:
        """What the tests of the result measured; made anew each time."""
        return diagnose(self.axis, self.record, self.prefilter, self.estimates)

    @property
    def verdict(self) -> tuple[Check, ...]:
        """What was checked, against what, and what it means."""
        return self.diagnosis.verdict

    def summary(self, draws: int = 0) -> str:
        """The estimates side by side as text, with numbered notes.

        Parameters
        ----------
        draws : int
            How many to draw from each estimate's distribution, for a table of intervals that do
            without the delta method; 0 for none.
        """
        drawn = f"\n{drawn_text(self.estimates, draws)}" if draws else ""
        text = summary_text(
            self.axis,
            self.record,
            self.prefilter,
            tuple(self.estimates.values()),
            {**self.skipped, **self.failed},
            self.verdict,
        )
        return text + drawn

    def __str__(self) -> str:
        return self.summary()

    def to_dict(self, draws: int = 0) -> dict[str, Any]:
        """What ``--json`` writes: plain numbers, texts and lists; `draws` as in `summary`."""
        diagnosis = self.diagnosis
        return {
            "schema": SCHEMA,
            "axis": self.axis.axis.name,
            "signature": self.axis.signature,
            "record": record_dict(self.record),
            "prefilter": prefilter_dict(self.prefilter, self.record.period),
            "estimates": [
                {**estimate_dict(e), "drawn": drawn_dict(e, draws) if draws else None}
                for e in self.estimates.values()
            ],
            **diagnosis_dict(diagnosis, self.axis.names),
            "skipped": dict(self.skipped),
            "failed": dict(self.failed),
        }
