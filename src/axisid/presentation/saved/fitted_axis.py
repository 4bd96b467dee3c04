"""An axis with identified parameters: from an identification, or from the file that it wrote."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from axisid.estimation.estimates import Value
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import AxisModel, derive
from axisid.presentation.schema import WrittenStream
from axisid.support.errors import UsageError
from axisid.support.remedy import Remedy, Setting
from axisid.support.user_values import is_among, quoted

from .estimate import named
from .file import joined_model, read_fit
from .identification import SavedIdentification

_STREAMED = "idm-ls"  # the one method of a log that is read in blocks


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
                code="not-estimated-by",
            )
        return method


def fitted_axis(
    result: Identification | SavedIdentification | str | Path,
    axis: Axis | str | Path | None = None,
) -> FittedAxis:
    """Take an identification, or read one and join it with its axis.

    Parameters
    ----------
    result : Identification, SavedIdentification, str or Path
        Or the file that ``axisid identify --json`` wrote.
    axis : Axis, str or Path, optional
        As `load_result` takes it: needed for a file of an axis that is none of the library.

    Raises
    ------
    UsageError
        The axis of a file is not known, or is not the one that was identified.
    DataError
        The file cannot be read, or is no identification.
    """
    _refuse_own_parameters(result)
    if isinstance(result, Identification):
        return _identified(result, derive(result.axis.declared), result.axis.signature)
    if isinstance(result, SavedIdentification) and axis is None:
        return _identified(result, derive(result.own_axis), result.signature)
    saved = result if isinstance(result, SavedIdentification) else read_fit(result)
    document = saved.document if isinstance(saved, SavedIdentification) else saved
    file = saved.file if isinstance(saved, SavedIdentification) else str(result)
    model = joined_model(document, file, axis)
    if model is None:
        raise UsageError(
            f"{file} does not hold the axis {document.axis!r}; ",
            Remedy.of("give the one it was identified with (", Setting("axis"), ")."),
            code="file-of-another-axis",
        )
    if isinstance(saved, WrittenStream):
        return _streamed(saved, model)
    _refuse_own_parameters(saved)
    return _identified(saved, model, saved.signature)


def _refuse_own_parameters(result: object) -> None:
    """Refuse a result of records that are not of one set of the axis's parameters."""
    if not isinstance(result, (Identification, SavedIdentification)):
        return
    names = [*result.local_names, *(n for of_one in result.of_records[:1] for n in of_one.known)]
    if names:
        raise UsageError(
            f"{', '.join(names)} of this result {'is' if len(names) == 1 else 'are'} each record's "
            "own or known of each, so that there is no one set of the axis's parameters; take the "
            "part that one record is, result.parts[0].",
            code="own-parameters-exported",
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


def _streamed(written: WrittenStream, model: AxisModel) -> FittedAxis:
    return FittedAxis(
        model=model,
        signature=written.signature,
        source=_writable(written.record.source),
        sha256=written.record.sha256 or "",
        estimates={_STREAMED: named(written.parameters)},
        preferred=_STREAMED,
    )


def _writable(name: str) -> str:
    """A file's name may hold bytes that are no text."""
    return name.encode("utf-8", "replace").decode()
