"""Reading of a record from a log: columns by role, repairs, and one clock for all columns."""

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_declared
from axisid.estimation.logs import read_table
from axisid.estimation.raw_tables import Provenance, Table
from axisid.estimation.records.columns import RoleColumns, role_columns
from axisid.estimation.thresholds import MAX_EVEN_STEP, MAX_UNEVEN_STEP
from axisid.estimation.verdict_checks import unless_faulty
from axisid.modeling.declaration import ROLES, Axis, Column, column_texts
from axisid.support.arrays import runs
from axisid.support.checks import refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.memory import Room, room_for
from axisid.support.missing import Missing
from axisid.support.wording import quoted

from .clipping import clipped
from .clocks import (
    check_sample_period,
    clocked,
    filled,
    retimed,
    share_clock,
    step_notes,
)
from .record import Record
from .resampling import resample
from .run_toml import Repairs, is_run_file, read_run
from .segments import Window, as_sampled, checked_windows, edges, within
from .shifts_and_interpolation import drawn_between, seldom_notes, shifted
from .wild_samples import leading_zeros_note, without_wild_samples
from .wrapping import unwound


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
    """Read a record from a log, with its columns by role.

    Parameters
    ----------
    log : str, Path, dataframe or mapping
        A file, whose ending determines its format (``.mat``, ``.parquet``, ``.npz``, ``.mf4``,
        ``.tdms``, ``.bag``, ..., see `axisid.estimation.logs.formats`); with any other ending
        delimited text, also compressed (``.csv.gz``). Or the folder of a ROS 2 bag, a dataframe, or
        a mapping of column names to arrays. Or a ``run.toml``, which names a log and describes it:
        its keys are the arguments of this function and of `Repairs`. Given arguments replace the
        values of the ``run.toml``.
    axis : Axis or GeneratedAxis, optional
        Axis whose `columns` name the columns of its logs; its coordinate and drive determine their
        units.
    columns : mapping of str to str or Column, optional
        Column names by role, instead of those of the axis, or numbers from 1 (``"#3"``), each with
        its unit if it is not SI (``"pos:mm"``), or a scaling
        (``"inc:counts*360deg/4096/50+0.2deg"``). The default name of a role is the role (``time``,
        ``position``, ``reference``, ``control``, ``force``). A column with the name ``velocity`` or
        ``acceleration`` is used only if it is given here or by the axis, as it need not be
        measured. The signals that the axis declares are roles of the same names.
    injected_at : str, optional
        Injection point of the test signal in the column ``injected``, ``"control"`` or
        ``"reference"``, instead of that of the axis.
    sample_period : float, optional
        Sampling period, s, instead of the mean step of the time column; needed without times.
    windows : iterable of (float or None, float or None) or str, optional
        First and last time of each window, s, in the time of the log; None for the beginning or end
        of the log; or a text, ``"2..8.5"``. All other samples are left out before any check. Each
        window is a segment of the record. The whole log by default.
    repairs : Repairs, optional
        Allowed repairs of the data; none by default.
    max_memory : float, optional
        Largest memory for reading a file, bytes, as far as the needed memory is known before;
        half of the machine's memory by default.

    Returns
    -------
    Record
        Record in SI. `assumed`, `doubts` and `repairs` of its `provenance` describe how the log
        was read.

    Raises
    ------
    RunFileError
        A ``run.toml`` has mistakes; the message lists all of them.
    DataError
        The file is missing, malformed or too large, changes while it is read, lacks a column, or
        needs a repair that is not requested; a window is outside the log, or has too few samples.
    UsageError
        An argument has a wrong type, a role does not exist, a window is not a pair of times or
        overlaps another window, a unit does not suit the role, or the resampling rate is too low.
    """
    if sample_period is not None:
        check_sample_period(sample_period)
    declared = as_declared(axis)
    refuse(
        UsageError,
        (
            columns is not None and not isinstance(columns, Mapping),
            f"the columns are {quoted(columns)}. Give names by role, such as "
            f"{{'position': 'q:mm'}}",
            "columns",
        ),
        (
            repairs is not None and not isinstance(repairs, Repairs),
            f"the repairs are {quoted(repairs)}. Give an object such as "
            "axisid.estimation.Repairs(gaps='split')",
            "repairs",
        ),
    )
    if is_run_file(log):
        # Read the log that the run.toml names, with the arguments that are given or in the file.
        file, arguments = read_run(
            Path(str(log)),
            declared,
            columns=columns or {},
            repairs=repairs or Repairs(),
            sample_period=sample_period,
            injected_at=injected_at,
            windows=windows,
            max_memory=max_memory,
        )
        try:
            return read_record(file, axis, **arguments)
        except UsageError as error:
            no_windows = windows is None or (isinstance(windows, tuple) and not windows)
            given = columns or sample_period or injected_at or max_memory or not no_windows
            if given or repairs not in (None, Repairs()):
                raise  # the cause may be a given argument, not the file
            raise DataError(str(error), code=error.code) from error
    repairs = repairs or Repairs()
    chosen = checked_windows(windows)
    table = read_table(log, drop_tail=repairs.tail is not None, max_memory=max_memory)
    return _record(
        table,
        role_columns(
            table,
            declared,
            column_texts(columns or {}),
            has_period=sample_period is not None,
            injected_at=injected_at,
        ),
        declared,
        sample_period,
        repairs,
        chosen,
        room_for(table.source, max_memory),
    )


def _record(
    table: Table,
    read: RoleColumns,
    axis: Axis | None,
    period: float | None,
    repairs: Repairs,
    windows: tuple[Window, ...],
    room: Room,
) -> Record:
    """Return the record of the columns of a log, with the requested repairs.

    The order of the steps is: times of the columns, interpolation between written values, shifts,
    windows, outliers, jumps by a modulus, clipped samples, and one clock for all columns.

    Parameters
    ----------
    table : Table
        The log.
    read : RoleColumns
        Columns of the log by role, in SI, before any repair.
    axis : Axis or None
    period : float or None
        Given sampling period, s.
    repairs : Repairs
    windows : tuple of (float, float)
        First and last time of each window, s; empty for the whole log.
    room : Room
        Memory that the samples may use.
    """
    # Times of the columns, interpolation, shifts and windows, in this order. If the columns are
    # resampled later (`uneven`), their steps may be uneven and their times may differ.
    counted = "time" not in read.samples and all(s.clock is None for s in read.samples.values())
    uneven, split = repairs.resample is not None, repairs.gaps is not None
    columns = retimed(clocked(table, read, period), period, split=split, uneven=uneven)
    columns = drawn_between(columns, repairs.between, uneven=uneven)
    columns = whole = shifted(columns, repairs.shift, uneven=uneven)
    if windows:
        columns, windows = within(columns, windows)
    room.check_samples(max(len(s.values) for s in columns.samples.values()))
    columns = filled(table, columns, uneven=uneven)
    # Wild samples are replaced before jumps by a modulus are removed.
    gap = (MAX_UNEVEN_STEP if uneven else MAX_EVEN_STEP).value
    moduli = repairs.moduli(axis, columns.scales)
    zeros = leading_zeros_note(columns)
    restarts = {role: modulus.si for role, modulus in moduli.items()}
    if "position" in restarts:
        restarts["reference"] = restarts["position"]
    limit = math.inf if axis is None else axis.drive.limit
    law = None if axis is None else axis.control
    delay = 0 if law is None else law.delay
    searched = unless_faulty(partial(without_wild_samples, columns, restarts, limit, delay))
    unsearched = []
    if isinstance(searched, Missing):
        unsearched = [f"outliers were not searched for: {searched.reason}"]
    else:
        columns = searched
    columns, jumps = unwound(columns, moduli, axis, gap)
    seldom = seldom_notes({r: s for r, s in columns.samples.items() if r not in repairs.between})
    columns, cut = clipped(columns, axis, masked=repairs.mask is not None)
    # One clock for all columns: that of the log, or an even grid.
    signals = () if axis is None else axis.signals
    if repairs.resample is None:
        even = as_sampled(columns, period, windows, split=split)
    else:
        even = resample(
            columns,
            repairs.resample,
            split=split,
            stated=period,
            between={**{s.name: "held" for s in signals if s.is_held}, **repairs.between},
            edges=edges(windows),
        )
    times = even.motion.times
    jitter = step_notes([times[a:b] for a, b in even.segments or ((0, len(times)),)])

    def record(common: RoleColumns, **further: Any) -> Record:
        """Return the record of columns with common times, with further attributes."""
        time, values = common.motion.times, {role: s.values for role, s in common.samples.items()}
        return Record(
            time=time,
            **{role: values[role] for role in values if role in ROLES},  # type: ignore[arg-type]
            signals={name: values[name] for name in values if name not in ROLES},
            injected_at=read.injected_at,
            sample_period=common.period,
            segments=common.segments,
            masked=runs(np.any([np.zeros(len(time), dtype=bool), *common.masks.values()], axis=0)),
            windows=windows,
            provenance=Provenance(
                source=Path(table.source).name,
                sha256=table.sha256,
                given=table.source if table.path else "",
                path=table.path,
                columns={**read.names},
                assumed=read.notes,
                doubts=(*zeros, *unsearched, *jumps, *cut, *seldom, *jitter),
                repairs=common.repairs,
                clock=replace(common.clock, counted=counted),
            ),
            **further,
        )

    # The samples before resampling, which the control law read.
    sampled = None
    if uneven and share_clock(columns):
        with suppress(DataError):  # times too uneven for a record
            sampled = record(as_sampled(columns, None, windows, split=split))
    return record(even, around=whole.samples if windows else {}, sampled=sampled)
