"""Sentences of the checks of a fit by output error."""

from axisid.estimation.diagnostics.control_law import CONSTANT, DRIFT, GAINS, SCALE
from axisid.estimation.output_error import (
    EndOfSearch,
    EndsOfSearches,
    FitPrecision,
    LawSensitivity,
    MovedByLaw,
    NoParameterAtBound,
    OpenLoopWindows,
    OtherCauseOfMissingTerms,
    PriorAndRecord,
    SamplesNearRests,
    ShownParameters,
    SimulatedOutput,
    UnseenDirection,
)
from axisid.support.settings import setting

from .dispatch import sentence
from .precision import error_text, largest_error_text, negligible_text
from .words import capitalised, listed, one_after_another

#: Differences between the recorded control and the law, as nouns.
_DIFFERENCES = {
    GAINS: "different gains of the law",
    SCALE: "another scale of the recorded control",
    CONSTANT: "a constant on the recorded control",
    DRIFT: "a drift of the recorded control",
}
#: Instructions for those differences that a user corrects in the record.
_REMEDIES = {
    SCALE: "check the unit and the scaling of the recorded control",
    CONSTANT: "check the offset of the recorded control and the zero of the position",
    DRIFT: "check the recorded control for a drift",
}


@sentence.register
def moved_by_law(finding: MovedByLaw) -> str:
    """Return the difference of law and control, the parameter that it changes most, and a remedy.

    The remedy is omitted if the finding has no correction.
    """
    differences = listed([_DIFFERENCES[each] for each in finding.differences])
    amount = f"{finding.distance:.2g} standard errors"
    if finding.percent is not None:
        amount = f"{finding.percent:.2g} % of its value ({amount})"
    is_plural = len(finding.differences) > 1 or GAINS in finding.differences
    verb = "change" if is_plural else "changes"
    text = f"{differences} {verb} {finding.parameter} by {amount}"
    correction = finding.correction
    if correction is None:
        return text
    remedies = [_REMEDIES[each] for each in finding.differences if each != GAINS]
    if correction.term is None or correction.factor is None:
        return f"{text}. {capitalised(listed(remedies))}"
    text = (
        f"{text}. The largest part comes from {correction.term}, which is {correction.factor:.5g} "
        "times the declared value in the record"
    )
    remedies.append(f"fit the law's gains too with {setting('free', 'GAIN')}")
    if correction.follows_position_alone:
        remedies.append(f"fit the control with {setting('output', 'control')}")
    return (
        f"{text}. Correct {correction.term} in the declared law, {', '.join(remedies)}, or "
        "identify with instruments, which need no exact law"
    )


@sentence.register
def law_sensitivity(finding: LawSensitivity) -> str:
    """Return the change of a parameter by an error of the law; a large one has an instruction."""
    text = (
        f"an error of 1 % in the law's {finding.term} changes {finding.parameter} by "
        f"{finding.percent:.2g} % of its value"
    )
    if not finding.is_large:
        return text
    return (
        f"{text}, so the parameters depend on an exact law. Check the gains of the declared law, "
        f"or fit the control with {setting('output', 'control')}"
    )


@sentence.register
def end_of_search(finding: EndOfSearch) -> str:
    """Return the end of the search, and the instruction to continue if it did not converge."""
    steps = "1 step" if finding.steps == 1 else f"{finding.steps} steps"
    if finding.state == "converged":
        return f"the search converged after {steps}"
    if finding.state == "interrupted":
        return (
            f"the search was interrupted after {steps}, and the values are the best so far. Fit "
            "again and start from these values"
        )
    return (
        f"the search did not converge within {steps}. Start from other values, or leave out "
        f"parameters that the record does not determine with {setting('leave_out', 'NAME')}"
    )


@sentence.register
def ends_of_searches(finding: EndsOfSearches) -> str:
    """Return the number of searches that ended at the best minimum."""
    return (
        f"{finding.at_best} of {finding.searches} searches ended at the best minimum; the other "
        "searches ended at higher costs"
    )


@sentence.register
def open_loop_windows(finding: OpenLoopWindows) -> str:
    """Return the statement on length and number of the windows, and the horizon to use."""
    if finding.state == "growing":
        return (
            f"errors grow by more than a factor of {finding.max_growth:g} in windows of "
            f"{finding.horizon:g} s, as with friction that falls with the velocity. Use "
            f"{setting('horizon', f'{finding.steady_horizon:g}')}"
        )
    if finding.state == "few":
        windows = "1 window is" if finding.windows == 1 else f"{finding.windows} windows are"
        return (
            f"{windows} too few for standard errors and for a search for missing terms (advised: "
            f"{finding.advised_windows} or more; a window is {finding.horizon:g} s long). Fit a "
            f"longer record, or use shorter windows with {setting('horizon', 'SECONDS')}"
        )
    return f"windows of {finding.horizon:g} s are so short that errors do not grow in them"


@sentence.register
def simulated_output(finding: SimulatedOutput) -> str:
    """Return the error of the simulated output, in all and beyond noise.

    A percentage is None if the recorded output is zero.
    """
    output = finding.output
    if finding.percent is None or finding.percent_beyond_noise is None:
        error = f"the recorded {output} is zero, but the simulated {output} is not"
    else:
        error = (
            f"the difference between simulated and recorded {output} is {finding.percent:.3g} % of "
            f"the recorded {output} (rms); {finding.percent_beyond_noise:.2g} % is not noise"
        )
    if finding.follows:
        return error
    return (
        f"the simulation does not reproduce the record: {error}. Check the model, the control "
        "law, units and signs"
    )


@sentence.register
def other_cause_of_missing_terms(finding: OtherCauseOfMissingTerms) -> str:
    """Return the other failed check that may cause the apparent missing terms."""
    if not finding.bounds:
        return (
            "the recorded control does not follow the declared law. This may cause apparent "
            "missing terms. Correct the law first"
        )
    bounds = "bound" if len(finding.bounds) == 1 else "bounds"
    return (
        f"the record contradicts the {bounds} of {listed(finding.bounds)}. This may cause apparent "
        f"missing terms. Correct the {bounds} first"
    )


@sentence.register
def samples_near_rests(finding: SamplesNearRests) -> str:
    """Return the share of samples without weight near a standstill, or that all have weight."""
    if finding.percent_left_out:
        return (
            f"{finding.percent_left_out:.2g} % of the samples have no weight, because they are "
            "near a standstill or a velocity reversal of the record or of its simulated loop, "
            "where sticking friction can have any value"
        )
    return (
        "samples near a standstill or a velocity reversal have weight, because the other samples "
        "hardly determine a parameter. With an encoder these samples bias the fit. Record longer "
        "or faster moves"
    )


@sentence.register
def prior_and_record(finding: PriorAndRecord) -> str:
    """Return the prior value, the value from the record, and their distance.

    Values that contradict each other come with an instruction. The value from the record is omitted
    if it is None.
    """
    unit = finding.unit
    record = "the record"
    if finding.of_record is not None and finding.standard_error_of_record is not None:
        record = (
            f"the record alone ({finding.of_record:.6g} +- "
            f"{finding.standard_error_of_record:.2g} {unit})"
        )
    text = (
        f"the prior value of {finding.parameter} ({finding.prior:.6g} +- "
        f"{finding.standard_error:.2g} {unit}) and {record} differ by {finding.distance:.2g} "
        "standard errors"
    )
    if finding.agree:
        return text
    return f"{text} and contradict each other. Correct the prior value, the record or the model"


@sentence.register
def shown_parameters(finding: ShownParameters) -> str:
    """Return the parameters that no output determines, and the remedies."""
    outputs = listed(finding.outputs)
    determine, do_not = "determines", "does not determine"
    if len(finding.outputs) > 1:
        determine, do_not = "determine", "do not determine"
    if not finding.unseen:
        return f"the {outputs} {determine} every parameter"
    unseen = "; nor ".join(unseen_text(each) for each in finding.unseen)
    fixed = setting("fix", {finding.unseen[0].parameters[0]: "VALUE"})
    return (
        f"the {outputs} {do_not} {unseen}. Fix a known value with {fixed}, or record another motion"
    )


def unseen_text(direction: UnseenDirection) -> str:
    """Return a direction of the parameters that no output determines, as a phrase.

    For one parameter it is ``Fc at all``, for several ``M and m separately (...)``.
    """
    names = direction.parameters
    if len(names) == 1:
        return f"{names[0]} at all"
    changes = ", ".join(
        f"{change:+.3g} of {name}" for change, name in zip(direction.changes, names, strict=True)
    )
    return f"{listed(names)} separately (the joint change {changes} has no effect)"


@sentence.register
def fit_precision(finding: FitPrecision) -> str:
    """Return the parameters that are not identified, or the largest relative standard error."""
    texts = []
    if finding.unidentified:
        names = listed([each.name for each in finding.unidentified])
        errors = listed([error_text(each) for each in finding.unidentified])
        is_single = len(finding.unidentified) == 1
        plural = "" if is_single else "s"
        verb = "is" if is_single else "are"
        fixed = setting("fix", {finding.unidentified[0].name: "VALUE"})
        texts.append(
            f"the parameter{plural} {names} {verb} not identified by the fitted output (relative "
            f"standard error{plural} {errors}). Record another motion, or fix a known value with "
            f"{fixed}"
        )
    if finding.negligible:
        of = "of the largest change of the output by a parameter"
        texts.append(negligible_text(finding.negligible, of))
    if not finding.unidentified and finding.has_others:
        texts.append(largest_error_text(finding.largest_percent, bool(finding.negligible)))
    return one_after_another(texts)


@sentence.register
def no_parameter_at_bound(finding: NoParameterAtBound) -> str:  # noqa: ARG001
    """Return that no parameter is at a bound."""
    return "no parameter is at a bound"
