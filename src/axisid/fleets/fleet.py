"""Many logs identified one by one or in parallel; a mistake common to all logs is refused once."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

import msgspec

from axisid.codegen.generated_axes import as_declared
from axisid.estimation.identification import identify, requested_methods
from axisid.estimation.records import log_of, read_record
from axisid.estimation.signals import Prefilter
from axisid.modeling.declaration import Axis
from axisid.support.checks import by_name, is_real, is_whole, listed, refuse
from axisid.support.errors import AxisidError, DataError, ModelError, UsageError
from axisid.support.files import is_unchanged
from axisid.support.jobs import Failure, run_jobs
from axisid.support.progress import Progress
from axisid.support.wording import first_of, quoted

from .items import FleetItem, gather_items
from .ledger import LEDGER, FleetRow, Ledger, read_ledger, write_rows
from .one_log import Settings, identify_log, log_digest, result_file, result_of, row_for
from .result import TABLES, Fleet

#: Arguments of `identify` that apply to several records together.
OF_SEVERAL = ("local", "known", "gain", "skip_bad")
_LOOKED_AT = 20  # logs that fail alike, before the others are given up
_OF_COLUMNS = ("columns", "units", "test-signal", "missing-column")
_UNTOLD = ("", "internal", "time", "killed")  # codes of failures that may not recur at another time


def fleet(
    logs: str | Path | Iterable[str | Path | FleetItem],
    axis: Axis | str | Path | None = None,
    out: str | Path = "results",
    *,
    jobs: int = 1,
    executor: Executor | None = None,
    time_limit: float | None = None,
    resume: bool = False,
    prefilter: Prefilter | None = None,
    fixed: Mapping[str, Any] | None = None,
    left_out: Sequence[str] = (),
    drive_time: str | None = None,
    native: bool = True,
    draws: int = 0,
    reading: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    **identifying: Any,
) -> Fleet:
    """Identify every log separately, and find the axes that stand out.

    Each result is written as ``NAME.json`` as soon as it is there, the same as ``axisid identify
    --json`` writes, and each log has a line in ``fleet.jsonl``. A log that fails does not change
    the result of an earlier run.

    Parameters
    ----------
    logs : path or iterable of path or FleetItem
        Logs, patterns (``logs/**/*.csv``), folders, manifests (a table with a column ``log``), and
        items.
    axis : Axis, str or Path, optional
        Axis of the logs for which nothing else names one.
    out : str or Path
        Folder of the results.
    jobs : int
        Processes; 0 for this one, in which a log that hangs or ends the process is not shielded.
    executor : Executor, optional
        Used instead of processes: any of `concurrent.futures`, or Dask's ``client.get_executor()``.
    time_limit : float, optional
        Seconds for one log; for a process's first log of an axis, this includes building the axis.
        Not with an executor, whose work cannot be ended.
    resume : bool
        Skip logs that were identified before with the same axis and options.
    prefilter : Prefilter, optional
        As in `identify`; open settings follow the rate of each log.
    fixed, left_out, drive_time, native
        Known parameters, parameters that are not identified, the drive's time that is estimated,
        and whether compiled code runs: as in `fix`, `leave_out`, `Drive.estimating` and `build`.
    draws : int
        As in `Identification.to_dict`.
    reading : mapping, optional
        Arguments of `read_record`.
    progress : callable, optional
        Called with the number done, the total, and a text.
    **identifying
        Further arguments of `identify` that apply to one record: ``methods``, ``covariance``, ...

    Returns
    -------
    Fleet

    Raises
    ------
    UsageError
        There is no log, an option is wrong for every log, or a result would replace its log.
    ModelError, DataError
        The axis of all logs is wrong, or all logs lack a column; a failure of one log is in its
        row.
    """
    several = ", ".join(sorted({*OF_SEVERAL} & identifying.keys()))
    is_time = time_limit is None or (is_real(time_limit) and 0 < time_limit < math.inf)
    refuse(
        UsageError,
        (
            not (is_whole(jobs) and jobs >= 0),
            f"jobs is {quoted(jobs)}. Give a whole number of processes; 0 uses this process alone",
        ),
        (
            not is_time,
            f"the time limit is {quoted(time_limit)}. Give a positive number of seconds",
        ),
        (
            time_limit is not None and executor is not None,
            "a time limit and an executor cannot be combined, because the limit ends axisid's own "
            "processes. Omit one of the two",
        ),
        (
            several,
            f"{several} applies to several records together, but a fleet identifies each log "
            "separately. Omit it",
        ),
        code="fleet",
    )
    items = gather_items(logs, Path(out))
    _keep_logs(items, out)
    settings = Settings(
        folder=str(out),
        axis=str(axis or "") if isinstance(axis, (str, Path)) else as_declared(axis) or "",
        fixed=dict(by_name(fixed, "fixed values")),
        left_out=listed(left_out),
        drive_time=drive_time or "",
        native=native,
        reading=dict(by_name(reading, "arguments of reading")),
        prefilter=prefilter,
        identifying=identifying,
        draws=draws,
    )
    for function, own, given in (
        (identify, {"axis", "record", "prefilter", *OF_SEVERAL}, identifying),
        (read_record, {"log", "axis"}, settings.reading),
    ):
        takes = [name for name in signature(function).parameters if name not in own]
        if unknown := [name for name in given if name not in takes]:
            raise UsageError(
                f"{function.__name__} has no argument {quoted(unknown[0])}. Its arguments are "
                f"{', '.join(takes)}.",
                code="fleet",
            )
    requested_methods(settings.identifying.get("methods"))
    if len({item.axis for item in items}) == 1:
        settings.built(items[0])  # a mistake in the axis of all logs is refused at once
    ledger = read_ledger(Path(out))
    done = dict(_finished(settings, items, ledger)) if resume else {}
    todo = [item for item in items if item.name not in done]
    moved = [row for row in done.values() if row != ledger.last[row.name]]
    made = _work(
        settings,
        todo,
        moved,
        trusted=any(row.has_result for row in done.values()),
        progress=progress,
        jobs=jobs,
        executor=executor,
        limit=time_limit,
    )
    rows = {
        name: msgspec.structs.replace(row, status="skipped") if row.has_result else row
        for name, row in done.items()
    } | {row.name: row for row in made}
    notes = []
    if resume and ledger.broken:
        notes.append(
            f"{ledger.broken}, probably because an earlier run was interrupted. Logs without "
            "another line were identified again."
        )
    failed = [name for name, row in rows.items() if not row.has_result and name in ledger.results]
    if kept := [name for name in failed if result_file(out, name).exists()]:
        of = "1 log that failed is" if len(kept) == 1 else f"{len(kept)} logs that failed are"
        notes.append(
            f"The earlier results of {of} kept: {first_of(kept)}. Once the logs can be "
            "identified, run the fleet again with resume (--resume)."
        )
    return Fleet(folder=str(out), rows=tuple(rows[item.name] for item in items), notes=tuple(notes))


def _keep_logs(items: Sequence[FleetItem], out: str | Path) -> None:
    """Refuse a folder in which a result would replace its log."""
    for item in items:
        result = result_file(out, item.name)
        logs = [Path(item.log), log_of(item.log)]
        if result.exists() and any(log.exists() and log.samefile(result) for log in logs):
            raise UsageError(
                f"the result of {item.log} would replace the log. Choose another folder for the "
                "results with out= (--output).",
                code="fleet",
            )


def written_files(items: Sequence[FleetItem]) -> dict[str, str]:
    """Return the files that a fleet writes into its folder, with the kind of each."""
    return {
        LEDGER: "fleet",
        **dict.fromkeys(TABLES, "fleet-table"),
        **{f"{item.name}.json": "identify" for item in items},
    }


def _work(
    settings: Settings,
    todo: Sequence[FleetItem],
    moved: Sequence[FleetRow],
    *,
    trusted: bool,
    **how: Any,
) -> Iterator[FleetRow]:
    """Yield the row of each log when it is done, already written to the ledger.

    Parameters
    ----------
    settings : Settings
    todo : sequence of FleetItem
        Logs to be identified.
    moved : sequence of FleetRow
        Rows of earlier results whose log is now named differently, which are written first.
    trusted : bool
        Whether a log was identified with these settings before, so that they are not wrong for all.
    **how
        Further arguments of `run_jobs`.
    """
    made = run_jobs(
        partial(identify_log, settings), todo, total=len(todo), said="identifying logs", **how
    )
    folder = Path(settings.folder)
    with closing(made):
        told = ((todo[place], _row_of(todo[place], found)) for place, found in made)
        rows = (
            (row for _, row in told)
            if trusted
            else checked(told, len(todo), partial(result_of, settings))
        )
        if moved:
            write_rows(folder, moved)
        for row in rows:  # a refused log has none, and is removed from the ledger
            write_rows(folder, [row])
            yield row


def _row_of(item: FleetItem, made: FleetRow | Failure) -> FleetRow:
    """Return the row of a log; a job that failed gives a row with the reason."""
    if not isinstance(made, Failure):
        return made
    return row_for(
        item,
        status="failed",
        reason=f"{made.reason}.",
        code="internal" if made.kind == "error" else made.kind,
    )


def _finished(
    settings: Settings, items: Sequence[FleetItem], ledger: Ledger
) -> Iterator[tuple[str, FleetRow]]:
    """Yield name and row of each log that was identified before with equal axis and options.

    A result counts even if a later try failed, for instance because the log could not be read. A
    log whose process was killed or took too long has no key, because it may succeed another time.
    """
    for item in items:
        try:
            key = settings.key(item, log_digest(Path(item.log)))
        except (AxisidError, OSError):
            continue
        rows = (ledger.results.get(item.name), ledger.last.get(item.name))
        same = [row for row in rows if row is not None and row.key == key]
        if not same:
            continue
        row = same[0]
        if not row.has_result or _is_whole(result_file(settings.folder, row.name)):
            said = {n: getattr(item, n) for n in ("log", "serial", "columns", "conditions")}
            yield item.name, msgspec.structs.replace(row, **said)


def _is_whole(result: Path) -> bool:
    """Return whether a result file exists and is unchanged since it was written."""
    try:
        members = msgspec.json.decode(result.read_bytes())
        return isinstance(members, dict) and is_unchanged(members)
    except (OSError, msgspec.DecodeError, UnicodeDecodeError):
        return False


def checked(
    rows: Iterator[tuple[FleetItem, FleetRow]], total: int, again: Callable[[FleetItem], object]
) -> Iterator[FleetRow]:
    """Yield rows as they are made, unless all logs fail for a reason in the settings.

    The first rows are held back as long as each fails for the same reason. If other rows follow,
    all rows are yielded unchanged. If the first 20 rows, or all, fail in this way, the first log is
    tried again to raise its error.

    Parameters
    ----------
    rows : iterator of (FleetItem, FleetRow)
    total : int
        Total number of rows.
    again : callable
        Reads and identifies a log, to raise its error.

    Raises
    ------
    UsageError, ModelError, DataError
        The error of the first log.
    """
    held: list[tuple[FleetItem, FleetRow]] = []
    for item, row in rows:
        held.append((item, row))
        said = {
            (
                i.axis,
                i.columns_text,
                r.code,
                r.reason.replace(r.log, "").replace(Path(r.log).name, ""),
            )
            for i, r in held
        }
        if len(said) > 1 or row.code in _UNTOLD:
            break
        if len(held) in (total, _LOOKED_AT):
            every = len(held) == total
            try:
                again(held[0][0])
            except AxisidError as error:
                kind = next((k for k in (UsageError, ModelError) if isinstance(error, k)), None)
                of_columns = isinstance(error, DataError) and error.code in _OF_COLUMNS
                if of_columns and not every:
                    continue  # logs that follow may have the column: only all of them show it
                if kind or of_columns:
                    of = f"all {total} logs" if every else f"the first {len(held)} of {total} logs"
                    told = f"{of} fail for the same reason: {error}" if total > 1 else str(error)
                    raise (kind or DataError)(told, code=error.code) from error
            break
    yield from (row for _, row in held)
    yield from (row for _, row in rows)
