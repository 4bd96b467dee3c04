"""What is wrong with all logs of a fleet alike: it is refused once, and no log is told to fail."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from inspect import Parameter, signature
from pathlib import Path

from axisid.estimation.identification import check_choices, identify, requested_methods
from axisid.estimation.records import read_record
from axisid.fleets.items import FleetItem
from axisid.support.errors import AxisidError, DataError, ModelError, UsageError
from axisid.support.user_values import quoted

from .ledger import FleetRow
from .one_log import Settings

#: Arguments of `identify` that are of several records together.
OF_SEVERAL = ("local", "known", "gain", "skip_bad")
_LOOKED_AT = 20  # logs that fail alike by what no log changes, before the others are given up
_OF_COLUMNS = ("no-column", "unknown-unit", "other-unit", "column-twice", "no-injected", "no-force")
_CHOICES = {"covariance", "start", "loss"}  # of `identify`, which have nothing to do with a log
_UNTOLD = ("", "internal", "time", "killed")  # codes of what may be otherwise another time


def check_settings(settings: Settings, items: Sequence[FleetItem]) -> None:
    """Refuse what no log can be identified with, before any is begun.

    Raises
    ------
    UsageError
        An argument is not known, or has no such choice; or no log has an axis.
    ModelError
        The axis of all logs cannot be built.
    """
    _check_names(identify, settings.identifying)
    _check_names(read_record, settings.reading, taken=("log", "axis"))
    chosen = {name: settings.identifying[name] for name in _CHOICES & settings.identifying.keys()}
    check_choices(**{**{name: _default(name) for name in _CHOICES}, **chosen})
    requested_methods(settings.identifying.get("methods"))
    if len({item.axis for item in items}) == 1:
        settings.generated(items[0])


def _default(name: str) -> object:
    return signature(identify).parameters[name].default


def _check_names(
    function: Callable[..., object],
    given: Mapping[str, object],
    taken: Sequence[str] = ("axis", "record", "prefilter", *OF_SEVERAL),
) -> None:
    known = [
        name
        for name, each in signature(function).parameters.items()
        if each.kind is not Parameter.VAR_KEYWORD and name not in taken
    ]
    if unknown := [name for name in given if name not in known]:
        raise UsageError(
            f"{function.__name__} takes no {quoted(unknown[0])}; it takes {', '.join(known)}.",
            code="fleet-argument",
        )


def checked(
    rows: Iterator[tuple[FleetItem, FleetRow]], total: int, again: Callable[[FleetItem], object]
) -> Iterator[FleetRow]:
    """Rows as they are made, unless all fail by what was asked of them.

    The first are held back while each fails as the one before; the others of a log or two that are
    bad are given as they are.

    Parameters
    ----------
    rows : iterator of (FleetItem, FleetRow)
    total : int
        How many there will be.
    again : callable
        Reads and identifies a log, to raise what is wrong.

    Raises
    ------
    UsageError, ModelError, DataError
        As the first log did.
    """
    held: list[tuple[FleetItem, FleetRow]] = []
    for item, row in rows:
        held.append((item, row))
        if not _are_alike(held):
            break
        if len(held) in (total, _LOOKED_AT) and not _is_open(held, total, again):
            break
    yield from (row for _, row in held)
    yield from (row for _, row in rows)


def _are_alike(held: Sequence[tuple[FleetItem, FleetRow]]) -> bool:
    """Whether logs that are said to be alike failed alike."""
    said = {(item.axis, tuple(item.columns.items()), row.code, _reason(row)) for item, row in held}
    return len(said) == 1 and held[0][1].code not in _UNTOLD


def _reason(row: FleetRow) -> str:
    """Why a log failed, without its name."""
    return row.reason.replace(row.log, "").replace(Path(row.log).name, "")


def _is_open(
    held: Sequence[tuple[FleetItem, FleetRow]], total: int, again: Callable[[FleetItem], object]
) -> bool:
    """Whether all logs may yet fail alike by their columns; raises what is wrong with any log.

    Logs that follow may have a column that the first ones lack: only all of them tell.
    """
    try:
        again(held[0][0])
    except AxisidError as error:
        kind = next((k for k in (UsageError, ModelError, DataError) if isinstance(error, k)), None)
        if kind is None or (kind is DataError and error.code not in _OF_COLUMNS):
            return False
        if kind is DataError and len(held) < total:
            return True
        of = f"all {total} logs" if len(held) == total else f"the first {len(held)} of {total} logs"
        lead = f"{of} fail alike: " if total > 1 else ""
        raise kind(f"{lead}{error.problem}", error.remedy, code=error.code) from error
    return False
