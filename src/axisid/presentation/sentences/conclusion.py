"""The headline of a verdict: the conclusion on the use of the numbers, then its reason."""

from axisid.estimation.diagnostics import MovedParameter
from axisid.estimation.findings import Finding, FindingOfRecords, ReadFinding
from axisid.estimation.verdict_checks import Conclusion

from .words import listed

#: Reason of a headline by the name of the check that fails.
_REASONS = {
    "control law": "the recorded control does not follow the declared control law",
    "law's factors": "an error of the declared control law changes the parameters too much",
    "noise gain": "the noise in the control does not follow the declared control law",
    "force against control": "the measured force does not match the control",
    "drive gain": "the identified drive gain contradicts the declared one",
    "time base": "the time column contradicts the sampling period",
    "sudden steps": "the position has sudden steps",
    "alignment": "force and motion are not aligned in time",
    "recorded signals": "a recorded signal is late or wrongly scaled",
    "simulation": "the simulation does not reproduce the record",
    "windows": "the windows of the open loop are too long or too few",
    "measured velocity": "the measured velocity does not match the position",
    "measured acceleration": "the measured acceleration does not match the position",
    "control against limit": "the recorded control exceeds the limit of the drive",
    "equation error": "the estimates do not explain the force of the record",
    "missing terms": "the model leaves part of the force unexplained",
    "fixed values": "the record contradicts the fixed values",
    "what was known": "the record contradicts a prior value",
    "moved parameters": "an error of the model changes a parameter too much",
    "outliers": "the record has outliers",
    "parameters shown": "the record does not determine every parameter",
    "bounds": "a parameter contradicts its declared bounds",
    "rows": "there are too few rows for the number of parameters",
    "convergence": "the search did not converge",
    "precision": "the record does not identify every parameter",
    "physical parameters": "no physical parameters agree with the record",
    "records alike": "the records do not have the same parameters",
    "repeated records": "samples are used more than once",
    "instrument strength": "the instruments are weak",
    "method": "the methods disagree",
    "inverse against direct": "the inverse and the direct model disagree",
    "recommendation": "no result can be recommended",
    "validation": "the estimates do not hold on the second record",
    "result": "the result is not usable",
}
#: Remedy by the name of a check that was not made although the numbers rely on it.
_REMEDIES = {
    "control law": "To check the control law, log the reference, the position and the control at "
    "each evaluation of the law, with all their digits, during a motion within the drive's limit.",
    "simulation": "To check the simulated loop, log the reference.",
    "noise in the loop": "To find the bias by noise in the loop, log the control or the force, and "
    "record a longer motion.",
    "missing terms": "To check the model for missing terms, log the control or the force during a "
    "longer motion, or validate the result with another record.",
}
#: Longer names of some lines of a verdict, for use within a sentence.
_SUBJECTS = {
    "law": "control law",
    "loop": "simulated loop",
    "records": "agreement of the records",
    "method": "agreement of the methods",
}


def conclusion_text(conclusion: Conclusion) -> str:
    """Return the headline of a verdict as complete sentences.

    It has the conclusion and its reason, then the lines that were not checked, then the remedies
    for checks that the numbers rely on.
    """
    headline = _headline(conclusion)
    if conclusion.belief == "not believed" or not conclusion.unchecked:
        return headline
    texts = [headline]
    lines = [_subject(line) for line in conclusion.unchecked]
    if conclusion.failed or conclusion.belief == "believed":
        texts.append(f"Not checked: {', '.join(lines)}.")
    texts += [_REMEDIES[name] for name in conclusion.left_open if name in _REMEDIES]
    return " ".join(texts)


def _headline(conclusion: Conclusion) -> str:
    """Return the first sentence: how far the numbers can be used, and the reason."""
    if conclusion.belief == "not believed":
        return f"Do not use these numbers: {_reason(conclusion)}."
    if conclusion.failed:
        return f"Use with care: {_reason(conclusion)}."
    if conclusion.belief == "with care":
        lines = [_subject(line) for line in conclusion.unchecked]
        were = "was" if len(lines) == 1 else "were"
        return f"Use with care: the {listed(lines)} {were} not checked."
    if conclusion.unchecked:
        return "All checks that were made passed."
    return "All checks passed."


def _reason(conclusion: Conclusion) -> str:
    """Return the reason: the decisive failed check in plain words, or the lines of several."""
    name = conclusion.decisive
    if name is None:
        if conclusion.belief == "not believed":
            return f"correct {listed(conclusion.first)} first"
        return f"the checks of {listed(conclusion.failed)} failed"
    if conclusion.is_faulty:
        return f"the check {name!r} could not be made because of a fault"
    if name == "moved parameters" and (reason := _moved_reason(conclusion.finding)):
        return reason
    return _REASONS.get(name, f"the check {name!r} failed")


def _moved_reason(finding: Finding | None) -> str:
    """Return the parameter that changes too much, and its change; empty if it is not known."""
    if isinstance(finding, FindingOfRecords):
        finding = finding.finding
    if isinstance(finding, MovedParameter):
        name, percent, is_changing = finding.parameter, finding.percent, finding.is_changing
    elif isinstance(finding, ReadFinding):
        data = finding.data
        if data.get("kind") == FindingOfRecords.__name__:
            data = data["finding"]
        if data.get("kind") != MovedParameter.__name__:
            return ""
        name, percent, is_changing = data["parameter"], data["percent"], data["is_changing"]
    else:
        return ""
    if is_changing:
        return f"{name} changes by {percent:.2g} % of its value in the record"
    return f"a missing term of the model changes {name} by {percent:.2g} % of its value"


def _subject(line: str) -> str:
    """Return the name of a line of the verdict within a sentence."""
    return _SUBJECTS.get(line, line)
