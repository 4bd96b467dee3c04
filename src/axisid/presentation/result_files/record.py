"""Records in documents: provenance, drive response, signals and prefilter."""

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
    """Provenance and size of a record."""

    source: Annotated[str, about("File name, or origin of a record without a file.")]
    given: Annotated[str | None, about("File as given; null if there is none.")]
    path: Annotated[str | None, about("Absolute path of the file; null if there is none.")]
    sha256: Annotated[
        str | None,
        about(
            "sha256 of the bytes of the file, or of the files of a folder in the order of their "
            "names."
        ),
    ]
    columns: Annotated[Mapping[str, str], about("Column name by role.")]
    truth: Annotated[Mapping[str, float] | None, about("True values of a twin, SI, by parameter.")]
    assumed: Annotated[
        tuple[str, ...],
        about("Assumptions about the file: separator, encoding, units and their conversion."),
    ]
    repairs: Annotated[
        tuple[Repair, ...],
        about("Repairs of the data on request, in this order."),
    ]
    segments: Annotated[
        tuple[tuple[int, int], ...],
        about(
            "First row and row after the last of each segment between gaps; empty for one segment."
        ),
    ]
    masked: Annotated[
        tuple[tuple[int, int], ...],
        about("First row and row after the last, for each range that is not a measurement."),
    ]
    samples: int
    period: Annotated[float, about("s")]
    digest: Annotated[
        str,
        about(
            "sha256 of the samples: for time, position, velocity, acceleration, reference, "
            "control, force and test signal, if present, the role, and for recorded signals the "
            "name, each followed by the values as 64-bit floats."
        ),
    ]
    injected_at: Annotated[
        Literal["control", "reference"] | UnsetType,
        about("Signal that a recorded test signal was added to."),
    ] = UNSET
    motion: Annotated[
        tuple[Literal["position", "velocity", "acceleration"], ...] | UnsetType,
        about("Measured quantities of the motion; absent for the position alone."),
    ] = UNSET
    windows: Annotated[
        tuple[tuple[float, float], ...] | UnsetType,
        about("First and last time of each used window of the log, s; absent for the whole log."),
    ] = UNSET

    def __len__(self) -> int:
        return self.samples

    @property
    def size(self) -> str:
        """Return number of samples, sampling period and number of segments as text."""
        segments = f" in {len(self.segments)} segments" if self.segments else ""
        return f"{len(self)} samples of {1e3 * self.period:.6g} ms{segments}"

    @property
    def provenance(self) -> Provenance:
        """Return the provenance, as in a `Record`."""
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
    """An estimated lag or delay of a drive, s."""

    name: str
    of: Annotated[Literal["lag", "delay"], about("Estimated time.")]
    nominal: Annotated[float, about("Start value of the search.")]
    value: float
    sd: Annotated[
        float, about("HAC standard error; it is included in the standard errors of the parameters.")
    ]
    interval_95: tuple[float, float]


class WrittenResponse(JsonObject, frozen=True, kw_only=True):
    """Response of the drive to a command, and place where the control was recorded."""

    lag: Annotated[float, about("Time constant, s; 0 for none.")]
    delay: Annotated[float, about("Dead time from the command to its action, s; 0 for none.")]
    logged: Annotated[
        Literal["command", "applied", "current"],
        about(
            "Recorded control: command, or after the delay (applied), or after the lag (current)."
        ),
    ]
    unit: Annotated[
        str | UnsetType, about("Unit of the control, if one of the following is declared.")
    ] = UNSET
    rate_limit: Annotated[
        float | UnsetType, about("Maximum rate of change of the acting control, unit/s.")
    ] = UNSET
    quantisation: Annotated[
        float | UnsetType, about("Quantisation step of the command, in its unit.")
    ] = UNSET
    deadband: Annotated[
        float | UnsetType,
        about("Half width of the deadband of the command, in its unit; subtracted outside it."),
    ] = UNSET
    estimated: WrittenDriveTime | UnsetType = UNSET


class WrittenSignal(JsonObject, frozen=True, kw_only=True):
    """A recorded signal that the axis declares."""

    name: str
    unit: str
    between: Annotated[Literal["linear", "held"], about("Interpolation between samples.")]


class WrittenRequest(JsonObject, frozen=True, kw_only=True):
    """A requested prefilter; null for settings that are chosen for the record."""

    cutoff: Annotated[float, about("Cut-off frequency of the low-pass, Hz.")]
    order: int
    decimate: Annotated[int, about("Decimation factor.")]
    decimation: Literal["matlab", "scipy"]
    drop: Annotated[tuple[int, int] | None, about("Samples dropped at start and end.")]
    hold: Literal["raw", "zoh"] | None
    reversals: Literal["keep", "leave-out"] | None


class WrittenPrefilter(WrittenRequest, frozen=True, kw_only=True):
    """The applied prefilter."""

    drop: Annotated[tuple[int, int], about("Samples dropped at start and end, as applied.")]
    hold: Annotated[Literal["raw", "zoh"], about("As applied.")]
    reversals: Annotated[
        Literal["keep", "leave-out"],
        about("Treatment of samples near reversals and standstill."),
    ]
    silent: Annotated[int, about("Number of samples left out near reversals and standstill.")]


def written_record(record: Record) -> WrittenRecord:
    """Return provenance and size of a record as part of a document."""
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
    """Return the settings of a prefilter, as applied to a record, as part of a document."""
    return written_as(
        WrittenPrefilter,
        sampling.filter.settings,
        drop=sampling.filter.dropped,
        silent=sampling.excluded_samples,
    )
