"""The diagnosis of a result: what each test measured, and the verdict on it."""

from collections.abc import Mapping
from dataclasses import dataclass

from axisid.codegen import GeneratedAxis

from .alignment import Alignment, profile_alignment
from .check import Check
from .covariance import Hac
from .errors import DataError, EstimationError
from .estimate import Estimate
from .excitation import Excitation, excitation
from .forms import InverseForm
from .instruments import Endogeneity, InstrumentTests, endogeneity, instrument_tests
from .law_check import LawCheck, check_law
from .prefilter import Prefilter
from .record import Record
from .signals import measured_signals
from .verdict import verdict

#: Which estimate is judged: the first of these that there is.
_JUDGED = ("idm-iv", "ddm-iv", "idm-ls", "ddm-ls")


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


def diagnose(
    axis: GeneratedAxis, record: Record, prefilter: Prefilter, estimates: Mapping[str, Estimate]
) -> Diagnosis:
    """Test a result; each method where it was run."""
    judged = next(method for method in _JUDGED if method in estimates)
    law = check_law(axis, record)
    instruments = _instruments(estimates[judged])
    tested = _endogeneity(estimates.get("idm-iv"))
    moved = _excitation(axis, record, prefilter, estimates[judged])
    alignment = _alignment(axis, record, prefilter)
    return Diagnosis(
        judged=judged,
        law=law,
        instruments=instruments,
        endogeneity=tested,
        excitation=moved,
        alignment=alignment,
        verdict=verdict(
            estimates,
            estimates[judged],
            law=law,
            instruments=instruments,
            tested=tested,
            moved=moved,
            alignment=alignment,
            hold=str(prefilter.hold),
        ),
    )


def _instruments(estimate: Estimate) -> InstrumentTests | None:
    return None if estimate.Z is None else instrument_tests(estimate.X, estimate.Z)


def _endogeneity(iv: Estimate | None) -> Endogeneity | None:
    if iv is None or iv.Z is None:
        return None
    try:
        return endogeneity(iv.X @ iv.physical + iv.residuals, iv.X, iv.Z, Hac())
    except EstimationError:
        return None


def _excitation(
    axis: GeneratedAxis, record: Record, prefilter: Prefilter, estimate: Estimate
) -> tuple[Excitation, ...]:
    signals = measured_signals(axis, record, prefilter)
    rows = InverseForm(axis).equations(signals).reduced(prefilter, record.period)
    return excitation(axis, signals, rows, estimate.physical)


def _alignment(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> Alignment | str:
    try:
        return profile_alignment(axis, record, prefilter)
    except (DataError, EstimationError) as error:
        return str(error)
