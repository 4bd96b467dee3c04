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
_GAIN = "gain"  # name of the drive gain in `free`; the name of its parameter is allowed too
_LEAST = 0.1  # periods: least start of a time of the drive
_METHODS = {INSTRUMENTS_START: "idm-iv", LEAST_SQUARES_START: "idm-ls"}

# Largest weight, 1/unit of the output; the smallest is its inverse. With a larger ratio of weights,
# rounding errors of one output would hide another output.
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
    """Return the free names without lag and delay, and the lag or delay of the drive if it is free.

    The lag or delay is returned as a parameter. Its nominal value is the declared value, but at
    least a tenth of a period. None if neither of the two is free.

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
        Lag and delay are both free; or the records cannot show the one that is free; or friction
        has internal state, so that no loop with a lag or delay can be simulated.
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
            "the lag and the delay of the drive are both free, but a record shows only their sum. "
            "Leave one of the two out of the free parameters",
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
    """Return the form of a fit: the map of all its parameters to those of each record's axis.

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
        The law or the drive has no gain that can be free.
    UsageError
        A name is no gain of the law, or its values are known for each record; or the output is that
        of an open loop, which has no law; or the drive gain is free with a force column.
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
                "the drive gain cannot be free if a force column is the output or the input of the "
                "fit, because the force is measured behind the drive gain. Fit the control or the "
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
            f"{', '.join(map(str, names))} cannot be free in an open loop: an open loop has no "
            "control law, and each of its windows has its own initial state. Fit the control or "
            "the position",
        ),
        (
            both,
            f"{' and '.join(map(str, both))} cannot be both free and known for each record. Leave "
            "each name out of the free parameters or of the known values",
        ),
        code="free",
    )
    starts = [n for n in names if n in (START, *INITIAL_STATE_PARAMETERS) and n not in of_law]
    gains = [n for n in names if n not in starts]
    if law is not None and of_law and (others := [n for n in gains if n not in of_law]):
        raise UsageError(
            f"there is no gain {quoted(others[0])} to estimate. Control law {law.name!r} has the "
            f"gains {', '.join(of_law)}. Choose from these gains, {_GAIN}, lag and delay of the "
            f"drive, {START}, {' and '.join(INITIAL_STATE_PARAMETERS)}.",
            code="free",
        )
    form = form.with_gains(gains) if gains else form
    return form.with_starts(shared.records, starts) if starts else form


def check_remembered(
    states: Sequence[State], unknowns: Unknowns, start_points: Sequence[FitStart]
) -> None:
    """Refuse a search that starts at 0 for a parameter of friction with internal state.

    Raises
    ------
    UsageError
        A free parameter in the equation of an internal state has a start, a least size and a prior
        value of 0, so its order of magnitude is unknown.
    """
    in_equations = {str(s) for state in states for law in state.laws for s in law.free_symbols}
    prior = np.where(unknowns.has_prior, unknowns.prior, 0.0)
    sizes = np.abs([[point.physical, point.size, prior] for point in start_points]).max(axis=1)
    has_no_size = unknowns.free & (sizes.min(axis=0) == 0)
    pairs = zip(unknowns.names, has_no_size, strict=True)
    names = [name for name, at_zero in pairs if at_zero and name in in_equations]
    if names:
        raise UsageError(
            f"the search for {names[0]} starts at 0. The internal state of the friction does not "
            f"change with this value, and does not show the size of {names[0]}. Declare a nominal "
            "value of the right order of magnitude, or give a prior value.",
            code="fit",
        )


def starts_from(
    asked: StartLike, shared: JointRecords, form: ExtendedForm, gain: str
) -> tuple[list[FitStart], list[str]]:
    """Return starts in the order in which they are tried, and the reasons why other starts failed.

    The first start is the estimate of instruments, or of least squares if instruments give no
    estimate; the second is that of the nominal values. A start that is given as values or as an
    estimate is the only one.

    Parameters
    ----------
    asked : str, mapping of str to float or Estimate
        Values by name, an estimate, or a name of `FIT_STARTS`. A name stands for this start and
        those that follow it in `FIT_STARTS`.
    shared : JointRecords
        The records, with their local and known parameters.
    form : ExtendedForm
        Form with all parameters of the fit.
    gain : str
        As in `identify`.

    Raises
    ------
    UsageError
        There is no such start, or the estimate has other parameters than the fit.
    """
    # The nominal start; then start values and sizes of the parameters that are not of the model.
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
    failed: list[str] = []
    for name in FIT_STARTS[FIT_STARTS.index(asked) : -1]:
        pairs = zip(form.axes, shared.records, strict=True)
        if name == INSTRUMENTS_START and any(lacking_loop(axis, record) for axis, record in pairs):
            failed.append(
                "instruments need a control law and a reference, and one of the two is missing"
            )
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
            return [_of_estimate(result[_METHODS[name]], names, name, *others), nominal], failed
        except AxisidError as error:
            failed.append(str(error))
    return [nominal], failed


def _of_estimate(
    estimate: Estimate, names: Sequence[str], named: str, others: Array, sizes: Array
) -> FitStart:
    """Return the start at an estimate of the model's parameters.

    The least size of a parameter is that with which its column makes 0.1 % of the force; 0 if the
    estimate has a regressor of other columns.

    Parameters
    ----------
    estimate : Estimate
    names : sequence of str
        Names of the parameters of the model.
    named : str
        Name of the start.
    others, sizes : (k,) array
        Start values and least sizes of the further parameters of the fit.

    Raises
    ------
    UsageError
        The estimate has other parameters than the model.
    """
    if [q.name for q in estimate.quantities] != [*names]:
        raise UsageError(
            "the estimate that is given as the start has the parameters "
            f"{', '.join(q.name for q in estimate.quantities)}, but the fit has the parameters "
            f"{', '.join(names)}. Give an estimate of the same axis and records.",
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
    """Return the start values of all parameters, (P,), SI.

    `asked` has values by name; the other parameters have the start values of the form.

    Raises
    ------
    UsageError
        A name is no parameter of the fit, or a value is not a finite number.
    """
    found, names = form.start.copy(), [q.name for q in form.physical_quantities]
    for name, value in asked.items():
        if name not in names or not (is_real(value) and np.isfinite(value)):
            raise UsageError(
                f"the start value of {quoted(name)} is {quoted(value)}. Give finite numbers for "
                f"parameters from {', '.join(names)}.",
                code="fit",
            )
        found[names.index(name)] = value
    return found


def checked_outputs(given: object) -> tuple[str, ...]:
    """Return the names of the fitted outputs, each once.

    Raises
    ------
    UsageError
        There is no such output, none is given, or an open loop is combined with another output.
    """
    names = listed(given)
    check_among(*(("output", name, OUTPUTS) for name in names))
    found = tuple(dict.fromkeys(map(str, names)))
    refuse(
        UsageError,
        (not found, f"no output is given. Choose from {', '.join(OUTPUTS)}"),
        (
            OPEN_LOOP in found and len(found) > 1,
            f"{', '.join(found)} cannot be fitted together: {OPEN_LOOP} is simulated with the "
            "recorded control, and the other outputs are simulated with the control law. Leave "
            f"{OPEN_LOOP} out, or fit {OPEN_LOOP} alone",
        ),
        code="fit",
    )
    return found


def checked_horizon(
    given: object, outputs: Sequence[str], records: Iterable[Record]
) -> float | None:
    """Return the checked length of an open loop's windows, s; None if no length is given.

    A shorter length than that of the fewest samples of a window is increased to it.

    Raises
    ------
    UsageError
        The length is not a positive time, or the outputs are those of a closed loop.
    """
    if given is None:
        return None
    if not (is_real(given) and 0 < given < np.inf):
        raise UsageError(f"the horizon is {quoted(given)}. Give a positive time, s.", code="fit")
    if OPEN_LOOP not in outputs:
        raise UsageError(
            f"a horizon is given, but a fit of the {' and '.join(outputs)} simulates a closed "
            "loop, which has no windows. Leave the horizon out, or choose another output: "
            f"{open_loop_fit()}.",
            code="fit",
        )
    return max(float(given), FEWEST_IN_WINDOW * max(record.period for record in records))


def checked_weights(given: Mapping[str, float] | None, outputs: Sequence[str]) -> tuple[float, ...]:
    """Return the weight of each output, 1/unit of the output; NaN for an output without a weight.

    Raises
    ------
    UsageError
        A weight is not a number in the allowed range, or its output is not fitted.
    """
    weights, most = by_name(given, "weights"), _MAX_WEIGHT
    for name, weight in weights.items():
        if not (name in outputs and is_real(weight) and 1 / most <= float(weight) <= most):
            raise UsageError(
                f"the weight of {quoted(name)} is {quoted(weight)}. The fit follows "
                f"{' and '.join(outputs)}. Give for each output the inverse of the standard "
                f"deviation of its errors, a number from {1 / most:g} to {most:g}.",
                code="fit",
            )
    return tuple(float(weights.get(name, np.nan)) for name in outputs)
