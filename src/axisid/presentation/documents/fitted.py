"""An axis with identified parameters: from an identification, or from the file that it wrote."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from axisid.codegen.artefacts import signature
from axisid.estimation.estimates import Value
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import leave_out
from axisid.modeling.derivation import AxisModel, derive
from axisid.modeling.text import load_axis
from axisid.support.errors import DataError, UsageError
from axisid.support.result_file import read_json

_SHOWN = 40  # letters
_SCHEMA, _STREAM = "axisid.identification/1", "axisid.stream/1"

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


def fitted_axis(result: Identification | str | Path, axis: str | Path | None = None) -> FittedAxis:
    """Take an identification, or read one and load its axis.

    Parameters
    ----------
    result : Identification, str or Path
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
    if axis is None:
        raise UsageError(f"{result} does not hold the axis; give the one it was identified with.")
    written = _read(Path(result))
    model = derive(leave_out(load_axis(axis), **(written.get("left_out") or {})))
    try:
        fitted = FittedAxis(
            model=model,
            signature=str(written["signature"]),
            source=_writable(str(written["record"]["source"])),
            sha256=str(written["record"]["sha256"] or ""),
            estimates={
                e["method"]: {
                    name: _value(v, str(e.get("chosen_covariance", "hac")))
                    for name, v in e["parameters"].items()
                }
                for e in _estimates(written)
                if e["method"] in JUDGED
            },
            physical={
                e["method"]: {
                    name: _value(v, str(e.get("chosen_covariance", "hac")))
                    for name, v in e["physical"]["parameters"].items()
                }
                for e in _estimates(written)
                if e["method"] in JUDGED and "physical" in e
            },
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(
            f"{result} is no complete result ({type(error).__name__}: {error}); write it again "
            "with axisid identify --json."
        ) from error
    _check(fitted, str(result), str(written.get("axis")))
    return fitted


def _writable(name: str) -> str:
    """A file's name may hold bytes that are no text."""
    return name.encode("utf-8", "replace").decode()


def _read(file: Path) -> dict[str, Any]:
    written = read_json(file, DataError, "Give what axisid identify --json wrote.")
    schema = written.get("schema") if isinstance(written, dict) else None
    if schema not in (_SCHEMA, _STREAM):
        what = f"its schema is {schema!r}" if schema else "it has no schema"
        raise DataError(
            f"{file} is not the result of one identification ({what}, not {_SCHEMA}); "
            "give what axisid identify --json wrote."
        )
    return dict(written)


def _estimates(written: Mapping[str, Any]) -> list[Any]:
    """Those of an identification; a log read in blocks gives one."""
    if written["schema"] == _STREAM:
        return [{"method": "idm-ls", "parameters": written["parameters"]}]
    return list(written["estimates"])


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


def _value(written: Mapping[str, Any], chosen: str) -> Value:
    low, high = written["interval_95"]
    gain, bias = written["sd_gain"], written.get("filter_bias")
    return Value(
        value=real_number(written["value"]),
        unit=str(written["unit"]),
        sd=real_number(written["sd"]),
        sd_robust=real_number(written["sd_robust"]),
        sd_hac=real_number(written["sd_hac"]),
        interval=(real_number(low), real_number(high)),
        sd_gain=0.0 if gain is None else real_number(gain),
        filter_bias=None if bias is None else real_number(bias),
        chosen=chosen,
    )


def real_number(value: Any) -> float:
    """A number of a result's file; anything else is a `ValueError`."""
    try:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            found = float(value)
            if math.isfinite(found):
                return found
    except OverflowError:
        pass  # a whole number beyond floating point
    raise ValueError(f"{repr(value)[:_SHOWN]} is no number")
