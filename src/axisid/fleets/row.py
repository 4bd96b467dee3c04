"""What is kept of one log: a line of the ledger, a row of the table."""

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import chain
from typing import Annotated, Any, Literal

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Belief, Checked, gravest_first
from axisid.populations import LARGEST
from axisid.presentation.schema import JsonObject, Matrix, about

_NO_RESULT, _IN_RESULT = "it came to no result", "see the result of the log"

Status = Literal["ok", "failed", "skipped"]


class FleetValue(JsonObject, frozen=True, kw_only=True):
    """A parameter of one log."""

    value: Annotated[float, about("Less the bias of filter and noise, where that is known.")]
    sd: Annotated[float, about("Of the chosen covariance.")]
    interval_95: tuple[float, float]
    unit: str


class FleetRow(
    Checked, JsonObject, frozen=True, kw_only=True, tag_field="schema", tag="axisid.fleet/1"
):
    """One log of a fleet.

    Attributes
    ----------
    name : str
        Of its result, without the ending.
    log, axis, serial, columns, conditions
        As of its `FleetItem`.
    status : {"ok", "failed", "skipped"}
        Skipped is what was there already, with its result.
    reason, code : str
        Why it failed: a sentence, and what a program can tell it by; ``time`` and ``killed`` are of
        what an identification cannot tell.
    key : str
        Of the log's bytes, the axis and the options: with the same the result is the same.
    method : str
        The one that is judged.
    parameters : mapping of str to FleetValue
    covariance : matrix
        Of the parameters in their order.
    failing : tuple of str
        Checks that fail, the gravest first.
    doubt : str
        What the gravest of them says.
    seconds : float
        CPU time.
    """

    name: str
    log: str
    axis: str
    serial: str = ""
    columns: Mapping[str, str] = {}
    conditions: Mapping[str, str | float] = {}
    status: Status
    reason: str = ""
    code: str = ""
    key: str = ""
    signature: str = ""
    method: str = ""
    parameters: Mapping[str, FleetValue] = {}
    covariance: Matrix = ()
    failing: tuple[str, ...] = ()
    doubt: str = ""
    seconds: float = 0.0

    @property
    def has_result(self) -> bool:
        """Whether there is a result, from this run or an earlier one."""
        return self.status != "failed"

    @property
    def checks(self) -> tuple[Check, ...]:
        """Those that fail, the gravest first, which alone says what; the result has all."""
        if not self.has_result:
            return (Check.unless("result", self.reason or _NO_RESULT),)
        said = (self.doubt or _IN_RESULT, *[_IN_RESULT] * len(self.failing))
        return tuple(map(Check.unless, self.failing, said))

    @property
    def verdict(self) -> Belief | Literal[""]:
        """The belief in the values; empty without a result."""
        return self.belief if self.has_result else ""

    @property
    def is_comparable(self) -> bool:
        """Whether the values and their covariance are numbers whose squares are ones too."""
        found = chain((each.value for each in self.parameters.values()), *self.covariance)
        return all(abs(each) < LARGEST for each in found)


def counts_of(rows: Iterable[FleetRow]) -> dict[str, int]:
    """How many rows there are of each status."""
    found = Counter(row.status for row in rows)
    return {status: found[status] for status in ("ok", "skipped", "failed")}


def judged(document: Mapping[str, Any]) -> dict[str, Any]:
    """What a row has of a result as ``--json`` writes it."""
    estimate = next(e for e in document["estimates"] if e["method"] == document["judged"])
    chosen = estimate["chosen_covariance"]
    covariances = {
        **(estimate.get("covariances") or {}),
        "iid": estimate["covariance"],
        "robust": estimate["covariance_robust"],
        "hac": estimate["covariance_hac"],
    }
    return {
        "signature": document["signature"],
        "method": estimate["method"],
        "parameters": {
            name: FleetValue(
                value=each["value"] - (each["filter_bias"] or 0.0),
                sd=_deviation(each, chosen),
                interval_95=tuple(each["interval_95"]),
                unit=each["unit"],
            )
            for name, each in estimate["parameters"].items()
        },
        "covariance": tuple(map(tuple, covariances[chosen])),
        **_doubts(document),
    }


def _doubts(document: Mapping[str, Any]) -> dict[str, Any]:
    """Which checks fail, and what the gravest of them says."""
    said = {c["name"]: c["meaning"] for c in document["verdict"] if c["status"] == "fail"}
    failing = gravest_first(said)
    return {"failing": tuple(failing), "doubt": said[failing[0]] if failing else ""}


def _deviation(value: Mapping[str, Any], chosen: str) -> float:
    own = {"iid": "sd", "robust": "sd_robust", "hac": "sd_hac"}
    return float(value[own[chosen]] if chosen in own else value["deviations"][chosen])
