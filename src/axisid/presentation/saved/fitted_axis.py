"""An axis with identified parameters: from an identification, or from the file that it wrote."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from axisid.estimation.estimates import Value, physical_parameters
from axisid.estimation.identification import Identification, RecordInfo
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import AxisModel, derive
from axisid.support.errors import UsageError, is_among, quoted

from .file import joined_model, read_identification
from .identification import SavedIdentification
from .part import SavedPart


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
    estimates : mapping of str to mapping of str to Value
        Of the axis's parameters by method and name; base parameters where it has any.
    physical : mapping of str to mapping of str to Value
        Of declared parameters that follow from base parameters and known values, likewise; empty
        where the estimates are of them already.
    preferred : str
        The method that the verdict judges.
    """

    model: AxisModel
    signature: str
    source: str
    sha256: str
    estimates: Mapping[str, Mapping[str, Value]]
    preferred: str
    physical: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)

    def values(self, method: str) -> dict[str, Value]:
        """Every value of a method by name, the axis's own parameters first.

        What is known of a parameter, and what follows from that, goes before the estimate.
        """
        return {**self.estimates[method], **self.physical.get(method, {})}

    def chosen(self, method: str | None) -> str:
        """A method that gave an estimate; without one, that which the verdict judges.

        Raises
        ------
        UsageError
            The method gave none.
        """
        if method is None:
            return self.preferred
        if not is_among(method, self.estimates):
            raise UsageError(
                f"the result has no estimate by {quoted(method)}; it has "
                f"{', '.join(self.estimates)}.",
                code="result",
            )
        return method


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
    if record is not None and isinstance(result, Identification):
        return fitted_axis(result.part(record))
    if record is None:
        _refuse_own_parameters(result)
    if isinstance(result, Identification):
        return _identified(result, derive(result.axis.declared), result.axis.signature)
    if isinstance(result, SavedIdentification) and axis is None:
        return _of_file(result, derive(result.own_axis), record)
    saved = result if isinstance(result, SavedIdentification) else read_identification(result)
    model = joined_model(saved.document, saved.file, axis)
    if model is None:
        raise UsageError(
            f"{saved.file} does not hold the axis {saved.document.axis!r}; give the one it "
            "was identified with (axis).",
            code="result-file",
        )
    return _of_file(saved, model, record)


def _of_file(saved: SavedIdentification, model: AxisModel, record: int | None) -> FittedAxis:
    """What a file holds, of all records or of one."""
    if record is None:
        _refuse_own_parameters(saved)
        return _identified(saved, model, saved.signature)
    part = replace(saved, declared=model.base.declared).part(record)
    if not isinstance(part, SavedPart):
        found = _identified(saved, model, saved.signature)
        if not saved.of_records:
            return found
        return _from(found, saved.of_records[record - 1].record)
    found = FittedAxis(
        model=derive(part.axis.declared),
        signature=part.axis.signature,
        source="",
        sha256="",
        estimates={method: e.parameters for method, e in part.estimates.items()},
        preferred=part.preferred_method,
        physical={
            method: declared.parameters
            for method, e in part.estimates.items()
            if (declared := physical_parameters(method, e.form, e.distribution)) is not None
        },
    )
    return _from(found, part.record)


def _from(found: FittedAxis, record: RecordInfo) -> FittedAxis:
    """The same as of one record."""
    origin = record.provenance
    return replace(found, source=_writable(origin.source), sha256=origin.sha256)


def _refuse_own_parameters(result: object) -> None:
    """Refuse a result of records that are not of one set of the axis's parameters."""
    if not isinstance(result, (Identification, SavedIdentification)):
        return
    names = [*result.local_names, *(n for of_one in result.of_records[:1] for n in of_one.known)]
    if names:
        raise UsageError(
            f"{', '.join(names)} of this result {'is' if len(names) == 1 else 'are'} each "
            "record's own or known of each, so that there is no one set of the axis's "
            "parameters; name the record whose are wanted: record=1.",
            code="export",
        )


def _identified(
    result: Identification | SavedIdentification, model: AxisModel, signature: str
) -> FittedAxis:
    origin = result.record.provenance
    sources = [of_one.record.provenance.source for of_one in result.of_records]
    return FittedAxis(
        model=model,
        signature=signature,
        source=_writable(", ".join(sources) or origin.source),
        sha256="" if sources else origin.sha256,
        estimates={m: e.parameters for m, e in result.estimates.items()},
        physical={m: p.parameters for m, p in result.physical.items()},
        preferred=result.preferred.method,
    )


def _writable(name: str) -> str:
    """A file's name may hold bytes that are no text."""
    return name.encode("utf-8", "replace").decode()
