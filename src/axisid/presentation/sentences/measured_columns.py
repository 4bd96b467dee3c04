"""Sentences of the checks that compare a measured column with a computed one."""

from axisid.estimation.diagnostics import (
    ColumnCorrections,
    ControlAgainstLimit,
    ForceAgainstControl,
    MeasuredMotion,
)
from axisid.estimation.records import advised_interpolation
from axisid.support.settings import setting

from .dispatch import sentence
from .words import one_after_another

# Smallest uncertainties that are printed.
_LEAST_FACTOR_UNCERTAINTY = 1e-4
_LEAST_DELAY_UNCERTAINTY = 1e-2  # samples


@sentence.register
def force_against_control(finding: ForceAgainstControl) -> str:
    """Return the difference between recorded and computed force, and the instruction to check.

    The computed force is the drive gain times the control, or the drive model applied to it.
    """
    computed, to_check = "the force that the drive model gives for the control", "the drive"
    if finding.gain is not None:
        computed, to_check = "drive gain times control", "the gain"
    percent = f"{finding.difference_percent:.3g} % of {computed}, rms"
    if finding.fault is None:
        return f"the force column agrees with {computed}: the difference is {percent}"
    if finding.fault == "scale":
        uncertainty = max(finding.factor_uncertainty, _LEAST_FACTOR_UNCERTAINTY)
        return (
            f"the force column is {finding.factor:.4g} +- {uncertainty:.1g} times {computed}, and "
            f"otherwise agrees with it (total difference: {percent}). Every parameter is scaled by "
            f"this factor. Check the scale of the force column and {_drive(finding)}, or declare "
            "the uncertainty of the gain with relative_sd"
        )
    if finding.fault == "offset":
        return (
            f"the force column differs from {computed} by a constant of {finding.offset:+.4g} +- "
            f"{finding.offset_uncertainty:.1g} {finding.force_unit}, and otherwise agrees with it "
            f"(total difference: {percent}). A constant force and direction-dependent friction "
            "absorb this offset. Check the zero of the force sensor and of the converter of the "
            "control"
        )
    timing = "late" if finding.lag >= 0 else "early"
    return (
        f"the force column is {finding.factor:.3g} times {computed}, {1e3 * abs(finding.lag):.2g} "
        f"ms {timing}; the difference is {percent}. Check the column, its unit and timing, "
        f"and {to_check}"
    )


def _drive(finding: ForceAgainstControl) -> str:
    """Return the declared drive in words; for a constant gain, both the declared and found gain."""
    gain = finding.gain
    if gain is None:
        return f"the drive ({finding.drive})"
    return (
        f"the drive gain (declared: {gain.declared:.6g} {gain.unit}; from the force column: "
        f"{gain.fitting:.4g} {gain.unit})"
    )


@sentence.register
def control_against_limit(finding: ControlAgainstLimit) -> str:
    """Return the share of samples beyond the limit of the drive, and the instruction."""
    limit = f"{finding.limit:g} {finding.unit}"
    if not finding.is_beyond:
        return (
            f"the control stays within the drive limit of {limit}: {finding.share_percent:.2g} % "
            f"of the samples exceed it by more than {finding.excess_percent:g} %"
        )
    text = (
        f"the control exceeds the drive limit of {limit} by more than {finding.excess_percent:g} % "
        f"in {finding.share_percent:.2g} % of the samples, and reaches {finding.largest:.3g} "
        f"{finding.unit}"
    )
    if finding.has_force:
        return (
            f"{text}. The force is recorded, so this affects only the simulated closed loop. "
            "Correct the limit or the unit of the control, unless the control is recorded before "
            "the drive limits it"
        )
    return (
        f"{text}. A control that is recorded before the drive limits it does not give the force in "
        "these samples. Record the control that the drive applies, or the force, or correct the "
        "limit or the unit of the control"
    )


@sentence.register
def measured_motion(finding: MeasuredMotion) -> str:
    """Return the factor, delay and offset of a measured velocity or acceleration, with remedies.

    They are relative to a computed signal, such as the derivative of the position.
    """
    role, reference = finding.role, f"the {finding.reference}"
    if finding.reference == "velocity of the simulated loop":
        reference += ", which follows the reference"
    if finding.is_other_signal:
        columns = setting("columns", {role: "NAME:UNIT"})
        return (
            f"the measured {role} is not {reference}: a factor, a delay and a constant leave "
            f"{finding.unexplained_percent:.3g} % of it (rms) unexplained ({_figures(finding)}). "
            f"Check the column, and name the right column with {columns}"
        )
    if finding.is_wrong:
        texts = [f"the measured {role} differs from {reference}: {_figures(finding)}"]
        if finding.corrections.faults:
            texts.append(_instruction(finding))
        return one_after_another(texts)
    return f"the measured {role} agrees with {reference}: {_figures(finding)}"


def _figures(finding: MeasuredMotion) -> str:
    """Return factor, delay and offset of a measured column; the worst relative to its tolerance."""
    factor = max(finding.factor_uncertainty, _LEAST_FACTOR_UNCERTAINTY)
    delay = max(finding.delay_uncertainty, _LEAST_DELAY_UNCERTAINTY)
    timing = "late" if finding.delay >= 0 else "early"
    return (
        f"factor {finding.factor:.4g} +- {factor:.1g}, {abs(finding.delay):.2f} +- {delay:.1g} "
        f"samples {timing}, offset {finding.offset:+.3g} +- {finding.offset_uncertainty:.1g} "
        f"{finding.unit}; the {finding.worst_of} is {finding.worst:.2g} times its tolerance"
    )


def _instruction(finding: MeasuredMotion) -> str:
    """Return the corrections of a column as one instruction."""
    corrections = finding.corrections
    parts = []
    if "delay" in corrections.faults:
        parts.append(_delay_correction(finding.role, corrections))
    if "factor" in corrections.faults:
        parts.append(_factor_correction(finding.role, corrections))
    if "offset" in corrections.faults:
        zero = f"{corrections.column}:UNIT{-finding.offset:+.3g}{finding.unit}"
        parts.append(f"subtract its zero with {setting('columns', {finding.role: zero})}")
    return ", and ".join(parts)


def _delay_correction(role: str, corrections: ColumnCorrections) -> str:
    """Return the instruction to shift the column of `role`; to interpolate it without a shift."""
    if corrections.shift is None:
        return f"interpolate the {role} between its values ({advised_interpolation(role)})"
    return sentence(corrections.shift)


def _factor_correction(role: str, corrections: ColumnCorrections) -> str:
    """Return the instruction to correct the unit, sign or scale of the column of `role`."""
    column = corrections.column
    if corrections.likely_unit is not None:
        columns = setting("columns", {role: f"{column}:{corrections.likely_unit}"})
        return f"give the {role} the unit {corrections.likely_unit} with {columns}"
    if corrections.is_reversed:
        columns = setting("columns", {role: f"{column}:UNIT*-1"})
        return f"reverse the sign of the {role} with {columns}"
    columns = setting("columns", {role: f"{column}:UNIT"})
    return (
        f"check the unit and the scale of the {role} ({columns}), and those of the "
        f"{corrections.scale_reference}"
    )
