"""A result as a file has it: read, checked, and joined with its axis, ready to be exported."""

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
from axisid.support.errors import AxisidError, DataError, UsageError, quoted
from axisid.support.files import GIVE_RESULT, HOW_SAVED, WRITE_AGAIN, is_unchanged, read_result

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
_SHOWN = 40  # letters


#: What is said of documents that will not do, by their `schema_of`.
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


def read_document(file: Path, *expected: type[Expected]) -> Expected:
    """Read a result that was written as JSON.

    Parameters
    ----------
    file : Path
    *expected : type of JsonObject
        Which documents will do.

    Raises
    ------
    DataError
        The file cannot be read, is no JSON, was changed after it was written, is another document,
        or lacks something of its schema.
    """
    content = read_result(file)
    found, documents = _schema(file, content), {schema_of(each): each for each in expected}
    if found in documents:
        try:
            return msgspec.json.decode(content, type=documents[found], dec_hook=from_json)
        except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
            raise DataError(
                f"{file} lacks what its schema promises: {_said(error)}. {WRITE_AGAIN}",
                code="result-file",
            ) from error
    if found in _REFUSED:
        raise DataError(f"{file} {_REFUSED[found]}", code="result-file")
    what = f"its schema is {found[:_SHOWN]!r}" if found else "it has no schema"
    raise DataError(
        f"{file} is not the result of one identification ({what}, not "
        f"{schema_of(expected[0])!r}). {GIVE_RESULT}"
    )


def _schema(file: Path, content: bytes) -> str:
    """Which document it says that it is; empty if it does not."""
    try:
        found = msgspec.json.decode(content)
        members = found if isinstance(found, dict) else {}
        changed = not is_unchanged(members)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DataError(f"{file} is not JSON: {_said(error)}. {GIVE_RESULT}") from error
    if changed:
        raise DataError(
            f"{file} was changed after it was written: its digest is of other numbers or words. "
            "Give the file as it was written, or take its member digest out to have it read as it "
            "is.",
            code="changed-result",
        )
    schema = members.get("schema")
    return schema if isinstance(schema, str) else ""


def _said(error: Exception) -> str:
    """What the decoder says, within a sentence: ``expected float, got str at $.rows``."""
    text = str(error).replace("`", "").replace(" - at ", " at ").removeprefix("JSON is malformed: ")
    return text[:1].lower() + text[1:]


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
    return _checked(path, read_document(path, WrittenIdentification))


def _path(file: object) -> Path:
    if not isinstance(file, (str, Path)):
        raise UsageError(
            f"the result is {quoted(file)}; give the file of a result of identify, {HOW_SAVED}.",
            code="result-file",
        )
    return Path(file)


def _checked(file: Path, document: WrittenIdentification) -> SavedIdentification:
    """Refuse what does not belong together, and what cannot be computed from."""
    for estimate in document.estimates:  # a program that has a covariance more: it may be whole
        if estimate.chosen_covariance not in COVARIANCES:
            raise DataError(
                f"{file} has intervals by the covariance {quoted(estimate.chosen_covariance)}, "
                f"which this program does not have (it has {', '.join(COVARIANCES)}); "
                "register it as the program did that wrote the file, or identify again.",
                code="result-file",
            )
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
    except (AxisidError, ArithmeticError, LookupError, TypeError, ValueError) as error:
        problem = (
            str(error).removesuffix(".")
            if isinstance(error, AxisidError)
            else f"no summary can be made of it ({type(error).__name__}: {error})"
        )
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
            saved = _told(str(file), lambda: SavedOutputFit.of(str(file), document))
        case SavedMonteCarlo() | SavedFitValidation():
            saved = document
    _told(str(file), saved.summary)
    return saved


def joined(saved: SavedIdentification, given: Axis | str | Path | None) -> SavedIdentification:
    """A file's result with the axis that it is of: the given one, or the library's of its name.

    Returns
    -------
    SavedIdentification
        Without an axis where none is given and the library has not the one that was identified.

    Raises
    ------
    UsageError
        The axis that is given is not the one that was identified.
    """
    document, file = saved.document, saved.file
    if given is None and document.axis not in LIBRARY:
        return replace(saved, declared=None)
    source = document.axis if given is None else given
    axis = source if isinstance(source, Axis) else load_axis(source)
    model = derive(_as_identified(saved, axis))
    made = signature(model)
    if made == document.signature:
        if given is not None:
            refuse_differences(saved, axis, model.base.known)
        return replace(saved, declared=model.base.declared)
    if given is None:
        return replace(saved, declared=None)
    whose = "" if document.axis == axis.name else f" of the axis {document.axis!r}"
    raise UsageError(
        f"{file} was identified with the generated code {document.signature[:12]}{whose}, but "
        f"{axis.name!r} as it is declared now has {made[:12]}; give the axis as it was then, or "
        "identify again.",
        code="result-file",
    )


def _as_identified(saved: SavedIdentification, axis: Axis) -> Axis:
    """The axis without what was left out, and with what was fixed where it fixes nothing itself.

    A time of its drive that was estimated is what was found.
    """
    found = saved.drive_time
    if found is not None:
        axis = replace(axis, drive=axis.drive.with_time(found.name, found.value))
    left = leave_out(axis, **(saved.document.left_out or {}))
    free = {p.name for p in left.parameters if p.known is None}
    return fix(left, **{n: (v.value, v.sd) for n, v in _fixed(saved).items() if n in free})


def _fixed(saved: SavedIdentification) -> Mapping[str, WrittenKnown]:
    """What was declared as known, by name."""
    physical = saved.document.estimates[0].physical
    return physical.fixed if physical else {}


_SAME_DEVIATION = 1e-9  # relative, of two deviations that went through a text


def refuse_differences(
    saved: SavedIdentification, axis: Axis, known: Iterable[Parameter] = ()
) -> None:
    """Refuse an axis that differs from the identified one where no code tells them apart.

    Parameters
    ----------
    saved : SavedIdentification
    axis : Axis
        As it was given, a time of its drive that is estimated still a parameter.
    known : iterable of Parameter
        Those of the axis that are known.

    Raises
    ------
    UsageError
        It has another lag, delay, place of the recorded control, or deviation of its gain, or other
        fixed values than those that the physical parameters are from.
    """
    drive, found = axis.drive, saved.drive_time
    was, is_now = (_figures(each) for each in (saved.drive, drive))
    was |= {name: _known(v.value, v.sd) for name, v in _fixed(saved).items()}
    is_now |= {p.name: _known(p.known, p.known_sd) for p in known}
    if found is not None:
        start = found.parameter.nominal
        was[f"the drive's {found.name}"] = _started(start)
        if getattr(drive, found.name) in (start, found.value):
            is_now[f"the drive's {found.name}"] = _started(start)
    spread = saved.document.estimates[0].gain_relative_sd  # 0 too where the force was measured
    if spread and not math.isclose(spread, drive.relative_sd, rel_tol=_SAME_DEVIATION):
        was["the drive's relative_sd"] = f"{spread:g}"
        is_now["the drive's relative_sd"] = f"{drive.relative_sd:g}"
    for name in {**was, **is_now}:
        then, now = was.get(name, "free"), is_now.get(name, "free")
        if then != now:
            raise UsageError(
                f"{saved.file} was identified with {name} {then}, but {axis.name!r} as it is "
                f"declared now has it {now}; give the axis as it was then, or identify again.",
                code="result-file",
            )


def _known(value: float | None, sd: float) -> str:
    return f"fixed at {value!r}" + (f" +- {sd!r}" if sd else "")


def _figures(drive: Drive) -> dict[str, str]:
    """What is declared of how a drive follows its commands, in words."""
    names = ("lag", "delay", "logged", *CommandPath.__dataclass_fields__)
    figures = {f"the drive's {name}": str(getattr(drive, name)) for name in names}
    if drive.estimated is not None:
        figures[f"the drive's {drive.estimated[0]}"] = _started(drive.estimated[1].nominal)
    return figures


def _started(nominal: float) -> str:
    return f"estimated from {nominal:g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedAxis:
    """An axis and what was identified of it.

    Attributes
    ----------
    model : AxisModel
    signature : str
        Of the generated code that identified it.
    source, sha256 : str
        Of the record.
    result : Identification or SavedIdentification
        Of the axis's parameters; base parameters where it has any.
    """

    model: AxisModel
    signature: str
    source: str
    sha256: str
    result: Identification | SavedIdentification

    def values(self, method: str) -> dict[str, Value]:
        """Every value of a method by name, the axis's own parameters first.

        What is known of a parameter, and what follows from that, goes before the estimate.
        """
        physical = self.result.physical
        more = physical[method].parameters if method in physical else {}
        return {**self.result.estimates[method].parameters, **more}


def fitted_axis(
    result: Identification | SavedIdentification | str | Path,
    axis: Axis | str | Path | None = None,
    record: int | None = None,
) -> FittedAxis:
    """Take an identification, or read one and join it with its axis.

    Parameters
    ----------
    result : Identification, SavedIdentification, str or Path
        Or the file that ``axisid identify --json`` wrote.
    axis : Axis, str or Path, optional
        As `load_result` takes it: needed for a file of an axis that is none of the library.
    record : int, optional
        Number of one of several records, from 1, whose own parameters are wanted.

    Raises
    ------
    UsageError
        The axis of a file is not known, or is not the one that was identified; or there is no such
        record, or no one set of parameters.
    DataError
        The file cannot be read, or is no identification.
    """
    if isinstance(result, Identification):
        live = result if record is None else result.part(record)
        return _fitted(live, live.axis.declared, live.axis.signature)
    saved = result if isinstance(result, SavedIdentification) else read_identification(result)
    if axis is not None or saved is not result:
        saved = joined(saved, axis)
    of_one = saved if record is None else saved.part(record)
    return _fitted(of_one, of_one.own_axis, of_one.signature)


def _fitted(
    result: Identification | SavedIdentification, declared: Axis, signature: str
) -> FittedAxis:
    """A result of one set of the axis's parameters; another is refused."""
    if names := [*result.local_names, *(n for one in result.of_records[:1] for n in one.known)]:
        raise UsageError(
            f"{', '.join(names)} of this result {'is' if len(names) == 1 else 'are'} each "
            "record's own or known of each, so that there is no one set of the axis's "
            "parameters; name the record whose are wanted: record=1.",
            code="export",
        )
    origin = result.record.provenance
    sources = [each.record.provenance.source for each in result.of_records] or [origin.source]
    return FittedAxis(
        model=derive(declared),
        signature=signature,
        # A file's name may hold bytes that are no text.
        source=", ".join(sources).encode("utf-8", "replace").decode(),
        sha256="" if result.of_records else origin.sha256,
        result=result,
    )
