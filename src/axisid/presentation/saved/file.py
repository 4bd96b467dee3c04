"""An identification as a file has it: read, checked, and joined with its axis."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar, overload

from axisid.codegen.artefacts import signature
from axisid.modeling.declaration import Axis, fix, leave_out
from axisid.modeling.derivation import AxisModel, derive
from axisid.modeling.library import LIBRARY
from axisid.modeling.text import load_axis
from axisid.presentation.schema import (
    WrittenDriveTime,
    WrittenFitValidation,
    WrittenIdentification,
    WrittenKnown,
    WrittenMonteCarlo,
    WrittenOutputFit,
    WrittenResponse,
    read_document,
    schema_of,
)
from axisid.support.errors import AxisidError, DataError, UsageError, quoted
from axisid.support.files import AS_WRITTEN, WRITE_AGAIN

from .contradictions import contradiction, refuse_contradictions, refuse_other_drive
from .identification import SavedIdentification
from .output_fit import SavedFitValidation, SavedMonteCarlo, SavedOutputFit, read_output_fit

T = TypeVar("T")

_REFUSED = {
    "axisid.stream/1": (
        "is of a log that was read in blocks, and such results are no longer read; "
        "identify the log again, by windows cut out of it if it is too large (window "
        "FROM..TO and window FROM..TO)."
    ),
    schema_of(WrittenOutputFit): (
        "is of a fit of an output, which has one estimate and no method; read it with "
        "load_result, or give a result of identify."
    ),
}


def read_identification(file: str | Path) -> SavedIdentification:
    """Read a file without its axis, and refuse what its schema allows and a result cannot be.

    Raises
    ------
    UsageError
        It is no file's name.
    DataError
        The file cannot be read, or is no whole result.
    """
    path = _path(file)
    return _checked(path, read_document(path, WrittenIdentification, refused=_REFUSED))


def _path(file: object) -> Path:
    if not isinstance(file, (str, Path)):
        raise UsageError(
            f"the result is {quoted(file)}; give the file of a result of identify, {AS_WRITTEN}.",
            code="result-file",
        )
    return Path(file)


def _checked(file: Path, document: WrittenIdentification) -> SavedIdentification:
    """Refuse what does not belong together, and what cannot be computed from."""
    refuse_contradictions(document, str(file))
    saved = _told(str(file), lambda: SavedIdentification.of(str(file), document))
    _told(str(file), lambda: saved.summary(full=True))
    return saved


def _told(file: str, tell: Callable[[], T]) -> T:
    """Refuse figures that a file may have by its schema, and of which no page can be made.

    Raises
    ------
    DataError
    """
    try:
        return tell()
    except AxisidError as error:
        raise contradiction(file, str(error).removesuffix(".")) from error
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        kind = type(error).__name__
        raise contradiction(file, f"no summary can be made of it ({kind}: {error})") from error


@overload
def load_result(
    path: SavedIdentification, axis: Axis | str | Path | None = None
) -> SavedIdentification: ...


@overload
def load_result(
    path: str | Path, axis: Axis | str | Path | None = None
) -> SavedIdentification | SavedOutputFit | SavedMonteCarlo | SavedFitValidation: ...


def load_result(
    path: str | Path | SavedIdentification, axis: Axis | str | Path | None = None
) -> SavedIdentification | SavedOutputFit | SavedMonteCarlo | SavedFitValidation:
    """Read an identification, a fit, a study or a validation of a fit that was written as JSON.

    Parameters
    ----------
    path : str or Path
        What ``axisid identify --json``, ``axisid fit --json``, ``axisid study --json`` or
        ``axisid fleet`` wrote, or ``result.to_dict()`` as JSON.
    axis : Axis, str or Path, optional
        The axis that was identified, or what `load_axis` takes. An axis of the library is found by
        itself; of another one the estimates can be read without it, but not be exported or held
        against another record.

    Returns
    -------
    SavedIdentification, SavedOutputFit, SavedMonteCarlo or SavedFitValidation
        With the estimates by method, their covariances, the verdict, and what is made of them:
        ``derive``, ``summary``, ``plot`` and `export`. Of a fit its parameters with their
        covariance, the verdict and ``summary``; of a study its figures; of a validation what is
        left, and its checks.

    Raises
    ------
    DataError
        The file cannot be read, or is no whole result.
    UsageError
        The axis is not the one that was identified.
    """
    if isinstance(path, SavedIdentification):
        return path if axis is None else _joined(path, axis)
    file = _path(path)
    document = read_document(
        file,
        WrittenIdentification,
        WrittenOutputFit,
        WrittenMonteCarlo,
        WrittenFitValidation,
        refused=_REFUSED,
    )
    saved: SavedOutputFit | SavedMonteCarlo | SavedFitValidation
    match document:
        case WrittenIdentification():
            return _joined(_checked(file, document), axis)
        case WrittenOutputFit():
            saved = read_output_fit(str(file), document)
        case WrittenMonteCarlo():
            saved = SavedMonteCarlo(file=str(file), document=document)
        case WrittenFitValidation():
            saved = SavedFitValidation.of(str(file), document)
    _told(str(file), saved.summary)
    return saved


def _joined(saved: SavedIdentification, axis: Axis | str | Path | None) -> SavedIdentification:
    model = joined_model(saved.document, saved.file, axis)
    return replace(saved, declared=None if model is None else model.base.declared)


def joined_model(
    document: WrittenIdentification, file: str, given: Axis | str | Path | None
) -> AxisModel | None:
    """Derive the axis that a file is of: the one that is given, or the library's of its name.

    Returns
    -------
    AxisModel or None
        None where no axis is given and the library has not the one that was identified.

    Raises
    ------
    UsageError
        The axis that is given is not the one that was identified.
    DataError
        The file's parameters are not those of its axis.
    """
    if given is None and document.axis not in LIBRARY:
        return None
    source = document.axis if given is None else given
    axis = source if isinstance(source, Axis) else load_axis(source)
    model = derive(_as_identified(document, axis))
    made = signature(model)
    if made == document.signature:
        _check_parameters(document, file, model)
        _check_fixed(document, file, model)
        if given is not None:
            refuse_other_drive(document, file, axis)
        return model
    if given is None:
        return None
    whose = "" if document.axis == axis.name else f" of the axis {document.axis!r}"
    raise UsageError(
        f"{file} was identified with the generated code {document.signature[:12]}{whose}, but "
        f"{axis.name!r} as it is declared now has {made[:12]}; give the axis as it was then, or "
        "identify again.",
        code="result-file",
    )


def _as_identified(document: WrittenIdentification, axis: Axis) -> Axis:
    """The axis without what was left out, and with what was fixed where it fixes nothing itself.

    A time of its drive that was estimated is what was found.
    """
    drive = document.drive
    if isinstance(drive, WrittenResponse) and isinstance(drive.estimated, WrittenDriveTime):
        found = drive.estimated
        axis = replace(axis, drive=axis.drive.with_time(found.of, found.value))
    left = leave_out(axis, **(document.left_out or {}))
    free = {p.name for p in left.parameters if p.known is None}
    fixed = {n: (v.value, v.sd) for n, v in _fixed(document).items() if n in free}
    return fix(left, **fixed)


def _fixed(document: WrittenIdentification) -> Mapping[str, WrittenKnown]:
    """What was declared as known, by name."""
    if not document.estimates[0].physical:
        return {}
    return document.estimates[0].physical.fixed


def has_own_parameters(document: WrittenIdentification) -> bool:
    """Whether records have parameters of their own, or something is known of each."""
    return bool(document.local) or any(member.known for member in document.records or ())


def _check_fixed(document: WrittenIdentification, file: str, model: AxisModel) -> None:
    """Refuse an axis with other fixed values than those that the physical parameters are from."""
    then, now = _fixed(document), {p.name: p for p in model.base.known}
    for name in dict.fromkeys([*then, *now]):
        old, new = then.get(name), now.get(name)
        if old is None or new is None or (old.value, old.sd) != (new.known, new.known_sd):
            said = "free" if old is None else _known(old.value, old.sd)
            is_now = "free" if new is None else _known(new.known, new.known_sd)
            raise UsageError(
                f"{file} was identified with {name} {said}, but {model.axis.name!r} as it is "
                f"declared now has it {is_now}; give the axis as it was then, or identify again.",
                code="result-file",
            )


def _known(value: float | None, sd: float) -> str:
    return f"fixed at {value!r}" + (f" +- {sd!r}" if sd else "")


def _check_parameters(document: WrittenIdentification, file: str, model: AxisModel) -> None:
    if has_own_parameters(document):
        return
    wanted = sorted(p.name for p in model.axis.parameters)
    if any(sorted(estimate.parameters) != wanted for estimate in document.estimates):
        raise DataError(f"{file} lacks parameters of the axis {model.axis.name!r}. {WRITE_AGAIN}")
