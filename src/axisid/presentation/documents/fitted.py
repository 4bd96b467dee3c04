"""An axis with identified parameters: from an identification, or from the file that it wrote."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from axisid.codegen.artefacts import signature
from axisid.estimation.estimates import Value
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import leave_out
from axisid.modeling.derivation import AxisModel, derive
from axisid.modeling.text import load_axis
from axisid.presentation.schema import (
    WrittenIdentification,
    WrittenStream,
    read_document,
)
from axisid.support.errors import DataError, UsageError

from .saved_estimate import named
from .saved_result import SavedIdentification, load_result

#: Which estimate is judged: the first of these that there is.
JUDGED = ("idm-iv", "ddm-iv", "idm-ls", "ddm-ls")


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
    """

    model: AxisModel
    signature: str
    source: str
    sha256: str
    estimates: Mapping[str, Mapping[str, Value]]
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
            return next(m for m in JUDGED if m in self.estimates)
        if method not in self.estimates:
            raise UsageError(
                f"the result has no estimate by {method!r}; it has {', '.join(self.estimates)}."
            )
        return method


def fitted_axis(
    result: Identification | SavedIdentification | str | Path, axis: str | Path | None = None
) -> FittedAxis:
    """Take an identification, or read one and load its axis.

    Parameters
    ----------
    result : Identification, SavedIdentification, str or Path
        Or the file that ``axisid identify --json`` wrote.
    axis : str or Path, optional
        As `load_axis` takes it; needed for a file.

    Raises
    ------
    UsageError
        A file is given without its axis, or the axis is not the one that was identified.
    DataError
        The file cannot be read, or is no identification.
    """
    if isinstance(result, Identification):
        origin = result.record.provenance
        return FittedAxis(
            model=derive(result.axis.axis),
            signature=result.axis.signature,
            source=_writable(origin.source),
            sha256=origin.sha256,
            estimates={m: e.parameters for m, e in result.estimates.items()},
            physical={m: p.parameters for m, p in result.physical.items()},
        )
    if isinstance(result, SavedIdentification):
        saved = load_result(result, axis)
        return _written(saved.document, derive(saved.known_axis))
    if axis is None:
        raise UsageError(f"{result} does not hold the axis; give the one it was identified with.")
    written = read_document(Path(result), WrittenIdentification, WrittenStream)
    fitted = _written(written, derive(leave_out(load_axis(axis), **(written.left_out or {}))))
    _check(fitted, str(result), written.axis)
    return fitted


def _written(written: WrittenIdentification | WrittenStream, model: AxisModel) -> FittedAxis:
    estimates = written.estimates if isinstance(written, WrittenIdentification) else ()
    streamed = written.parameters if isinstance(written, WrittenStream) else None
    return FittedAxis(
        model=model,
        signature=written.signature,
        source=_writable(written.record.source),
        sha256=written.record.sha256 or "",
        estimates={e.method: named(e.parameters, e.chosen_covariance) for e in estimates}
        if streamed is None
        else {"idm-ls": named(streamed)},
        physical={
            e.method: named(e.physical.parameters, e.chosen_covariance)
            for e in estimates
            if e.physical
        },
    )


def _writable(name: str) -> str:
    """A file's name may hold bytes that are no text."""
    return name.encode("utf-8", "replace").decode()


def _check(fitted: FittedAxis, file: str, name: str) -> None:
    """Refuse numbers of another axis."""
    axis = fitted.model.axis
    made = signature(fitted.model)
    if fitted.signature != made:
        whose = "" if name == axis.name else f" of the axis {name!r}"
        raise UsageError(
            f"{file} was identified with the generated code {fitted.signature[:12]}{whose}, but "
            f"{axis.name!r} as it is declared now has {made[:12]}; give the axis as it was then, "
            "or identify again."
        )
    wanted = [p.name for p in axis.parameters]
    if not fitted.estimates or any(sorted(v) != sorted(wanted) for v in fitted.estimates.values()):
        raise DataError(
            f"{file} lacks parameters of {axis.name!r}; write it again with axisid identify --json."
        )
