"""The drive of a result's file, and the refusal of an axis whose drive is another."""

import math
from collections.abc import Iterator

from axisid.modeling.declaration import Axis, CommandPath, Drive
from axisid.presentation.schema import (
    WrittenDriveTime,
    WrittenIdentification,
    WrittenResponse,
    plain,
)
from axisid.support.errors import UsageError

_SAME = 1e-9  # relative, of two deviations that went through a text


def written_drive(written: WrittenResponse) -> Drive:
    """A drive of a gain of 1 that follows its commands as a file says; its times are numbers."""
    told = plain(written)
    told.pop("estimated", None)
    return Drive(gain=1.0, **told)


def refuse_other_drive(document: WrittenIdentification, file: str, axis: Axis) -> None:
    """Refuse an axis whose drive differs from the identified one where no code tells them apart.

    Parameters
    ----------
    document : WrittenIdentification
    file : str
    axis : Axis
        As it was given, a time of its drive that is estimated still a parameter.

    Raises
    ------
    UsageError
        It has another lag, delay, place of the recorded control, or deviation of its gain.
    """
    for name, then, now in _differences(document, axis.drive):
        raise UsageError(
            f"{file} was identified with the drive's {name} {then}, but {axis.name!r} as it is "
            f"declared now has {now}; give the axis as it was then, or identify again.",
            code="other-saved-drive",
        )


def _differences(document: WrittenIdentification, drive: Drive) -> Iterator[tuple[str, str, str]]:
    """What differs, as it was and as it is."""
    written = document.drive if isinstance(document.drive, WrittenResponse) else None
    then = Drive(gain=1.0) if written is None else written_drive(written)
    found = None if written is None else written.estimated
    if isinstance(found, WrittenDriveTime):
        start = float(getattr(drive, found.of))
        if start not in (found.nominal, found.value):
            yield found.of, f"estimated from {found.nominal:g}", f"{start:g}"
        drive = drive.with_time(found.of, found.value)
    elif drive.estimated is not None:
        name = drive.estimated[0]
        yield name, f"{getattr(then, name):g}", "it to be estimated"
    for name in ("lag", "delay", "logged", *CommandPath.__dataclass_fields__):
        old, new = getattr(then, name), getattr(drive, name)
        if old != new:
            yield name, str(old), str(new)
    spread = document.estimates[0].gain_relative_sd  # 0 too where the force was measured
    if spread and not math.isclose(spread, drive.relative_sd, rel_tol=_SAME):
        yield "relative_sd", f"{spread:g}", f"{drive.relative_sd:g}"
