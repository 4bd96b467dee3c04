"""The arguments of a fit: its start, its outputs, and its free parameters."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import (
    FIT_STARTS,
    FORCE,
    INSTRUMENTS_START,
    LEAST_SQUARES_START,
    NOMINAL_START,
    OPEN_LOOP,
    OUTPUTS,
    open_loop_fit,
)
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import JointRecords, check_drive_time, identify
from axisid.estimation.output_residuals import FEWEST_IN_WINDOW
from axisid.estimation.records import Record
from axisid.estimation.regression import InverseForm, lacking_loop
from axisid.estimation.unknowns import (
    GAIN,
    INITIAL_STATE_PARAMETERS,
    START,
    ExtendedForm,
    JointForm,
    Unknowns,
    least_sizes,
)
from axisid.modeling.declaration import HIDDEN_FROM
from axisid.modeling.quantities import Parameter, State
from axisid.support.arrays import Array
from axisid.support.checks import by_name, check_among, is_among, is_real, listed, refuse
from axisid.support.errors import AxisidError, UsageError
from axisid.support.wording import quoted

_PART_OF_FORCE = 1e-3  # part of the force that a parameter of its least size makes
_GAIN = "gain"  # name in `free`, besides the name of the parameter
_LEAST = 0.1  # periods: least start of a time of the drive
_METHODS = {INSTRUMENTS_START: "idm-iv", LEAST_SQUARES_START: "idm-ls"}

# 1/unit of the output, or the inverse; a larger ratio of weights hides an output by rounding
_MAX_WEIGHT = 1e20

#: Start of a fit as users give it: a name, values of parameters, or an estimate.
StartLike = str | Mapping[str, float] | Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class FitStart:
    """The start of a search.

    Attributes
    ----------
    physical : (P,) array
        Start values of all parameters, SI.
    size : (P,) array
        Least sizes of the parameters for the scale of steps, as a parameter may be 0.
    named : str
        One of `FIT_STARTS`, or ``given``.
    """

    physical: Array
    size: Array
    named: str


def split_free(
    free: str | Sequence[str],
    axis: GeneratedAxis,
    records: Sequence[Record],
    outputs: Sequence[str],
) -> tuple[Sequence[str], Parameter | None]:
    """Return the free names without times of the drive, and the drive's lag or delay.

    The latter is None if neither is free; otherwise its nominal value is the declared one, but not
    0.

    Parameters
    ----------
    free : str or sequence of str
        Names that the user wants to estimate, as in `fit`.
    axis : GeneratedAxis
    records : sequence of Record
    outputs : sequence of str

    Raises
    ------
    UsageError
        Both times are free, or one that the records cannot show, or with which no loop can be
        simulated.
    """
    # The times among the free names, and the time that the drive declares as unknown.
    names = listed(free)
    law, drive = axis.declared.control, axis.declared.drive
    gains = {} if law is None else law.gains
    times = [name for name in dict.fromkeys(names) if name in HIDDEN_FROM and name not in gains]
    declared = drive.estimated
    if declared is not None and declared[0] not in times:
        times.append(declared[0])
    if not times:
        return names, None
    name = times[0]
    refuse(
        UsageError,
        (
            len(times) > 1,
            "lag and delay of the drive are both free, but a record shows their sum only. Free one "
            "of them",
        ),
        (
            axis.declared.states,
            f"the drive's {name} cannot be free: the friction of axis {axis.declared.name!r} has "
            "internal state, which cannot be simulated with a force that changes between the "
            "samples of the law. Use the declared value",
        ),
        code="free",
    )
    # Refuse a time that a record cannot show, then start from its declared value.
    for record in records:
        check_drive_time(axis.declared, record, name, by_law=OPEN_LOOP not in outputs)
    value = max(float(getattr(drive, name)), _LEAST * records[0].period)
    parameter = declared[1] if declared is not None else Parameter(name, "s", lower=0.0)
    return [n for n in names if n != name], replace(parameter, name=name, nominal=value)


def form_with(
    names: Sequence[str], outputs: Sequence[str], shared: JointRecords, joint: JointForm | None
) -> ExtendedForm:
    """Return the map of all parameters of a fit to those of each record's axis.

    Free gains of drive and law, and free initial states, are added to the parameters of the model.

    Parameters
    ----------
    names : sequence of str
        Free names, without times of the drive.
    outputs : sequence of str
    shared : JointRecords
        The records, and their local and known parameters.
    joint : JointForm or None
        Form of the model for several records; None for one model of all records.

    Raises
    ------
    ModelError
        The law has no gains that can be free, or the drive no gain that can be free.
    UsageError
        A name is no gain of the law, or a value known of the records; or the output has no law, or
        is a force column.
    """
    # The model's parameters, then the drive gain, the gains of the law and the initial states.
    model, axes = joint or InverseForm(shared.axis), shared.axes(shared.axis, joint)
    form = ExtendedForm(shared.axis, of_model=model, axes=tuple(axes))
    law = form.axes[0].axis.control
    of_law = () if law is None else tuple(law.gains)
    if {_GAIN, GAIN} & {*names} - {*of_law}:
        by_force = OPEN_LOOP in outputs and any(r.control is None for r in shared.records)
        refuse(
            UsageError,
            (
                FORCE in outputs or by_force,
                "the drive gain cannot be free if the fit follows, or is driven by, a force "
                "column: the force is measured behind the drive gain. Fit the control or the "
                "position, or compare the force column with the control by identify",
            ),
            code="free",
        )
        form = form.with_drive_gain()
        names = [n for n in names if n in of_law or n not in (_GAIN, GAIN)]
    both = [name for name in names if name in shared.known]
    refuse(
        UsageError,
        (
            names and OPEN_LOOP in outputs,
            f"{', '.join(map(str, names))} cannot be free in an open loop, which has no law and an "
            "initial state in each window. Fit the control or the position",
        ),
        (
            both,
            f"{' and '.join(map(str, both))} cannot be both free and known of each record. Leave "
            "one of the two out",
        ),
        code="free",
    )
    starts = [n for n in names if n in (START, *INITIAL_STATE_PARAMETERS) and n not in of_law]
    gains = [n for n in names if n not in starts]
    if law is not None and of_law and (others := [n for n in gains if n not in of_law]):
        raise UsageError(
            f"there is no gain {quoted(others[0])} that could be free. Control law {law.name!r} "
            f"has {', '.join(of_law)}. Besides its gains, choose from {_GAIN}, lag and delay of "
            f"the drive, {START}, {' and '.join(INITIAL_STATE_PARAMETERS)}.",
            code="free",
        )
    form = form.with_gains(gains) if gains else form
    return form.with_starts(shared.records, starts) if starts else form


def check_remembered(
    states: Sequence[State], unknowns: Unknowns, begins: Sequence[FitStart]
) -> None:
    """Refuse to search for a parameter of friction with internal state from 0.

    Raises
    ------
    UsageError
        A parameter of a state's equation starts at 0, so its size is unknown.
    """
    inside = {str(each) for state in states for law in state.laws for each in law.free_symbols}
    known = np.where(unknowns.has_prior, unknowns.prior, 0.0)
    sizes = np.abs([[begun.physical, begun.size, known] for begun in begins]).max(axis=1)
    lost = unknowns.free & (sizes.min(axis=0) == 0)
    if names := [n for n, at in zip(unknowns.names, lost, strict=True) if at and n in inside]:
        raise UsageError(
            f"{names[0]} starts at 0, so the internal state of the friction does not change and "
            "does not show its size. Declare a nominal value of about that size, or give a prior.",
            code="fit",
        )


def starts_from(
    asked: StartLike, shared: JointRecords, form: ExtendedForm, gain: str
) -> tuple[list[FitStart], list[str]]:
    """Return starts in the order in which they are tried, and the reasons why other starts failed.

    Instruments or least squares are tried first, whichever gives an estimate, then nominal values.

    Parameters
    ----------
    asked : str, mapping of str to float or Estimate
        A name of `FIT_STARTS` stands for this start and those that follow it.
    shared : JointRecords
        The records, with their local and known parameters.
    form : ExtendedForm
        Form with all parameters of the fit.
    gain : str
        As in `identify`.

    Raises
    ------
    UsageError
        There is no such start, or the fit has other parameters.
    """
    # Nominal values, and the size and start of the fit's parameters that are not the model's.
    names = [q.name for q in form.of_model.physical_quantities]
    size = np.maximum(np.abs(form.start), least_sizes(form))
    others = form.start[len(names) :], size[len(names) :]
    nominal = FitStart(physical=form.start, size=size, named=NOMINAL_START)
    if isinstance(asked, Estimate):
        return [_of_estimate(asked, names, "given", *others)], []
    if isinstance(asked, Mapping):
        return [FitStart(physical=_given(asked, form), size=size, named="given")], []
    if not is_among(asked, FIT_STARTS):
        raise UsageError(
            f"there is no start {quoted(asked)}. Choose from {', '.join(FIT_STARTS)}, or give an "
            "estimate, or values by name.",
            code="fit",
        )
    if shared.axis.states:
        return [nominal], ["no method estimates a start for friction with internal state"]
    # The first estimate that succeeds, from the requested start on; nominal values come last.
    why: list[str] = []
    for name in FIT_STARTS[FIT_STARTS.index(asked) : -1]:
        pairs = zip(form.axes, shared.records, strict=True)
        if name == INSTRUMENTS_START and any(lacking_loop(axis, record) for axis, record in pairs):
            why.append("instruments need a control law and a reference, and one of them is missing")
            continue
        try:
            with np.errstate(all="ignore"):
                result = identify(
                    shared.axis,
                    shared.records,
                    methods=[_METHODS[name]],
                    local=shared.local,
                    known=shared.known or None,
                    gain=gain,
                    bootstrap=0,
                    judge=False,  # a start needs no standard errors
                )
            return [_of_estimate(result[_METHODS[name]], names, name, *others), nominal], why
        except AxisidError as error:
            why.append(str(error))
    return [nominal], why


def _of_estimate(
    estimate: Estimate, names: Sequence[str], named: str, others: Array, sizes: Array
) -> FitStart:
    """Return the start at an estimate of the model's parameters.

    Parameters
    ----------
    estimate : Estimate
    names : sequence of str
        Names of the parameters of the model.
    named : str
        Name of the start.
    others, sizes : (k,) array
        Start values and least sizes of the further parameters of the fit.
    """
    if [q.name for q in estimate.quantities] != [*names]:
        raise UsageError(
            f"the estimate to start from has {', '.join(q.name for q in estimate.quantities)}, the "
            f"fit {', '.join(names)}. Give an estimate of the same axis and records.",
            code="fit",
        )
    size = np.zeros(len(names))
    if estimate.X.shape[1] == len(names):
        columns = np.linalg.norm(estimate.X, axis=0)
        whole = np.full(len(names), np.linalg.norm(estimate.y))
        size = _PART_OF_FORCE * np.divide(whole, columns, out=size, where=columns > 0)
    return FitStart(
        physical=np.append(estimate.physical, others),
        size=np.append(size, sizes),
        named=named,
    )


def _given(asked: Mapping[str, float], form: ExtendedForm) -> Array:
    """Return the start values of all parameters, (P,): given ones by name, others by default."""
    found, names = form.start.copy(), [q.name for q in form.physical_quantities]
    for name, value in asked.items():
        if name not in names or not (is_real(value) and np.isfinite(value)):
            raise UsageError(
                f"the start of {quoted(name)} is {quoted(value)}. Give finite numbers, by name, "
                f"of {', '.join(names)}.",
                code="fit",
            )
        found[names.index(name)] = value
    return found


def checked_outputs(given: object) -> tuple[str, ...]:
    """Return the fitted outputs, each once."""
    names = listed(given)
    check_among(*(("output", name, OUTPUTS) for name in names))
    found = tuple(dict.fromkeys(map(str, names)))
    refuse(
        UsageError,
        (not found, f"no output is given. Choose from {', '.join(OUTPUTS)}"),
        (
            OPEN_LOOP in found and len(found) > 1,
            f"{', '.join(found)} cannot be fitted together: an open loop has the recorded control, "
            "and the other outputs are of a closed loop with its law. Leave open-loop out, or fit "
            "it alone",
        ),
        code="fit",
    )
    return found


def checked_horizon(
    given: object, outputs: Sequence[str], records: Iterable[Record]
) -> float | None:
    """Return the checked length of an open loop's windows, s; None if none is given.

    It is at least the length of the fewest samples that a window needs.
    """
    if given is None:
        return None
    if not (is_real(given) and 0 < given < np.inf):
        raise UsageError(f"the horizon is {quoted(given)}. Give a positive time, s.", code="fit")
    if OPEN_LOOP not in outputs:
        raise UsageError(
            f"a horizon is given, but the {' and '.join(outputs)} of a closed loop has no windows. "
            f"Leave it out, or choose another output: {open_loop_fit()}.",
            code="fit",
        )
    return max(float(given), FEWEST_IN_WINDOW * max(record.period for record in records))


def checked_weights(given: Mapping[str, float] | None, outputs: Sequence[str]) -> tuple[float, ...]:
    """Return the weight of each output, 1/unit of the output; NaN if none is given."""
    weights, most = by_name(given, "weights"), _MAX_WEIGHT
    for name, weight in weights.items():
        if not (name in outputs and is_real(weight) and 1 / most <= float(weight) <= most):
            raise UsageError(
                f"the weight of {quoted(name)} is {quoted(weight)}. The fit follows "
                f"{' and '.join(outputs)}. Give for each of these the inverse of the standard "
                f"deviation of its errors, a number from {1 / most:g} to {most:g}.",
                code="fit",
            )
    return tuple(float(weights.get(name, np.nan)) for name in outputs)
