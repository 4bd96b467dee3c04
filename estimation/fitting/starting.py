"""Where a fit starts, and whose parameters it searches."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices.outputs import (
    FIT_STARTS,
    INSTRUMENTS_START,
    LEAST_SQUARES_START,
    NOMINAL_START,
)
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import identify, layout_for
from axisid.estimation.joint import JointForm, Told
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, InverseForm
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, UsageError
from axisid.support.real_numbers import is_real
from axisid.support.remedy import Note
from axisid.support.user_values import is_among, quoted

_PART_OF_FORCE = 1e-3  # that a parameter of its least size makes
_METHODS = {INSTRUMENTS_START: "idm-iv", LEAST_SQUARES_START: "idm-ls"}

#: As users give it: a name, parameters, or an estimate.
StartLike = str | Mapping[str, float] | Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class Sharing:
    """What records share, and what is each one's own.

    Attributes
    ----------
    local : tuple of str
    known : mapping of str to sequence
        As `identify` takes it.
    identifies_gain : bool
    """

    local: tuple[str, ...]
    known: Mapping[str, Sequence[Told]]
    identifies_gain: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Searched:
    """Whose parameters a fit searches.

    Attributes
    ----------
    form : Form
        In the parameters of all records.
    axes : tuple of GeneratedAxis
        By record.
    local : mapping of str to tuple of str
        Names of each parameter that records have for themselves, by record.
    """

    form: Form
    axes: tuple[GeneratedAxis, ...]
    local: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class FitStart:
    """Where a search starts.

    Attributes
    ----------
    physical : (P,) array
    size : (P,) array
        Least size that steps are taken of, as a parameter may be 0.
    named : str
        Of `FIT_STARTS`, or ``given``.
    """

    physical: Array
    size: Array
    named: str


def searched(axis: GeneratedAxis, records: Sequence[Record], sharing: Sharing) -> Searched:
    """The parameters of an axis that so many records share.

    Raises
    ------
    UsageError, ModelError
        As `identify` does.
    """
    known = sharing.known or None
    layout = layout_for(axis, records, sharing.local, known, gain=sharing.identifies_gain)
    if layout is None:
        return Searched(form=InverseForm(axis), axes=(axis,) * len(records), local={})
    axes = tuple(member.axis for member in layout.members)
    return Searched(form=JointForm(axis, layout=layout), axes=axes, local=layout.local)


def starts_from(
    asked: StartLike, axis: GeneratedAxis, records: Sequence[Record], sharing: Sharing, form: Form
) -> tuple[list[FitStart], list[Note]]:
    """Starts in the order in which they are tried, and why others came to nothing.

    Parameters
    ----------
    asked : str, mapping of str to float or Estimate
        Of a name of `FIT_STARTS`: that, and those that follow it.
    axis, records, sharing, form

    Raises
    ------
    UsageError
        What is asked for is none of them, or parameters are none of the fit's.
    """
    names = [q.name for q in form.physical_quantities]
    size = np.abs(form.start)
    nominal = FitStart(physical=form.start, size=size, named=NOMINAL_START)
    if isinstance(asked, Estimate):
        return [_of_estimate(asked, names, "given")], []
    if isinstance(asked, Mapping):
        return [FitStart(physical=_given(asked, names, form), size=size, named="given")], []
    if not is_among(asked, FIT_STARTS):
        raise UsageError(
            f"there is no start {quoted(asked)}; choose from {', '.join(FIT_STARTS)}, or give an "
            "estimate, or values by name.",
            code="unknown-start",
        )
    found, why = [], []
    for name in FIT_STARTS[FIT_STARTS.index(asked) : -1]:
        try:
            with np.errstate(all="ignore"):
                estimate = _estimate(_METHODS[name], axis, records, sharing)
            found.append(_of_estimate(estimate, names, name))
            break
        except AxisidError as error:
            why.append(error.note)
    return [*found, nominal], why


def _estimate(
    method: str, axis: GeneratedAxis, records: Sequence[Record], sharing: Sharing
) -> Estimate:
    result = identify(
        axis,
        records,
        methods=[method],
        local=sharing.local,
        known=sharing.known or None,
        gain="identified" if sharing.identifies_gain else "declared",
    )
    return result[method]


def _of_estimate(estimate: Estimate, names: Sequence[str], named: str) -> FitStart:
    if [q.name for q in estimate.quantities] != [*names]:
        raise UsageError(
            f"the estimate to start from has {', '.join(q.name for q in estimate.quantities)}, the "
            f"fit {', '.join(names)}; give one of the same axis and records.",
            code="other-start",
        )
    size = np.zeros(len(names))
    if estimate.X.shape[1] == len(names):
        columns = np.linalg.norm(estimate.X, axis=0)
        whole = np.full(len(names), np.linalg.norm(estimate.y))
        size = _PART_OF_FORCE * np.divide(whole, columns, out=size, where=columns > 0)
    return FitStart(physical=estimate.physical, size=size, named=named)


def _given(asked: Mapping[str, float], names: Sequence[str], form: Form) -> Array:
    found = form.start.copy()
    for name, value in asked.items():
        if name not in names or not (is_real(value) and np.isfinite(value)):
            raise UsageError(
                f"the start of {quoted(name)} is {quoted(value)}; give finite numbers, by name, "
                f"of {', '.join(names)}.",
                code="fit-start",
            )
        found[names.index(name)] = value
    return found
