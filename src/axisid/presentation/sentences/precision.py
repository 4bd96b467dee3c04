"""Sentences of the checks of parameters: their precision, bounds and declared values."""

from collections.abc import Sequence

from axisid.estimation.diagnostics import (
    BeyondBounds,
    FarFromNominalValues,
    FewRows,
    FixedAtBounds,
    FixedValue,
    FixedValues,
    IdentifiedGain,
    OutsideBounds,
    Precision,
    RelativeError,
    Unidentified,
    WithinBounds,
)
from axisid.estimation.estimation_problem import ParameterAtBound
from axisid.support.settings import setting
from axisid.support.wording import range_text

from .dispatch import sentence
from .words import capitalised, listed, one_after_another

_OF_INTERVAL = "The 95 % interval"


@sentence.register
def few_rows(finding: FewRows) -> str:
    """Return the numbers of rows and parameters, and how to get more rows."""
    rows = "1 row is" if finding.rows == 1 else f"{finding.rows} rows are"
    text = f"{rows} too few for standard errors of {finding.parameters} parameters"
    if finding.samples_per_row is None:
        return f"{text}. Record a longer motion or use a smaller {setting('decimate', 'FACTOR')}"
    return (
        f"{text}; one sample in {finding.samples_per_row} counts as a row, because its neighbours "
        "add little information. Fit a longer part of the record"
    )


@sentence.register
def precision(finding: Precision) -> str:
    """Return the largest relative standard error, or which parameters are not identified, why."""
    texts = [_unidentified(each) for each in finding.unidentified]
    if finding.negligible:
        texts.append(negligible_text(finding.negligible, "of the force"))
    if not finding.unidentified and finding.has_others:
        texts.append(largest_error_text(finding.largest_percent, bool(finding.negligible)))
    return one_after_another(texts)


def largest_error_text(percent: float | None, except_some: bool) -> str:
    """Return the largest relative standard error of all parameters, or of all others."""
    every = "every other parameter" if except_some else "every parameter"
    if percent is None:
        return f"{every} has a small standard error"
    return f"{every} has a relative standard error of at most {percent:.3g} %"


def negligible_text(parameters: Sequence[RelativeError], of: str) -> str:
    """Return which parameters cannot be distinguished from zero, and that they are small.

    Parameters
    ----------
    parameters : sequence of RelativeError
    of : str
        The rest of "less than 1 % ...".
    """
    names = listed([each.name for each in parameters])
    errors = listed([error_text(each) for each in parameters])
    if len(parameters) == 1:
        return (
            f"the parameter {names} cannot be distinguished from zero (relative standard error "
            f"{errors}) and accounts for less than 1 % {of}"
        )
    return (
        f"the parameters {names} cannot be distinguished from zero (relative standard errors "
        f"{errors}); each accounts for less than 1 % {of}"
    )


def error_text(error: RelativeError) -> str:
    """Return a relative standard error with its unit."""
    return "infinite" if error.percent is None else f"{error.percent:.3g} %"


def _unidentified(found: Unidentified) -> str:
    """Return which parameters a record does not identify, the reason, and a remedy."""
    names = [each.name for each in found.parameters]
    errors = listed([error_text(each) for each in found.parameters])
    if len(names) == 1:
        text = (
            f"the parameter {names[0]} is not identified by this record (relative standard error "
            f"{errors}), because {_reason(found)}"
        )
    else:
        text = (
            f"the parameters {listed(names)} are not identified by this record (relative standard "
            f"errors {errors}), because {_reason(found)}"
        )
    lacking = f": {', and '.join(found.lacking)}" if found.lacking else ""
    return f"{text}{lacking}. {_remedy(found)}"


def _reason(found: Unidentified) -> str:
    """Return why the record does not determine the parameters."""
    several = len(found.parameters) > 1
    whose = "their" if several else "its"
    if found.reason == "repeated column":
        verb = "columns nearly repeat those" if several else "column nearly repeats that"
        return f"{whose} {verb} of {listed(found.alike)}"
    if found.reason == "few rows":
        acts = "they act" if several else "it acts"
        return f"{acts} in few rows (equivalent to {found.rows:.2g})"
    if found.reason == "cancelled":
        return f"other terms cancel {whose} part of the force"
    return f"{whose} part of the force is below the residual"


def _remedy(found: Unidentified) -> str:
    """Return what to record or to fix so that the parameters are determined."""
    name = found.parameters[0].name
    fixed = setting("fix", {name: "VALUE"})
    if found.lacking:
        return f"Record a motion without this limitation, or fix a known value with {fixed}"
    if found.reason == "repeated column":
        return f"Fix a known value with {fixed}, or record a motion that separates them"
    if found.reason == "few rows":
        return f"Record a motion in which {name} acts longer, or fix a known value with {fixed}"
    if found.reason == "cancelled":
        return f"Record another motion, or fix a known value with {fixed}"
    return (
        f"Add the missing terms to the model, record a motion in which {name} acts more, or fix a "
        f"known value with {fixed}"
    )


@sentence.register
def within_bounds(finding: WithinBounds) -> str:
    """Return that all parameters are within their bounds."""
    return f"every parameter with declared bounds is within them ({listed(finding.parameters)})"


@sentence.register
def beyond_bounds(finding: BeyondBounds) -> str:
    """Return the parameters that are not within their bounds, and what to look at."""
    text = "; ".join(_outside(each) for each in finding.parameters)
    if finding.rest is not None:
        return f"{text}. {capitalised(sentence(finding.rest))}"
    if finding.advice == "interval reaches within":
        each = "of each" if len(finding.parameters) > 1 else "of the value"
        return (
            f"{text}. {_OF_INTERVAL} {each} reaches within the bounds. Fix it at the bound with "
            f"{setting('bounded', True)}"
        )
    if finding.advice == "other candidates explain more":
        return (
            f"{text}. Its parameters take up terms that this model lacks and other candidates have"
        )
    return f"{text}. Check the signs and units of the record and the drive gain"


def _outside(found: OutsideBounds) -> str:
    where = "at a bound of" if found.is_at_bound else "outside its bounds"
    return (
        f"{found.name} = {found.value:.6g} {found.unit} is {where} "
        f"[{found.lower:g}, {found.upper:g}]"
    )


@sentence.register
def fixed_at_bounds(finding: FixedAtBounds) -> str:
    """Return the parameters at their bounds, their free values, and what contradicts a bound."""
    text = "; ".join(_at_bound(each) for each in finding.parameters)
    if finding.advice is None:
        return text
    text = f"{text}; this is {finding.distance:.2g} standard errors beyond the bound"
    if finding.rest is not None:
        return f"{text}. {capitalised(sentence(finding.rest))}"
    return f"{text}. Check the signs and units of the record, and missing terms of the model"


def _at_bound(found: ParameterAtBound) -> str:
    """Return which parameter is at its bound, with its estimate without the bound."""
    text = (
        f"{found.name} is fixed at its bound {found.bound:g} {found.unit}; without the bound it is "
        f"{found.free:.4g} +- {found.deviation:.2g} {found.unit}"
    )
    if found.reach == found.bound:
        return f"{text}, so that the one-sided 95 % interval has no room next to the bound"
    low, high = sorted((found.bound, found.reach))
    return f"{text} (one-sided 95 % interval {range_text(low, high, ' to ')} {found.unit})"


@sentence.register
def fixed_values(finding: FixedValues) -> str:
    """Return whether the record agrees with the fixed values, with both and the test."""
    test = (
        f"Hotelling's T squared {finding.statistic:.3g} with {finding.restrictions} "
        f"restriction{'' if finding.restrictions == 1 else 's'}, p = {finding.p_value:.2g}"
    )
    if finding.agree and not finding.values:
        return f"the record agrees with the physical parameters ({test})"
    if finding.agree:
        return f"the record agrees with the fixed values ({test})"
    if not finding.values:
        text = f"no values of the physical parameters agree with the record ({test})"
    else:
        values = "; ".join(_fixed_value(each) for each in finding.values)
        text = f"the record contradicts the fixed values ({test}): {values}"
    if not finding.is_bias_known:
        text += (
            ". The bias of the estimate, which could be the cause too, is unknown without a "
            "control law"
        )
    return f"{text}. Check the fixed values, the drive gain and the terms of the model"


def _fixed_value(found: FixedValue) -> str:
    """Return a fixed value and, if it is known, the value that the record alone gives."""
    text = f"{found.name} is fixed at {found.value:g}"
    if found.standard_error:
        text += f" +- {found.standard_error:g}"
    text = f"{text} {found.unit}"
    if found.of_record is None:
        return text
    return (
        f"{text}, the record alone gives {found.of_record:.4g} "
        f"+- {found.standard_error_of_record:.2g} {found.unit}"
    )


@sentence.register
def far_from_nominal(finding: FarFromNominalValues) -> str:
    """Return the values with their ratios to the nominal values, and what to check."""
    values = [
        f"{each.name} = {each.value:.4g} {each.unit} is {each.ratio:.2g} times its nominal value "
        f"{each.nominal:.4g} {each.unit}"
        for each in finding.parameters
    ]
    return (
        f"{', '.join(values)}. Check the units of the record's columns and the drive gain, or "
        "declare another nominal value"
    )


@sentence.register
def identified_gain(finding: IdentifiedGain) -> str:
    """Return the identified gain, its difference from the declared one, and what to do."""
    unit = finding.unit
    gain = f"the identified drive gain {finding.identified:.5g} +- {finding.standard_error:.2g}"
    gain = f"{gain} {unit}"
    apart = ""
    if finding.distance is not None:
        apart = f" ({finding.distance:.2g} standard errors)"
    if finding.agreement == "same":
        return f"{gain} agrees with the declared {finding.declared:.5g} {unit}{apart}"
    percent = 100 * (finding.identified / finding.declared - 1)
    text = (
        f"{gain} differs from the declared {finding.declared:g} {unit} by {percent:+.2g} %{apart}"
    )
    if finding.agreement == "near":
        return (
            f"{text}. The parameters are relative to the identified gain. Declare it for records "
            "without a known force"
        )
    return f"{text}. Check that the known values are in the order of the records, and their units"
