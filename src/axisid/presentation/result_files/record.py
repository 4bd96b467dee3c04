"""A record: where it comes from, and how it became rows."""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import UNSET, UnsetType

from axisid.estimation.raw_tables import Provenance, Repair
from axisid.estimation.records import Record
from axisid.estimation.signals import Sampling

from .json_objects import JsonObject, about, written_as


class WrittenRecord(
    JsonObject,
    frozen=True,
    kw_only=True,
    rename={"period": "sample_period", "digest": "samples_sha256"},
):
    """Where the data come from."""

    source: Annotated[str, about("File name, or how the record was made.")]
    given: Annotated[str | None, about("The file as it was named; null where there is none.")]
    path: Annotated[str | None, about("The file, absolute; null where there is none.")]
    sha256: Annotated[
        str | None,
        about(
            "Of the file, or of the files of a folder in the order of their names; of the very "
            "bytes that were used."
        ),
    ]
    columns: Annotated[Mapping[str, str], about("Column name by role.")]
    truth: Annotated[Mapping[str, float] | None, about("Of a twin, SI, by parameter.")]
    assumed: Annotated[
        tuple[str, ...],
        about("What was taken of the file: separator, encoding, units and their conversion."),
    ]
    repairs: Annotated[
        tuple[Repair, ...],
        about("What was done to the data on request, in this order."),
    ]
    segments: Annotated[
        tuple[tuple[int, int], ...],
        about(
            "First row and the one after the last of each piece between gaps; empty for one piece."
        ),
    ]
    masked: Annotated[
        tuple[tuple[int, int], ...],
        about("Rows that are no measurements, likewise."),
    ]
    samples: int
    period: Annotated[float, about("s")]
    digest: Annotated[
        str,
        about(
            "Of the samples: of time, position, velocity, acceleration, reference, control, force "
            "and test signal, as far as there are, the role, and of recorded signals the name, "
            "then the values as 64-bit floats."
        ),
    ]
    injected_at: Annotated[
        Literal["control", "reference"] | UnsetType,
        about("What a recorded test signal was added to."),
    ] = UNSET
    motion: Annotated[
        tuple[Literal["position", "velocity", "acceleration"], ...] | UnsetType,
        about("What of the motion was measured; absent where it is the position alone."),
    ] = UNSET
    windows: Annotated[
        tuple[tuple[float, float], ...] | UnsetType,
        about("First and last time of each part of the log that was taken, s; not of a whole one."),
    ] = UNSET

    def __len__(self) -> int:
        return self.samples

    @property
    def size(self) -> str:
        """Samples and sampling period, in words."""
        pieces = f" in {len(self.segments)} segments" if self.segments else ""
        return f"{len(self)} samples of {1e3 * self.period:.6g} ms{pieces}"

    @property
    def provenance(self) -> Provenance:
        """Where it comes from, as a `Record` has it."""
        return Provenance(
            source=self.source,
            sha256=self.sha256 or "",
            given=self.given or "",
            path=self.path or "",
            columns=dict(self.columns),
            truth=dict(self.truth or {}),
            assumed=self.assumed,
            repairs=self.repairs,
        )


class WrittenDriveTime(JsonObject, frozen=True, kw_only=True):
    """A drive's lag or delay that was estimated, s."""

    name: str
    of: Annotated[Literal["lag", "delay"], about("Which of the drive's times it is.")]
    nominal: Annotated[float, about("Where the search started.")]
    value: float
    sd: Annotated[float, about("HAC; what it adds is in the deviations of the parameters.")]
    interval_95: tuple[float, float]


class WrittenResponse(JsonObject, frozen=True, kw_only=True):
    """How the drive follows a command, and where the control was recorded."""

    lag: Annotated[float, about("Time constant, s; 0 for none.")]
    delay: Annotated[float, about("From the command to when it acts, s; 0 for none.")]
    logged: Annotated[
        Literal["command", "applied", "current"],
        about("What the recorded control is: what acts after the delay, what is left by the lag."),
    ]
    unit: Annotated[
        str | UnsetType, about("Of the control, where one of the following is declared.")
    ] = UNSET
    rate_limit: Annotated[
        float | UnsetType, about("Most that the acting control changes in a second, unit/s.")
    ] = UNSET
    quantisation: Annotated[
        float | UnsetType, about("Step to which a command is rounded, in its unit.")
    ] = UNSET
    deadband: Annotated[
        float | UnsetType,
        about("Half width of the commands that make no force, in their unit; taken off others."),
    ] = UNSET
    estimated: WrittenDriveTime | UnsetType = UNSET


class WrittenSignal(JsonObject, frozen=True, kw_only=True):
    """A recorded signal that the axis declares."""

    name: str
    unit: str
    between: Annotated[Literal["linear", "held"], about("How it runs between samples.")]


class WrittenRequest(JsonObject, frozen=True, kw_only=True):
    """A prefilter as it was asked for; null is what was left open, to be chosen for the record."""

    cutoff: Annotated[float, about("Hz")]
    order: int
    decimate: Annotated[int, about("One row in so many.")]
    decimation: Literal["matlab", "scipy"]
    drop: Annotated[tuple[int, int] | None, about("Samples to leave out at start and end.")]
    hold: Literal["raw", "zoh"] | None
    reversals: Literal["keep", "leave-out"] | None


class WrittenPrefilter(WrittenRequest, frozen=True, kw_only=True):
    """How the record became rows."""

    drop: Annotated[tuple[int, int], about("Samples left out at start and end, as applied.")]
    hold: Annotated[Literal["raw", "zoh"], about("As applied.")]
    reversals: Annotated[
        Literal["keep", "leave-out"],
        about("Whether samples near reversals and rests are left out."),
    ]
    silent: Annotated[int, about("Samples that were left out for that.")]


def written_record(record: Record) -> WrittenRecord:
    """Provenance and size of a record."""
    origin = record.provenance
    return written_as(
        WrittenRecord,
        record,
        source=origin.source,
        given=origin.given or None,
        path=origin.path or None,
        sha256=origin.sha256 or None,
        columns=origin.columns,
        truth=origin.truth or None,
        assumed=(*origin.assumed, *origin.doubts),
        repairs=origin.repairs,
        samples=len(record),
        injected_at=record.injected_at or UNSET,
        motion=UNSET if record.motion == ("position",) else record.motion,
        windows=record.windows or UNSET,
    )


def written_prefilter(sampling: Sampling) -> WrittenPrefilter:
    """Settings of a prefilter; `drop` as it was applied, nothing left open."""
    return written_as(
        WrittenPrefilter,
        sampling.filter.settings,
        drop=sampling.filter.dropped,
        silent=sampling.excluded_samples,
    )
