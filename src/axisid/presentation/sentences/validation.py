"""Sentences of the checks of a validation on a second record."""

from axisid.estimation.model_validation import (
    DoubtfulTimeBase,
    EquationErrorOnRecord,
    EstimatesDoNotHold,
    EstimatesHold,
    KnownSamples,
    NoSimulation,
    OutputOnRecord,
    ReestimatedParameters,
    SamplePeriods,
    SimulationOnRecord,
)
from axisid.support.settings import setting

from .dispatch import sentence
from .several_records import differing
from .words import listed


@sentence.register
def doubtful_time_base(finding: DoubtfulTimeBase) -> str:
    """Return the reason to doubt the sampling period."""
    return f"the time column contradicts the control law: {finding.reason}"


@sentence.register
def known_samples(finding: KnownSamples) -> str:
    """Return the share of samples that were used for the estimates, and the instruction."""
    if finding.is_same_record:
        return (
            f"the estimates were made from this record ({finding.percent:.0f} % of its samples), "
            "so the validation is not independent. Validate on another record"
        )
    return (
        f"the estimates were made from {finding.percent:.2g} % of the samples of this record, so "
        "the validation is not independent. Validate on the other samples"
    )


@sentence.register
def equation_error_on_record(finding: EquationErrorOnRecord) -> str:
    """Return the equation error on the second record, with the methods for which it is too large.

    It is too large above both an absolute limit and a multiple of the error on the record of the
    identification.
    """
    limits = (
        f"{finding.max_percent:g} % of the force and {finding.max_ratio:g} times the error on the "
        "record of the identification"
    )
    if not finding.failed:
        return (
            "the equation error (rms), minus its part by chance, is at most "
            f"{finding.largest_percent:.3g} % of the force. It does not exceed both {limits}"
        )
    return (
        f"{_methods_do(finding.failed)} not hold on this record: the equation error (rms) is "
        f"{finding.largest_percent:.3g} % of the force, above both {limits}. "
        "Check that the record is of the same axis, and check its units and signs"
    )


@sentence.register
def simulation_on_record(finding: SimulationOnRecord) -> str:
    """Return the error of the simulated loop on the second record, with the methods that fail.

    The error is relative to the tracking error if the position is compared, else to the force.
    """
    position = _percent(finding.tracking_error_percent, "the tracking error")
    if not finding.failed:
        return (
            "the simulated closed loops reproduce the recorded motion (position error at most "
            f"{position}, rms)"
        )
    if finding.by_position:
        own = _percent(finding.own_tracking_error_percent, "its tracking error")
        error = f"the simulated position differs by {position} (rms)"
    else:
        own = _percent(finding.own_simulation_error_percent, "its force")
        force = _percent(finding.simulation_error_percent, "the force")
        error = f"the simulated force differs by {force} (rms)"
    injected = setting("columns", {"injected": "NAME"})
    return (
        f"{_methods_do(finding.failed)} not hold on this record: {error}, on the record of the "
        f"identification by {own}. Check the gains and the period of the control law. If a test "
        f"signal was added, name it with {injected} and injected_at in run.toml"
    )


@sentence.register
def reestimated_parameters(finding: ReestimatedParameters) -> str:
    """Return the parameters that differ in the second record, with the effect on the force."""
    force = f"{finding.largest_percent:.2g} % of the force"
    if not finding.failed:
        return (
            "parameters estimated from this record differ by no more than chance or a negligible "
            f"force ({force}, rms)"
        )
    changed = differing(finding.changed, "this record", "the result")
    load = ""
    if any(each.is_load for each in finding.changed):
        load = ", as with another load"
    return (
        f"{_methods_do(finding.failed)} not hold on this record: {changed}{load}. The effect of "
        f"the difference is {force} (rms). Check the load and other changes of the machine, and "
        "check that friction and motion are within the range of the model"
    )


def _percent(value: float | None, of: str) -> str:
    """Return a percentage of the quantity `of`; an unknown part of it for None."""
    if value is None:
        return f"an unknown part of {of}"
    return f"{value:.3g} % of {of}"


def _methods_do(names: tuple[str, ...]) -> str:
    """Return methods with their verb: ``IDM-IV does`` or ``IDM-IV and DIDIM do``."""
    return f"{listed([name.upper() for name in names])} {'does' if len(names) == 1 else 'do'}"


@sentence.register
def estimates_hold(finding: EstimatesHold) -> str:
    """Return the statement that the estimates hold, with the checks that passed.

    Without estimates from the second record, small changes of the parameters stay possible.
    """
    passed = "; ".join(sentence(each) for each in finding.passed)
    if finding.is_reestimated:
        return f"the estimates hold: {passed}"
    return (
        f"no check contradicts the estimates: {passed}. The parameters could not be estimated from "
        "this record, so small changes of them are not excluded"
    )


@sentence.register
def estimates_do_not_hold(finding: EstimatesDoNotHold) -> str:
    """Return the lines with a failed check in the verdict of the validation."""
    lines = listed(finding.failed)
    return (
        f"the estimates do not hold on the second record ({lines}). See the verdict of the "
        "validation"
    )


@sentence.register
def no_simulation(finding: NoSimulation) -> str:
    """Return the reason why no closed loop was simulated."""
    return f"no simulation: {finding.reason}"


@sentence.register
def sample_periods(finding: SamplePeriods) -> str:
    """Return the sample periods of the record and of the fit; a difference has an instruction."""
    if finding.are_equal:
        return f"the sample period of {finding.of_record:.6g} s is the same as for the fit"
    return (
        f"the record is sampled every {finding.of_record:.6g} s, the records of the fit every "
        f"{finding.of_fit:.6g} s. Check that the record is of the same axis and drive"
    )


@sentence.register
def output_on_record(finding: OutputOnRecord) -> str:
    """Return the error of the simulated output on the second record and on the fitted records."""
    text = (
        f"the difference between simulated and recorded {finding.output} is {finding.percent:.3g} "
        f"% of the recorded {finding.output} (rms), on the fitted records at most "
        f"{finding.own_percent:.3g} %"
    )
    return text if finding.holds else f"{text}. Check that the axis and the load are the same"
