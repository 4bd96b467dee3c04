"""An axis with identified parameters: from an identification, or from the file that it wrote."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from axisid.estimation.estimates import Value
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import AxisModel, derive
from axisid.support.errors import UsageError, is_among, quoted

from .file import joined, read_identification
from .identification import SavedIdentification


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
    names = [*result.local_names, *(n for of_one in result.of_records[:1] for n in of_one.known)]
    if names:
        raise UsageError(
            f"{', '.join(names)} of this result {'is' if len(names) == 1 else 'are'} each "
            "record's own or known of each, so that there is no one set of the axis's "
            "parameters; name the record whose are wanted: record=1.",
            code="export",
        )
    origin = result.record.provenance
    sources = [of_one.record.provenance.source for of_one in result.of_records]
    source = ", ".join(sources) or origin.source
    return FittedAxis(
        model=derive(declared),
        signature=signature,
        # A file's name may hold bytes that are no text.
        source=source.encode("utf-8", "replace").decode(),
        sha256="" if sources else origin.sha256,
        estimates={m: e.parameters for m, e in result.estimates.items()},
        physical={m: p.parameters for m, p in result.physical.items()},
        preferred=result.preferred.method,
    )
