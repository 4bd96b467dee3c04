"""The diagnosis of a result: what each test measured, and the verdict on it."""

from collections.abc import Mapping
from dataclasses import dataclass

from axisid.estimation.estimates import Estimate, Reach
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError

from .alignment import Alignment, alignment_of
from .check import Check
from .control_law import LawCheck, check_law
from .excitation import Excitation, excitation
from .fixed_values import fixed_check
from .force import force_checks, limit_checks
from .instruments import Endogeneity, InstrumentTests, endogeneity_of, instrument_tests
from .left_over import constant_check, ripple_check
from .verdict import verdict

#: Which estimate is judged: the first of these that there is.
JUDGED = ("idm-iv", "ddm-iv", "idm-ls", "ddm-ls")


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis:
    """What was measured of a result.

    Attributes
    ----------
    judged : str
        The method that the checks of one estimate are of.
    law : LawCheck or str
        The control law against the record, or why it cannot be checked.
    instruments : InstrumentTests or None
        Of `judged`; None for least squares.
    endogeneity : Endogeneity or None
        Of idm-iv; None without it, or where instruments and regressor are too alike to test.
    excitation : tuple of Excitation
        By physical parameter.
    alignment : Alignment or str
        The delay of the force, or why it cannot be measured.
    verdict : tuple of Check
        All of it against thresholds.
    """

    judged: str
    law: LawCheck | str
    instruments: InstrumentTests | None
    endogeneity: Endogeneity | None
    excitation: tuple[Excitation, ...]
    alignment: Alignment | str
    verdict: tuple[Check, ...]


def diagnose(data: FilteredRecord, estimates: Mapping[str, Estimate]) -> Diagnosis:
    """Test a result; each method where it was run."""
    axis, record, prefilter, signals = data.axis, data.record, data.prefilter, data.signals
    method = judged_method(estimates)
    judged = estimates[method]
    law = check_law(axis, record)
    instruments = _instruments(judged)
    tested = endogeneity_of(estimates.get("idm-iv"))
    moved = _excitation(data, judged)
    alignment = _alignment(data, judged)
    return Diagnosis(
        judged=method,
        law=law,
        instruments=instruments,
        endogeneity=tested,
        excitation=moved,
        alignment=alignment,
        verdict=(
            *verdict(
                estimates,
                judged,
                law=law,
                instruments=instruments,
                tested=tested,
                moved=moved,
                alignment=alignment,
                hold=str(prefilter.hold),
                reversals=prefilter.reversals,
                rest=data.rest,
            ),
            *fixed_check(judged),
            *force_checks(axis, record),
            *limit_checks(axis, record),
            constant_check(judged, data.weights, law, axis.axis.drive.gain),
            ripple_check(judged, signals, prefilter),
        ),
    )


def judged_method(estimates: Mapping[str, Estimate]) -> str:
    """Return the method that a verdict is of."""
    return next(method for method in JUDGED if method in estimates)


def _instruments(estimate: Estimate) -> InstrumentTests | None:
    return None if estimate.Z is None else instrument_tests(estimate.X, estimate.Z)


def _excitation(data: FilteredRecord, estimate: Estimate) -> tuple[Excitation, ...]:
    every = InverseForm(data.axis).at(estimate.physical).equations(data.signals)
    return excitation(
        data.axis,
        data.signals,
        every.reduced(data),
        data.weights,
        estimate.physical,
        Reach.of(data.signals, every, data.kept),
    )


def _alignment(data: FilteredRecord, estimate: Estimate) -> Alignment | str:
    try:
        return alignment_of(data, estimate.physical, _instruments_of(estimate))
    except (DataError, EstimationError) as error:
        return str(error)


def _instruments_of(estimate: Estimate) -> tuple[Array, Array] | None:
    """Of the inverse model; a direct model's serve another left side."""
    if estimate.Z is None or estimate.simulated is None or estimate.ddm_quantities:
        return None
    return estimate.Z, estimate.simulated
