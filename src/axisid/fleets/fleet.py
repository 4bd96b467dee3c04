"""Identify many logs, one by one or in parallel; refuse a mistake common to all logs once."""

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

#: Arguments of `identify` that apply to several records together, so not to a fleet.
OF_SEVERAL = ("local", "known", "gain", "skip_bad")
_LOOKED_AT = 20  # logs that fail for the same reason, before the fleet is refused
#: Codes of errors in the columns, which may be missing in all logs or in some.
_OF_COLUMNS = ("columns", "units", "test-signal", "missing-column")
#: Codes of rows without a failure, or with one that may not recur.
_OTHER_REASONS = ("", "internal", "time", "killed")


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
    """Identify every log separately, and return the results with outliers among the logs.

    Each result is written as ``NAME.json`` as soon as its log is identified, in the form of
    ``axisid identify --json``, and each log has a line in ``fleet.jsonl``. If a log fails, the
    result of an earlier run is kept.

    Parameters
    ----------
    logs : path or iterable of path or FleetItem
        Logs, patterns (``logs/**/*.csv``), folders, manifests (a table with a column ``log``), and
        items.
    axis : Axis, str or Path, optional
        Axis of the logs for which neither a manifest nor an item names one.
    out : str or Path
        Folder of the results.
    jobs : int
        Number of processes. 0 for this process itself: a log that hangs or ends the process then
        stops the fleet.
    executor : Executor, optional
        Executor that is used instead of processes: any of `concurrent.futures`, or Dask's
        ``client.get_executor()``.
    time_limit : float, optional
        Time limit for one log, s; for the first log of an axis in a process, it includes building
        the axis. Not with an executor, whose work cannot be ended.
    resume : bool
        Skip logs that were identified before with the same axis and options.
    prefilter : Prefilter, optional
        As in `identify`; open settings follow from the sampling rate of each log.
    fixed, left_out, drive_time, native
        Known parameters, parameters that are not identified, the drive's time that is estimated,
        and whether compiled code runs: as in `fix`, `leave_out`, `Drive.estimating` and `build`.
    draws : int
        As in `Identification.to_dict`.
    reading : mapping, optional
        Further arguments of `read_record`.
    progress : callable, optional
        Called with the number of logs done, the total, and a text.
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
            f"jobs is {quoted(jobs)}. Give the number of processes, or 0 to use this process alone",
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
            f"separately. Omit {several}",
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
    # Arguments of `identify` and `read_record` that do not exist, or are set by the fleet.
    for function, reserved, given in (
        (identify, {"axis", "record", "prefilter", *OF_SEVERAL}, identifying),
        (read_record, {"log", "axis"}, settings.reading),
    ):
        takes = [name for name in signature(function).parameters if name not in reserved]
        if unknown := [name for name in given if name not in takes]:
            raise UsageError(
                f"{function.__name__} has no argument {quoted(unknown[0])}. Its arguments are "
                f"{', '.join(takes)}.",
                code="fleet",
            )
    requested_methods(settings.identifying.get("methods"))
    if len({item.axis for item in items}) == 1:
        settings.built(items[0])  # refuses a mistake in the axis before any log is read
    ledger = read_ledger(Path(out))
    # Logs that were identified before; their rows are written again if anything in them changed.
    done = dict(_finished(settings, items, ledger)) if resume else {}
    todo = [item for item in items if item.name not in done]
    changed = [row for row in done.values() if row != ledger.last[row.name]]
    made = _work(
        settings,
        todo,
        changed,
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
            f"{ledger.broken}, probably because an earlier run was interrupted. Logs that have no "
            "other line in this file were identified again."
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
    changed: Sequence[FleetRow],
    *,
    trusted: bool,
    **how: Any,
) -> Iterator[FleetRow]:
    """Identify logs, and yield the row of each log after it is written to the ledger.

    Parameters
    ----------
    settings : Settings
    todo : sequence of FleetItem
        Logs to be identified.
    changed : sequence of FleetRow
        Rows of earlier results whose log has another path or description now. They are written
        first.
    trusted : bool
        True if a log was identified with these settings before. Otherwise the settings may be wrong
        for all logs (`checked`).
    **how
        Further arguments of `run_jobs`.
    """
    made = run_jobs(
        partial(identify_log, settings), todo, total=len(todo), said="identifying logs", **how
    )
    folder = Path(settings.folder)
    with closing(made):
        pairs = ((todo[index], _row_of(todo[index], outcome)) for index, outcome in made)
        rows: Iterator[FleetRow]
        if trusted:
            rows = (row for _, row in pairs)
        else:
            rows = checked(pairs, len(todo), partial(result_of, settings))
        if changed:
            write_rows(folder, changed)
        for row in rows:
            write_rows(folder, [row])
            yield row


def _row_of(item: FleetItem, made: FleetRow | Failure) -> FleetRow:
    """Return the row of a log; for a failed job, a row with the reason of the failure."""
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

    The row has the present path, serial number, columns and conditions of the log. A result is used
    even if a later identification failed, for instance because the log could not be read. A log
    whose process was killed or took too long has no key and is not yielded, because it may succeed
    another time.
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
            present = {n: getattr(item, n) for n in ("log", "serial", "columns", "conditions")}
            yield item.name, msgspec.structs.replace(row, **present)


def _is_whole(result: Path) -> bool:
    """Return True if a result file exists and is unchanged since it was written."""
    try:
        members = msgspec.json.decode(result.read_bytes())
        return isinstance(members, dict) and is_unchanged(members)
    except (OSError, msgspec.DecodeError, UnicodeDecodeError):
        return False


def checked(
    rows: Iterator[tuple[FleetItem, FleetRow]], total: int, again: Callable[[FleetItem], object]
) -> Iterator[FleetRow]:
    """Yield rows as they are made; raise an error if all logs fail because of the settings.

    The first rows are delayed while all of them failed for the same reason. As soon as another row
    follows, all rows are yielded unchanged. If the first 20 rows, or all, failed for the same
    reason, the first log is identified again to raise its error.

    Parameters
    ----------
    rows : iterator of (FleetItem, FleetRow)
    total : int
        Total number of rows.
    again : callable
        Function that identifies the log of an item, and so raises its error again.

    Raises
    ------
    UsageError, ModelError, DataError
        The error of the first log.
    """
    delayed: list[tuple[FleetItem, FleetRow]] = []
    for item, row in rows:
        delayed.append((item, row))
        # The reason of a failure, without the name of the log.
        reasons = {
            (
                i.axis,
                i.columns_text,
                r.code,
                r.reason.replace(r.log, "").replace(Path(r.log).name, ""),
            )
            for i, r in delayed
        }
        if len(reasons) > 1 or row.code in _OTHER_REASONS:
            break
        if len(delayed) in (total, _LOOKED_AT):
            every = len(delayed) == total
            try:
                again(delayed[0][0])
            except AxisidError as error:
                kind = next((k for k in (UsageError, ModelError) if isinstance(error, k)), None)
                of_columns = isinstance(error, DataError) and error.code in _OF_COLUMNS
                if of_columns and not every:
                    continue  # a log that follows may have the column
                if kind or of_columns:
                    failed = f"the first {len(delayed)} of {total} logs"
                    if every:
                        failed = f"all {total} logs"
                    message = str(error)
                    if total > 1:
                        message = f"{failed} fail for the same reason: {error}"
                    raise (kind or DataError)(message, code=error.code) from error
            break
    yield from (row for _, row in delayed)
    yield from (row for _, row in rows)
