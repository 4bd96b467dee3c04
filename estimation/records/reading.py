"""From the columns of a log to a record: roles, repairs, one clock."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_declared
from axisid.estimation.logs import read_table
from axisid.estimation.records.columns import RoleColumns, motion_role
from axisid.estimation.tables import PeriodSource, Provenance, Repair, Samples, Table
from axisid.estimation.thresholds import MAX_EVEN_STEP, MAX_UNEVEN_STEP
from axisid.modeling.declaration import Axis, Column, column_texts
from axisid.support.arrays import Array, runs
from axisid.support.errors import DataError, UsageError, quoted
from axisid.support.memory import Room, room_for

from .clipping import Mask, clipped, clipping_notes
from .clocks import (
    check_sample_period,
    clocked,
    count_by_period,
    count_past_restarts,
    filled,
    open_end,
    step_notes,
)
from .record import Record
from .repairs import Repairs, Span, split_at_gaps
from .resampling import AlignedColumns, resample
from .run_file import is_run_file, read_run
from .shifts import drawn_between, seldom_notes, shifted
from .windows import Window, checked_windows, edges, windows_text, within
from .wrapping import remaining_jumps_note, signed, unwrapped


def read_record(
    log: str | Path | object,
    axis: Axis | GeneratedAxis | None = None,
    *,
    columns: Mapping[str, str | Column] | None = None,
    sample_period: float | None = None,
    injected_at: str | None = None,
    windows: Iterable[tuple[float | None, float | None] | str] = (),
    repairs: Repairs | None = None,
    max_memory: float | None = None,
) -> Record:
    """Read a record, its columns found by the roles' names.

    Parameters
    ----------
    log : str, Path, dataframe or mapping
        A file of a format of `axisid.estimation.logs.formats` by its ending (``.mat``,
        ``.parquet``, ``.npz``, ``.mf4``, ``.tdms``, ``.bag``, ...), the folder of a ROS 2 bag, and
        delimited text by any other ending, also compressed (``.csv.gz``).
        Or a dataframe, or a mapping of column names to arrays. Or a ``run.toml`` that names the
        log and says what it is: its keys are the arguments here, and those of `repairs`, by which
        what is given here goes before what it says.
    axis : Axis or GeneratedAxis, optional
        Its `columns` name the columns of its logs; its coordinate and drive say what they measure.
    columns : mapping of str to str or Column, optional
        Column names by role, over those of the axis, or numbers from 1 (``"#3"``), each with what
        its numbers mean if they are not SI: a unit (``"pos:mm"``) or a scaling
        (``"inc:counts*360deg/4096/50+0.2deg"``). A role that neither names is looked for under its
        own name (``time``, ``position``, ``reference``, ``control``, ``force``); a column that only
        bears the name ``velocity`` or ``acceleration`` serves where there is no position. The
        signals that the axis declares are roles of their names.
    injected_at : str, optional
        What the test signal in the column ``injected`` was added to, ``"control"`` or
        ``"reference"``, over what the axis says.
    sample_period : float, optional
        s; takes the place of the time column's mean step, and of the column if there is none.
    windows : iterable of (float or None, float or None) or str, optional
        First and last time, s, as the log's own time counts, of what is taken; None for the log's
        beginning or end, or ``"2..8.5"``. All else is left out before anything is looked at: each
        window is a segment of the record. The whole log by default.
    repairs : Repairs, optional
        What may be done to the data; nothing by default.
    max_memory : float, optional
        Bytes that reading a file may take, as far as they can be told beforehand; half of the
        machine's memory by default.

    Returns
    -------
    Record
        In SI; `Provenance.assumed`, `doubts` and `repairs` tell how it came to be.

    Raises
    ------
    RunFileError
        A ``run.toml`` is wrong: every mistake in it.
    DataError
        The file is missing, malformed or too large, changes while it is read, lacks a column, or
        needs a repair that is not asked for; a window is outside it, or holds nothing.
    UsageError
        A role does not exist, a window is no pair of times or overlaps another, a unit is not the
        role's, or a sampling period is given for columns that are resampled by times of their own.
    """
    if sample_period is not None:
        check_sample_period(sample_period)
    declared = as_declared(axis)
    if columns is not None and not isinstance(columns, Mapping):
        raise UsageError(
            f"the columns are {quoted(columns)}; give names by role, such as "
            f"{{'position': 'q:mm'}}.",
            code="columns",
        )
    if repairs is not None and not isinstance(repairs, Repairs):
        raise UsageError(
            f"the repairs are {quoted(repairs)}; give axisid.estimation.Repairs(gaps='split') or "
            "the like.",
            code="repairs",
        )
    if is_run_file(log):
        file, said = read_run(
            Path(str(log)),
            declared,
            columns=columns or {},
            repairs=repairs or Repairs(),
            sample_period=sample_period,
            injected_at=injected_at,
            windows=windows,
            max_memory=max_memory,
        )
        return read_record(file, axis, **said)
    repairs = repairs or Repairs()
    chosen = checked_windows(windows)
    table = read_table(log, drop_tail=repairs.tail is not None, max_memory=max_memory)
    found = RoleColumns(
        table,
        declared,
        column_texts(columns or {}),
        has_period=sample_period is not None,
        injected_at=injected_at,
    )
    room = room_for(table.source, max_memory)
    return _record(table, found, declared, sample_period, repairs, chosen, room)


def _record(
    table: Table,
    found: RoleColumns,
    axis: Axis | None,
    sample_period: float | None,
    repairs: Repairs,
    windows: tuple[Window, ...],
    room: Room,
) -> Record:
    """A record of the chosen columns, repaired as it was asked for."""
    if not windows:
        room.check_samples(max(len(s.values) for s in found.samples.values()))
    counted = "time" not in found.samples and all(s.clock is None for s in found.samples.values())
    read, retimed = _retimed(found.samples, sample_period, repairs)
    uneven = repairs.resample is not None
    timed = clocked(table, read, sample_period)
    filled_in, drawn = drawn_between(table.source, timed, repairs.between, uneven=uneven)
    whole, moved = shifted(table.source, filled_in, repairs.shift, uneven=uneven)
    columns, taken, name = whole, [], table.source
    if windows:
        columns, windows, cut_out = within(table.source, whole, windows)
        taken, name = [cut_out], f"{table.source} {windows_text(windows)}"
        room.check_samples(max(len(s.values) for s in columns.values()))
    samples = filled(replace(table, source=name), columns, uneven=uneven)
    empty = _dropped_rows(columns, samples)
    samples, masks, made, jumps = _repaired(name, samples, axis, repairs)
    seldom = seldom_notes({r: s for r, s in samples.items() if r not in repairs.between})
    cut = [] if repairs.mask is not None else clipping_notes(samples, axis)
    if repairs.resample is None:
        aligned = _as_sampled(samples, masks, sample_period, repairs, windows)
    else:
        splined = ("position", "velocity", "reference")
        aligned = resample(
            name,
            samples,
            masks,
            repairs.resample,
            split=repairs.gaps is not None,
            stated=sample_period,
            splined=(*splined, "injected") if found.injected_at == "reference" else splined,
            between=repairs.between,
            edges=edges(windows),
            held=() if axis is None else [s.name for s in axis.signals if s.is_held],
        )
    spans = aligned.segments or ((0, len(aligned.time)),)
    jitter = step_notes([aligned.time[start:stop] for start, stop in spans])
    signals = {signal.name for signal in axis.signals} if axis is not None else set()

    def record(of: AlignedColumns, *repaired: Repair, **besides: Any) -> Record:
        return Record(
            time=of.time,
            **{r: v for r, v in of.columns.items() if r not in signals},  # type: ignore[arg-type]
            signals={name: v for name, v in of.columns.items() if name in signals},
            injected_at=found.injected_at,
            sample_period=of.period,
            segments=of.segments,
            masked=runs(of.masked),
            windows=windows,
            provenance=Provenance(
                source=Path(table.source).name,
                sha256=table.sha256,
                given=table.source if table.path else "",
                path=table.path,
                columns=found.names,
                assumed=found.notes,
                doubts=(*jumps, *cut, *seldom, *jitter),
                repairs=(
                    *table.repairs,
                    *retimed,
                    *drawn,
                    *moved,
                    *taken,
                    *made,
                    *empty,
                    *repaired,
                ),
                clock=replace(of.clock, counted=counted),
            ),
            **besides,
        )

    sampled = None
    if repairs.resample is not None and _share(samples, samples[motion_role(samples)].times):
        with suppress(DataError):  # times too uneven for a record
            sampled = record(_as_sampled(samples, masks, None, repairs, windows))
    return record(aligned, *aligned.repairs, around=whole if windows else {}, sampled=sampled)


def _as_sampled(
    samples: dict[str, Samples],
    masks: dict[str, Mask],
    period: float | None,
    repairs: Repairs,
    windows: Sequence[Window],
) -> AlignedColumns:
    """Columns at the times that they have, cut between windows, and at gaps if it was asked for."""
    time = np.asarray(samples[motion_role(samples)].times, dtype=np.float64)
    values = {role: s.values for role, s in samples.items()}
    masked = np.any([np.zeros(len(time), dtype=bool), *masks.values()], axis=0)
    cuts = [int(row) for row in np.searchsorted(time, edges(windows), side="right")]
    segments: tuple[Span, ...] = tuple(pairwise([0, *cuts, len(time)])) if cuts else ()
    made: tuple[Repair, ...] = ()
    if repairs.gaps is not None:
        kept, segments, repair = split_at_gaps(time, cuts)
        time, masked, made = time[kept], masked[kept], (repair,)
        values = {role: v[kept] for role, v in values.items()}
    spans = segments or ((0, len(time)),)
    jitter = open_end([time[start:stop] for start, stop in spans])
    return AlignedColumns(
        time=time,
        columns=values,
        masked=masked,
        segments=segments,
        period=period,
        repairs=made,
        clock=PeriodSource(
            uncertainty=jitter if period is None else 0.0, stated=period is not None
        ),
    )


def _retimed(
    samples: dict[str, Samples], period: float | None, repairs: Repairs
) -> tuple[dict[str, Samples], list[Repair]]:
    """Samples whose clock counts a given period, or goes on where it was set back, and which.

    Columns with clocks of their own need not have been set back at one time, and stay.
    """
    own = samples["time"].values if "time" in samples else samples[motion_role(samples)].clock
    if own is None or not ("time" in samples or _share(samples, own)):
        return samples, []
    clock, made = own, []
    if period is not None:
        clock, text = count_by_period(own, period)
        made += [Repair(kind="clock", count=len(clock), text=text)] if text else []
    if repairs.gaps is not None:
        clock, count, text = count_past_restarts(clock, uneven=repairs.resample is not None)
        made += [Repair(kind="clock", count=count, text=text)] if text else []
    moved = {
        role: replace(s, values=clock) if role == "time" else replace(s, clock=clock)
        for role, s in samples.items()
    }
    return moved if made else samples, made


def _share(samples: dict[str, Samples], clock: Array) -> bool:
    clocks = [s.clock for s in samples.values()]
    return all(c is not None and np.array_equal(c, clock, equal_nan=True) for c in clocks)


def _dropped_rows(read: dict[str, Samples], kept: dict[str, Samples]) -> list[Repair]:
    """Rows that a resampled column lacks, for want of a number or of a time."""
    lost = {role: len(read[role].values) - len(s.values) for role, s in kept.items()}
    listed = ", ".join(f"{role} {count}" for role, count in lost.items() if count)
    if not listed:
        return []
    text = f"rows without a number or a time left out before resampling: {listed}"
    return [Repair(kind="empty", count=sum(lost.values()), text=text)]


def _repaired(
    source: str, samples: dict[str, Samples], axis: Axis | None, repairs: Repairs
) -> tuple[dict[str, Samples], dict[str, Mask], list[Repair], list[str]]:
    """Samples unwrapped, and masks of what is clipped: the repairs that need no even time.

    With them goes what is said of jumps that are left.
    """
    made: list[Repair] = []
    masks: dict[str, Mask] = {}
    gap = MAX_EVEN_STEP.value if repairs.resample is None else MAX_UNEVEN_STEP.value
    moduli = repairs.moduli(axis)
    for role, modulus in moduli.items():
        if role == "position":
            samples, repair = unwrapped(source, samples, modulus, gap)
        else:
            samples, repair = signed(source, samples, role, modulus)
        made.append(repair)
    position = samples.get("position")
    jumps = None
    if position is not None:
        jumps = remaining_jumps_note(source, position, axis, gap, moduli.get("position"))
    if repairs.mask is not None:
        masks, repair = clipped(samples, axis)
        made.append(repair)
    return samples, masks, made, [] if jumps is None else [jumps]
