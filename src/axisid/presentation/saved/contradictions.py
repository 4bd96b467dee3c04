"""What a file may hold by its schema, and a result or the drive of an axis cannot be."""

import math
from collections.abc import Iterator

from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.methods import METHODS
from axisid.modeling.declaration import Axis, CommandPath, Drive
from axisid.presentation.schema import (
    WrittenDriveTime,
    WrittenEstimate,
    WrittenIdentification,
    WrittenResponse,
    plain,
)
from axisid.support.errors import DataError, ModelError, UsageError, quoted
from axisid.support.files import WRITE_AGAIN

from .estimate import (
    written_covariances,
    written_ddm_covariances,
)

_SAME_DEVIATION = 1e-9  # relative, of two deviations that went through a text
_SAME = 1e-6  # relative, of a variance and a deviation: writing and reading change neither
_NOTHING = 1e-300  # a variance whose root squared loses digits


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
            code="result-file",
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
    if spread and not math.isclose(spread, drive.relative_sd, rel_tol=_SAME_DEVIATION):
        yield "relative_sd", f"{spread:g}", f"{drive.relative_sd:g}"


def refuse_contradictions(document: WrittenIdentification, file: str) -> None:
    """Refuse a file whose members do not belong together.

    Raises
    ------
    DataError
    """
    _refuse_unknown(document, file)
    if problem := next(_identified(document), ""):
        raise contradiction(file, problem)


def _refuse_unknown(document: WrittenIdentification, file: str) -> None:
    """Refuse a file of a program that has a covariance more: it may well be whole."""
    for estimate in document.estimates:
        if estimate.chosen_covariance not in COVARIANCES:
            raise DataError(
                f"{file} has intervals by the covariance {quoted(estimate.chosen_covariance)}, "
                f"which this program does not have (it has {', '.join(COVARIANCES)}); "
                "register it as the program did that wrote the file, or identify again.",
                code="result-file",
            )


def contradiction(file: str, problem: str) -> DataError:
    """The refusal of a file, with what is wrong with it and what to do."""
    return DataError(f"{file} contradicts itself: {problem}. {WRITE_AGAIN}", code="result-file")


def _identified(document: WrittenIdentification) -> Iterator[str]:
    """What would be noticed only where something is made of the file."""
    methods = [estimate.method for estimate in document.estimates]
    if document.judged not in methods:
        yield f"there is no {document.judged!r}"
    if len({*methods}) != len(methods):
        yield "it has two estimates of one method"
    for estimate in document.estimates:
        yield from _estimated(estimate)
    if isinstance(drive := document.drive, WrittenResponse):
        try:
            written_drive(drive)
        except ModelError as error:
            yield f"its drive cannot be: {error}"


def _estimated(of: WrittenEstimate) -> Iterator[str]:
    if of.method not in METHODS:
        yield f"there is no method {of.method!r}"
    covariances = written_covariances(of), written_ddm_covariances(of)
    for values, matrices in zip((of.parameters, of.theta_ddm or {}), covariances, strict=True):
        for name, matrix in matrices.items():
            if {len(matrix), *map(len, matrix)} != {len(values)}:
                yield f"the covariance {name} of {of.method} is not of its parameters"
    crossed = of.residual_tests.cross_correlation
    if {*map(len, crossed.columns)} != {len(crossed.lags)}:
        yield f"columns of the residual tests of {of.method} are not of their lags"
