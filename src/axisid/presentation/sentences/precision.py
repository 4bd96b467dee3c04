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
    """Return the numbers of rows and parameters, and the instruction for more rows."""
    rows = "1 row is" if finding.rows == 1 else f"{finding.rows} rows are"
    text = f"{rows} too few for standard errors of {finding.parameters} parameters"
    if finding.samples_per_row is None:
        return f"{text}. Record a longer motion or use a smaller {setting('decimate', 'FACTOR')}"
    return (
        f"{text}: only one sample in {finding.samples_per_row} counts as a row, because "
        "neighbouring samples add little information. Fit a longer part of the record"
    )


@sentence.register
def precision(finding: Precision) -> str:
    """Return the parameters that are not identified, with reasons and remedies.

    If all are identified, it is the largest relative standard error.
    """
    texts = [_unidentified(each) for each in finding.unidentified]
    if finding.negligible:
        texts.append(negligible_text(finding.negligible, "of the force"))
    if not finding.unidentified and finding.has_others:
        texts.append(largest_error_text(finding.largest_percent, bool(finding.negligible)))
    return one_after_another(texts)


def largest_error_text(percent: float | None, except_some: bool) -> str:
    """Return the statement on the largest relative standard error, in percent.

    `except_some` is True if the statement excludes parameters that were named before. Without a
    percentage (None) the standard errors are called small.
    """
    every = "every other parameter" if except_some else "every parameter"
    if percent is None:
        return f"{every} has a small standard error"
    return f"{every} has a relative standard error of at most {percent:.3g} %"


def negligible_text(parameters: Sequence[RelativeError], of: str) -> str:
    """Return the statement that parameters cannot be distinguished from zero and are negligible.

    Parameters
    ----------
    parameters : sequence of RelativeError
    of : str
        Quantity that they are less than 1 % of, for example "of the force".
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
    """Return a relative standard error in percent; ``infinite`` for None."""
    return "infinite" if error.percent is None else f"{error.percent:.3g} %"


def _unidentified(found: Unidentified) -> str:
    """Return the parameters that a record does not identify, with the reason and the remedies."""
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
    """Return the reason why the record does not identify the parameters, as a clause."""
    several = len(found.parameters) > 1
    whose = "their" if several else "its"
    if found.reason == "repeated column":
        if several:
            return f"their regressors are nearly collinear with those of {listed(found.alike)}"
        return f"its regressor is nearly collinear with that of {listed(found.alike)}"
    if found.reason == "few rows":
        acts = "they act" if several else "it acts"
        return f"{acts} in few rows (equivalent to {found.rows:.2g} rows of equal weight)"
    if found.reason == "cancelled":
        return f"other terms cancel {whose} part of the force"
    return f"{whose} part of the force is smaller than the residual"


def _remedy(found: Unidentified) -> str:
    """Return the instruction with which the parameters can be identified."""
    name = found.parameters[0].name
    fixed = setting("fix", {name: "VALUE"})
    if found.lacking:
        return f"Record a motion without this limitation, or fix a known value with {fixed}"
    if found.reason == "repeated column":
        return f"Fix a known value with {fixed}, or record a motion that separates these parameters"
    if found.reason == "few rows":
        return f"Record a motion in which {name} acts longer, or fix a known value with {fixed}"
    if found.reason == "cancelled":
        return f"Record another motion, or fix a known value with {fixed}"
    return (
        "Add the missing terms to the model, record a motion in which the force of "
        f"{name} is a larger part of the total force, or fix a known value with {fixed}"
    )


@sentence.register
def within_bounds(finding: WithinBounds) -> str:
    """Return the statement that all parameters with declared bounds are within them."""
    return f"every parameter with declared bounds is within them ({listed(finding.parameters)})"


@sentence.register
def beyond_bounds(finding: BeyondBounds) -> str:
    """Return sentences on the parameters that are not within their bounds, and an instruction.

    The instruction follows from the likely cause (`advice` of the finding). If long standstill is
    the likely cause (`rest` is not None), the text of that finding is the instruction. If other
    candidates explain more, the cause is named without an instruction.
    """
    text = "; ".join(_outside(each) for each in finding.parameters)
    if finding.rest is not None:
        return f"{text}. {capitalised(sentence(finding.rest))}"
    if finding.advice == "interval reaches within":
        values, parameters = "of the value", "the parameter"
        if len(finding.parameters) > 1:
            values, parameters = "of each value", "the parameters"
        return (
            f"{text}. {_OF_INTERVAL} {values} reaches within the bounds. Fix {parameters} at the "
            f"bound with {setting('bounded', True)}"
        )
    if finding.advice == "other candidates explain more":
        return (
            f"{text}. The parameters of this model compensate for terms that it lacks and other "
            "candidates contain"
        )
    return f"{text}. Check the signs and units of the record and the drive gain"


def _outside(found: OutsideBounds) -> str:
    """Return the statement that a parameter is outside its bounds, or at one of them."""
    where = "at a bound of" if found.is_at_bound else "outside its bounds"
    return (
        f"{found.name} = {found.value:.6g} {found.unit} is {where} "
        f"[{found.lower:g}, {found.upper:g}]"
    )


@sentence.register
def fixed_at_bounds(finding: FixedAtBounds) -> str:
    """Return the sentence on parameters that are fixed at a bound, with their free estimates.

    If the record contradicts a bound (`advice` is not None), a sentence with the largest distance
    and an instruction follow. The instruction is to check signs, units and model. If `rest` is not
    None, long standstill is the likely cause, and the text of this finding replaces the
    instruction.
    """
    text = "; ".join(_at_bound(each) for each in finding.parameters)
    # Without advice, the distances beyond the bounds are within chance.
    if finding.advice is None:
        return text
    text = (
        f"{text}. The farthest estimate is {finding.distance:.2g} standard errors beyond its bound"
    )
    if finding.rest is not None:
        return f"{text}. {capitalised(sentence(finding.rest))}"
    return f"{text}. Check the signs and units of the record, and the model for missing terms"


def _at_bound(found: ParameterAtBound) -> str:
    """Return the parameter that is fixed at its bound, with its estimate without the bound."""
    text = (
        f"{found.name} is fixed at its bound {found.bound:g} {found.unit}; without the bound it is "
        f"{found.free:.4g} +- {found.deviation:.2g} {found.unit}"
    )
    if found.reach == found.bound:
        return f"{text} (the one-sided 95 % interval has no width, because it ends at the bound)"
    low, high = sorted((found.bound, found.reach))
    return f"{text} (one-sided 95 % interval {range_text(low, high, ' to ')} {found.unit})"


@sentence.register
def fixed_values(finding: FixedValues) -> str:
    """Return the result of the test of the fixed values; contradictions have both values."""
    restrictions = "restriction" if finding.restrictions == 1 else "restrictions"
    test = (
        f"Hotelling's T squared {finding.statistic:.3g} with {finding.restrictions} "
        f"{restrictions}, p = {finding.p_value:.2g}"
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
            ". The bias of the estimate may be another cause, but it is unknown without a control "
            "law"
        )
    return f"{text}. Check the fixed values, the drive gain and the terms of the model"


def _fixed_value(found: FixedValue) -> str:
    """Return a fixed value and, unless it is None, the estimate from the record alone."""
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
    """Return the values with their ratios to the nominal values, and the instruction."""
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
    """Return the identified gain, its difference from the declared gain, and the instruction.

    A difference without a distance in standard errors (None) has no such number.
    """
    unit = finding.unit
    gain = (
        f"the identified drive gain {finding.identified:.5g} +- {finding.standard_error:.2g} {unit}"
    )
    distance = ""
    if finding.distance is not None:
        distance = f" ({finding.distance:.2g} standard errors)"
    if finding.agreement == "same":
        return f"{gain} agrees with the declared {finding.declared:.5g} {unit}{distance}"
    percent = 100 * (finding.identified / finding.declared - 1)
    text = (
        f"{gain} differs from the declared {finding.declared:g} {unit} by {percent:+.2g} %"
        f"{distance}"
    )
    if finding.agreement == "near":
        return (
            f"{text}. The parameters are relative to the identified gain. Declare this gain for "
            "records without a known force"
        )
    return (
        f"{text}. Check the units of the known values, and that they are in the order of the "
        "records"
    )
