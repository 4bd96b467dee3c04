"""Result files: read, checked against their schema, and joined with the identified axis."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar, overload

import msgspec

from axisid.codegen.generated_axes import signature
from axisid.estimation.estimates import COVARIANCES, Value
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import Axis, CommandPath, Drive, fix, leave_out
from axisid.modeling.derivation import AxisModel, derive
from axisid.modeling.library import LIBRARY
from axisid.modeling.parsing import load_axis
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import from_json
from axisid.support.errors import AxisidError, DataError, UsageError
from axisid.support.files import GIVE_RESULT, WRITE_AGAIN, is_unchanged, read_result
from axisid.support.wording import quoted

from .identification import SavedIdentification, WrittenIdentification
from .json_objects import JsonObject, WrittenKnown, schema_of
from .output_fit import (
    SavedFitValidation,
    SavedOutputFit,
    WrittenOutputFit,
)
from .studies import SavedMonteCarlo

T = TypeVar("T")
Expected = TypeVar("Expected", bound=JsonObject)
_SHOWN = 40  # letters of an unknown schema in a message


#: Ends of the messages for documents that are not accepted, by their `schema_of`.
_REFUSED = {
    "axisid.stream/1": (
        "is the result of a log that was read in blocks. Such results are no longer supported. "
        "Identify the log again. If the log is too large, use windows (--window FROM..TO)."
    ),
    schema_of(WrittenOutputFit): (
        "is a fit of an output, which has one estimate and no method. Read it with load_result, or "
        "give a result of identify."
    ),
}


def read_document(file: Path, *expected: type[Expected]) -> Expected:
    """Return the document of a result file, after a check against the schema of its kind.

    Parameters
    ----------
    file : Path
    *expected : type of JsonObject
        Accepted kinds of documents.

    Raises
    ------
    DataError
        The file cannot be read, is not JSON, was changed after it was written, is another document,
        or does not match its schema.
    """
    content = read_result(file)
    found, documents = _schema(file, content), {schema_of(each): each for each in expected}
    if found in documents:
        try:
            return msgspec.json.decode(content, type=documents[found], dec_hook=from_json)
        except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
            raise DataError(
                f"{file} does not match its schema: {_decoder_message(error)}. {WRITE_AGAIN}",
                code="result-file",
            ) from error
    if found in _REFUSED:
        raise DataError(f"{file} {_REFUSED[found]}", code="result-file")
    schema = f"its schema is {found[:_SHOWN]!r}" if found else "it has no schema"
    raise DataError(
        f"{file} is not the result of one identification ({schema}; expected is "
        f"{schema_of(expected[0])!r}). {GIVE_RESULT}"
    )


def _schema(file: Path, content: bytes) -> str:
    """Return the name of the schema in a file's content; empty without one.

    Raises
    ------
    DataError
        The content is not JSON, or was changed after it was written.
    """
    try:
        found = msgspec.json.decode(content)
        members = found if isinstance(found, dict) else {}
        changed = not is_unchanged(members)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DataError(f"{file} is not JSON: {_decoder_message(error)}. {GIVE_RESULT}") from error
    if changed:
        raise DataError(
            f"{file} was changed after it was written: its digest does not match its content. "
            "Give the original file, or remove the member digest to read the changed file.",
            code="changed-result",
        )
    schema = members.get("schema")
    return schema if isinstance(schema, str) else ""


def _decoder_message(error: Exception) -> str:
    """Return the message of a decoder as part of a sentence.

    For example ``expected float, got str at $.rows``.
    """
    text = str(error).replace("`", "").replace(" - at ", " at ").removeprefix("JSON is malformed: ")
    return text[:1].lower() + text[1:]


def read_identification(file: str | Path) -> SavedIdentification:
    """Return the identification in a file, without its axis.

    The file is checked against its schema, and its parts are checked for consistency.

    Raises
    ------
    UsageError
        The argument is not a file name.
    DataError
        The file cannot be read, or is not a complete result.
    """
    path = _path(file)
    return _checked(path, read_document(path, WrittenIdentification))


def _path(file: object) -> Path:
    """Return the argument as a path; refuse anything but a text or a path."""
    if not isinstance(file, (str, Path)):
        raise UsageError(
            f"the result is {quoted(file)}; expected is the name of a file. {GIVE_RESULT}",
            code="result-file",
        )
    return Path(file)


def _checked(file: Path, document: WrittenIdentification) -> SavedIdentification:
    """Return the identification of a document, after a check that its parts are consistent.

    Raises
    ------
    DataError
        Parts contradict each other, or a covariance is unknown in this program.
    """
    # Another program may have registered a covariance of its own.
    for estimate in document.estimates:
        if estimate.chosen_covariance not in COVARIANCES:
            raise DataError(
                f"{file} has intervals by the covariance {quoted(estimate.chosen_covariance)}, "
                f"which is unknown in this program (known: {', '.join(COVARIANCES)}). Register "
                "this covariance as in the program that wrote the file, or identify again.",
                code="result-file",
            )
    saved = _evaluated(str(file), lambda: SavedIdentification.of(str(file), document))
    # A summary needs all parts of a document.
    _evaluated(str(file), lambda: saved.summary(full=True))
    return saved


def _evaluated(file: str, function: Callable[[], T]) -> T:
    """Return the result of a function of a file's content; a failure is a fault of the file.

    Raises
    ------
    DataError
        The function fails.
    """
    try:
        return function()
    except (AxisidError, ArithmeticError, LookupError, TypeError, ValueError) as error:
        problem = f"it has no summary ({type(error).__name__}: {error})"
        if isinstance(error, AxisidError):
            problem = str(error).removesuffix(".")
        raise DataError(
            f"{file} contradicts itself: {problem}. {WRITE_AGAIN}", code="result-file"
        ) from error


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
    path : str, Path or SavedIdentification
        File written by ``axisid identify --json``, ``axisid fit --json``, ``axisid study --json``
        or ``axisid fleet``, or ``result.to_dict()`` as JSON. A result that was read before is
        joined with the axis.
    axis : Axis, str or Path, optional
        The identified axis, or an argument of `load_axis`. An axis of the library is found
        automatically. Without the axis the estimates can be read, but not exported or validated on
        another record.

    Returns
    -------
    SavedIdentification, SavedOutputFit, SavedMonteCarlo or SavedFitValidation
        An identification has the estimates by method, their covariances, the verdict, ``derive``,
        ``summary`` and ``plot``, and works with `export`. A fit has its parameters with their
        covariance, the verdict and ``summary``; a study its figures; a validation its residual
        and checks.

    Raises
    ------
    DataError
        The file cannot be read, or is not a complete result.
    UsageError
        The axis is not the identified one.
    """
    if isinstance(path, SavedIdentification):
        return path if axis is None else joined(path, axis)
    file = _path(path)
    document = read_document(
        file, WrittenIdentification, WrittenOutputFit, SavedMonteCarlo, SavedFitValidation
    )
    saved: SavedOutputFit | SavedMonteCarlo | SavedFitValidation
    match document:
        case WrittenIdentification():
            return joined(_checked(file, document), axis)
        case WrittenOutputFit():
            saved = _evaluated(str(file), lambda: SavedOutputFit.of(str(file), document))
        case SavedMonteCarlo() | SavedFitValidation():
            saved = document
    _evaluated(str(file), saved.summary)
    return saved


def joined(saved: SavedIdentification, given: Axis | str | Path | None) -> SavedIdentification:
    """Return the result of a file with its axis.

    Parameters
    ----------
    saved : SavedIdentification
    given : Axis, str, Path or None
        The identified axis, or an argument of `load_axis`; None for the axis of the library.

    Returns
    -------
    SavedIdentification
        Without an axis if none is given and the library does not contain the identified one.

    Raises
    ------
    UsageError
        The given axis is not the identified one.
    """
    document, file = saved.document, saved.file
    if given is None and document.axis not in LIBRARY:
        return replace(saved, declared=None)
    source = document.axis if given is None else given
    axis = source if isinstance(source, Axis) else load_axis(source)
    # The axis is the identified one if it gives the same generated code.
    model = derive(_as_identified(saved, axis))
    signature_now = signature(model)
    if signature_now == document.signature:
        if given is not None:
            refuse_differences(saved, axis, model.base.known)
        return replace(saved, declared=model.base.declared)
    if given is None:
        return replace(saved, declared=None)
    of_axis = "" if document.axis == axis.name else f" of the axis {document.axis!r}"
    raise UsageError(
        f"{file} was identified with the generated code {document.signature[:12]}{of_axis}, but "
        f"the current declaration of {axis.name!r} has {signature_now[:12]}. Give the axis as it "
        "was declared then, or identify again.",
        code="result-file",
    )


def _as_identified(saved: SavedIdentification, axis: Axis) -> Axis:
    """Return an axis in the form in which it was identified.

    Its left-out parameters are removed, known parameters are fixed unless the axis fixes them
    itself, and an estimated time of its drive has the estimated value.
    """
    found = saved.drive_time
    if found is not None:
        axis = replace(axis, drive=axis.drive.with_time(found.name, found.value))
    left = leave_out(axis, **(saved.document.left_out or {}))
    free = {p.name for p in left.parameters if p.known is None}
    return fix(left, **{n: (v.value, v.sd) for n, v in _fixed(saved).items() if n in free})


def _fixed(saved: SavedIdentification) -> Mapping[str, WrittenKnown]:
    """Return the values that were declared as known in an identification, by parameter."""
    physical = saved.document.estimates[0].physical
    return physical.fixed if physical else {}


_SAME_DEVIATION = 1e-9  # relative difference of two standard errors that count as equal


def refuse_differences(
    saved: SavedIdentification, axis: Axis, known: Iterable[Parameter] = ()
) -> None:
    """Refuse an axis that differs from the identified axis in values outside the generated code.

    Parameters
    ----------
    saved : SavedIdentification
    axis : Axis
        The given axis; an estimated time of its drive is still a parameter.
    known : iterable of Parameter
        Known parameters of the axis.

    Raises
    ------
    UsageError
        Lag, delay, place of the recorded control, relative_sd of the gain, or fixed values differ
        from those of the identification.
    """
    drive, found = axis.drive, saved.drive_time
    # All values as texts by name, of the identified axis and of the given one.
    identified, given = _drive_texts(saved.drive), _drive_texts(drive)
    identified |= {name: _known_text(v.value, v.sd) for name, v in _fixed(saved).items()}
    given |= {p.name: _known_text(p.known, p.known_sd) for p in known}
    # An estimated time may be declared by its start value or by its estimate.
    if found is not None:
        start = found.parameter.nominal
        identified[f"the drive's {found.name}"] = _estimated_text(start)
        if getattr(drive, found.name) in (start, found.value):
            given[f"the drive's {found.name}"] = _estimated_text(start)
    gain_sd = saved.document.estimates[0].gain_relative_sd  # also 0 if the force was measured
    if gain_sd and not math.isclose(gain_sd, drive.relative_sd, rel_tol=_SAME_DEVIATION):
        identified["the drive's relative_sd"] = f"{gain_sd:g}"
        given["the drive's relative_sd"] = f"{drive.relative_sd:g}"
    for name in {**identified, **given}:
        then, now = identified.get(name, "free"), given.get(name, "free")
        if then != now:
            raise UsageError(
                f"{saved.file} was identified with {name} {then}, but in the current declaration "
                f"of {axis.name!r} it is {now}. Give the axis as it was declared then, or identify "
                "again.",
                code="result-file",
            )


def _known_text(value: float | None, sd: float) -> str:
    """Return a known value with its standard error as text: ``fixed at 1.5 +- 0.1``."""
    return f"fixed at {value!r}" + (f" +- {sd!r}" if sd else "")


def _drive_texts(drive: Drive) -> dict[str, str]:
    """Return the drive's times, place of the recorded control and command path as texts by name."""
    names = ("lag", "delay", "logged", *CommandPath.__dataclass_fields__)
    texts = {f"the drive's {name}": str(getattr(drive, name)) for name in names}
    if drive.estimated is not None:
        texts[f"the drive's {drive.estimated[0]}"] = _estimated_text(drive.estimated[1].nominal)
    return texts


def _estimated_text(nominal: float) -> str:
    """Return a text on a time of the drive that is estimated, with its start value."""
    return f"estimated from {nominal:g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedAxis:
    """An axis with its identification.

    Attributes
    ----------
    model : AxisModel
        Declared axis with its derived models.
    signature : str
        Signature of the generated code of the identification.
    source, sha256 : str
        Source and sha256 of the record.
    result : Identification or SavedIdentification
        Identification of the parameters of the axis, or of its base parameters.
    """

    model: AxisModel
    signature: str
    source: str
    sha256: str
    result: Identification | SavedIdentification

    def values(self, method: str) -> dict[str, Value]:
        """Return every value by a method, by name, the estimated parameters first.

        A value that was calculated with known parameters replaces the estimate.
        """
        physical = self.result.physical
        calculated = physical[method].parameters if method in physical else {}
        return {**self.result.estimates[method].parameters, **calculated}


def fitted_axis(
    result: Identification | SavedIdentification | str | Path,
    axis: Axis | str | Path | None = None,
    record: int | None = None,
) -> FittedAxis:
    """Return an identification together with the models of its axis.

    Parameters
    ----------
    result : Identification, SavedIdentification, str or Path
        An identification, or the file written by ``axisid identify --json``.
    axis : Axis, str or Path, optional
        As for `load_result`; needed for a file of an axis outside the library.
    record : int, optional
        Number of the record, from 1, if several records have their own parameters.

    Raises
    ------
    UsageError
        The axis of a file is unknown or is not the identified one; or there is no such record, or
        records have different parameters.
    DataError
        The file cannot be read, or is not an identification.
    """
    if isinstance(result, Identification):
        live = result if record is None else result.part(record)
        return _fitted(live, live.axis.declared, live.axis.signature)
    saved = result if isinstance(result, SavedIdentification) else read_identification(result)
    if axis is not None or saved is not result:
        saved = joined(saved, axis)
    part = saved if record is None else saved.part(record)
    return _fitted(part, part.own_axis, part.signature)


def _fitted(
    result: Identification | SavedIdentification, declared: Axis, signature: str
) -> FittedAxis:
    """Return a result with the models of its axis.

    Parameters
    ----------
    result : Identification or SavedIdentification
    declared : Axis
        Declaration of the identified axis.
    signature : str
        Signature of the generated code of the identification.

    Raises
    ------
    UsageError
        Records have different parameters.
    """
    names = [*result.local_names]
    if result.of_records:
        names += result.of_records[0].known
    if names:
        have = "has" if len(names) == 1 else "have"
        raise UsageError(
            f"{', '.join(names)} {have} a separate value for each record, so there is no single "
            "set of parameters. Name a record: record=1.",
            code="export",
        )
    origin = result.record.provenance
    sources = [each.record.provenance.source for each in result.of_records] or [origin.source]
    return FittedAxis(
        model=derive(declared),
        signature=signature,
        # A file name may contain bytes that are not text.
        source=", ".join(sources).encode("utf-8", "replace").decode(),
        sha256="" if result.of_records else origin.sha256,
        result=result,
    )
