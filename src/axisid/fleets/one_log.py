"""Read and identify one log of a fleet, in any process."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from time import process_time
from typing import Any

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.identification import Identification, identify
from axisid.estimation.records import log_of, read_record
from axisid.estimation.signals import Prefilter
from axisid.estimation.verdict_checks import by_weight
from axisid.modeling.declaration import Axis, fix, leave_out
from axisid.modeling.parsing import load_axis
from axisid.support.errors import AxisidError, DataError, UsageError
from axisid.support.files import axis_file, digest_of, json_text, read_regular, stamps, write_file
from axisid.support.settings import settings_in_python
from axisid.support.version import __version__

from .items import FleetItem
from .ledger import FleetRow, fleet_value


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings that all logs of a fleet share; small, because they are sent with every job.

    Attributes
    ----------
    folder : str
        Folder to which results are written.
    axis : str or Axis
        Axis of the logs whose item names no axis; empty if every item names one.
    fixed : mapping of str to value
        Known values of parameters, as the arguments of `fix`.
    left_out : tuple of str
        Parameters that are not identified.
    drive_time : str
        The drive's time that is estimated, ``lag`` or ``delay``; empty for none.
    native : bool
        Whether compiled code may run.
    reading : mapping of str to value
        Arguments of `read_record`.
    prefilter : Prefilter or None
        Prefilter; None for the default that follows from each log.
    identifying : mapping of str to value
        Further arguments of `identify`.
    draws : int
        Number of draws from the distribution of each estimate that a result file contains.
    """

    folder: str
    axis: str | Axis = ""
    fixed: Mapping[str, Any] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    drive_time: str = ""
    native: bool = True
    reading: Mapping[str, Any] = field(default_factory=dict)
    prefilter: Prefilter | None = None
    identifying: Mapping[str, Any] = field(default_factory=dict)
    draws: int = 0

    def key(self, item: FleetItem, log: str) -> str:
        """Return the SHA-256, as hexadecimal text, of everything on which a log's result depends.

        Parameters
        ----------
        item : FleetItem
        log : str
            Hash of the log's bytes.
        """
        generated, declared = self.built(item)
        contents = (
            __version__,
            log,
            generated.signature,
            declared,
            self.native,
            sorted(self.reading_of(item).items()),
            self.prefilter,
            sorted(self.identifying.items()),
            self.draws,
        )
        return _digest(repr(contents))

    def reading_of(self, item: FleetItem) -> dict[str, Any]:
        """Return the arguments of `read_record` for the log of an item."""
        return {**self.reading, **({"columns": item.columns} if item.columns else {})}

    def built(self, item: FleetItem) -> tuple[GeneratedAxis, str]:
        """Return the generated axis of a log, built once per process, and its declaration's digest.

        Raises
        ------
        ModelError, UsageError
            No axis is named, or it cannot be built.
        DataError
            No axis is named and the log does not exist.
        """
        axis = item.axis or self.axis
        if not axis and not Path(item.log).exists():  # most often a mistyped name in a manifest
            raise DataError(
                f"{item.log} cannot be read: there is no such file. Check the path, and name an "
                "axis with --axis (axis=).",
                code="log-file",
            )
        if not axis:
            raise UsageError(
                f"no axis is named for {item.log}. Name one axis for all logs with --axis (axis=), "
                "or one for each log in a manifest.",
                code="fleet",
            )
        identity = _canonical(axis) if isinstance(axis, Axis) else _name_and_digest(axis)
        changes = (sorted(self.fixed.items()), self.left_out, self.drive_time, self.native)
        key = (identity, repr(changes))
        if key not in _BUILT:
            if len(_BUILT) == _MOST_BUILT:
                _BUILT.pop(next(iter(_BUILT)))
            axis = fix(axis if isinstance(axis, Axis) else load_axis(axis), **self.fixed)
            if self.drive_time:
                axis = replace(axis, drive=axis.drive.estimating(self.drive_time))
            axis = leave_out(axis, *self.left_out)
            _BUILT[key] = build(axis, native=self.native), _digest(_canonical(axis))
        return _BUILT[key]


#: Axes that this process has built, with the digest of the declaration, by axis and settings.
_BUILT: dict[tuple[str, str], tuple[GeneratedAxis, str]] = {}
_MOST_BUILT = 32


def _name_and_digest(name: str) -> str:
    """Return the name of an axis and the digest of its file, which may change during a run.

    An axis of the library, or a file that cannot be read, has no digest.
    """
    file, _ = axis_file(name)
    if file.suffix not in (".py", ".toml"):
        return name  # an axis of the library
    try:
        return f"{name}\0{hashlib.sha256(read_regular(file)).hexdigest()}"
    except (OSError, ValueError):
        return name  # `load_axis` reports the mistake


def _canonical(axis: Axis) -> str:
    """Return all fields of an axis as text, including gains and nominal values."""
    return repr([(each.name, getattr(axis, each.name)) for each in fields(axis)])


def _digest(text: str) -> str:
    """Return the SHA-256 of a text, as hexadecimal text."""
    return hashlib.sha256(text.encode(errors="replace")).hexdigest()


def log_digest(log: Path) -> str:
    """Return the SHA-256 of the bytes of a log, as hexadecimal text.

    For a folder these are the bytes of all its files, for a run.toml of the file and its log.

    Raises
    ------
    OSError
        The log cannot be read.
    """
    chain = [log]
    while (named := log_of(chain[-1])) not in chain:
        chain.append(named)
    return digest_of([file for each in chain for file in stamps(each)])


def row_for(item: FleetItem, **what: Any) -> FleetRow:
    """Return the row of an item, with further fields of `FleetRow` such as the status.

    A field in `what` replaces the same field of the item.
    """
    of_item = {name: getattr(item, name) for name in FleetItem.__slots__}
    return FleetRow(**{**of_item, **what})


def result_file(folder: str | Path, name: str) -> Path:
    """Return the path of the result file in a folder, by the name of the result."""
    return Path(folder, f"{name}.json")


@settings_in_python()
def identify_log(settings: Settings, item: FleetItem) -> FleetRow:
    """Identify an axis from one log, write the result file, and return the row of the log.

    An error of the log or the options gives a row with the status ``failed``. Other errors, which
    are faults of the program, are raised.
    """
    begin = process_time()
    key, axis = "", item.axis or str(getattr(settings.axis, "name", settings.axis))
    try:
        axis = settings.built(item)[0].axis.name
        try:
            key = settings.key(item, log_digest(Path(item.log)))
        except OSError as error:
            raise DataError(
                f"{error.filename or item.log} cannot be read: {error.strerror}. Check the path.",
                code="log-file",
            ) from error
        result = result_of(settings, item)
        write_file(
            result_file(settings.folder, item.name), json_text(result.to_dict(settings.draws))
        )
    except AxisidError as error:
        return row_for(
            item,
            axis=axis,
            status="failed",
            reason=" ".join(str(error).split()),
            code=error.code,
            key="" if error.code == "file" else key,  # the file may be writable another time
            seconds=process_time() - begin,
        )
    estimate = result.preferred
    # Sentence of each failed check, the most severe first, and of each check not evaluated.
    failing = {c.name: c.meaning for c in by_weight(result.verdict) if c.status == "fail"}
    unchecked = {c.name: c.meaning for c in result.verdict if c.leaves_open}
    return row_for(
        item,
        axis=axis,
        status="ok",
        key=key,
        signature=result.axis.signature,
        method=estimate.method,
        parameters={name: fleet_value(value) for name, value in estimate.parameters.items()},
        covariance=tuple(map(tuple, estimate.covariance.tolist())),
        failing=tuple(failing),
        unchecked=tuple(unchecked),
        doubt=next(iter((failing or unchecked).values()), ""),
        seconds=process_time() - begin,
    )


def result_of(settings: Settings, item: FleetItem) -> Identification:
    """Return the identification from the log of an item.

    Raises
    ------
    AxisidError
        Errors of `read_record` and `identify`.
    """
    generated, _ = settings.built(item)
    return identify(
        generated,
        read_record(item.log, generated, **settings.reading_of(item)),
        settings.prefilter,
        **settings.identifying,
        judge=False,  # the checks are evaluated when the result file is written
    )
