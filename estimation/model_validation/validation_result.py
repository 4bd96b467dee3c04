"""Validation of estimates, or of a fit, with frozen parameters on a second record.

An equation error is not sensitive to a parameter that scales a small part of the force: a mass that
is 10 % too large adds an error of 6 % of the force, and noise may add as much. The parameters are
therefore estimated from the second record as well, by the same method and with simulated replicas
of the second record. The difference is tested as between two records of one regression, and has to
be relevant.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.diagnostics import DifferingParameter, RecordDifference
from axisid.estimation.diagnostics.control_law import LawAgreement, LawOfSecondRecord, law_check
from axisid.estimation.findings import Finding
from axisid.estimation.records import Record
from axisid.estimation.thresholds import MIN_COMMON_SAMPLES
from axisid.estimation.verdict_checks import (
    DEFAULT_LEVELS,
    Check,
    Checked,
    Levels,
    NotUsed,
    status_of,
)
from axisid.support.arrays import Array, Exact
from axisid.support.checks import check_among
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable

from .validation_findings import (
    DoubtfulTimeBase,
    EquationErrorOnRecord,
    EstimatesDoNotHold,
    EstimatesHold,
    KnownSamples,
    NoSimulation,
    ReestimatedParameters,
    SimulationOnRecord,
)

_REPEATED = "repeated records"
_MAX_VALIDATION_ERROR_RATIO = 2.0  # error on another record, relative to that on the own record
MAX_VALIDATION_ERROR = 10.0  # %, error that is small enough for any error on the own record
# % of the tracking error: measured, at most 0.7 on correct records, 5.4 with a coarse encoder (as
# on the own record), 10 with an error of 10 % of a gain
_MAX_VALIDATION_TRACKING = 5.0
_MAX_KNOWN_SHARE = 0.01  # largest share of known samples: adjacent windows share one sample


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodValidation:
    """Validation of one estimate on a record that it was not made from.

    Attributes
    ----------
    method : str
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||`` on the record, filtered as for the estimate.
    own_equation_error_percent : float
        Equation error on the estimate's own records, %.
    simulation_error_percent : float or None
        ``100 ||y - simulated|| / ||y||``; None if the loop could not be simulated.
    position_error_rms : float or None
        Root mean square of recorded minus simulated position over the kept samples, in the unit of
        the coordinate. None if it is unknown.
    tracking_error_percent : float or None
        Position error (rms) relative to the recorded tracking error (rms), reference minus
        position, %: the part of the tracking error that the estimate does not explain. None if it
        is unknown.
    reason : str or None
        Reason why the loop could not be simulated; None if it was.
    own_simulation_error_percent, own_tracking_error_percent : float or None
        Errors on the estimate's own records; None if they are unknown. The latter is unknown for a
        result that was read from a file.
    least_equation_error_percent : float
        Equation error minus the part that may be chance in a record of this length, %.
    reestimate : RecordDifference or None
        Parameters estimated from the second record, compared with the frozen parameters; None if
        the record does not determine them.
    changed : tuple of str
        Names of parameters that differ; empty if the difference is not significant, or makes a
        negligible force.
    """

    method: str
    equation_error_percent: float
    own_equation_error_percent: float
    simulation_error_percent: float | None
    position_error_rms: float | None
    tracking_error_percent: float | None
    reason: str | None
    own_simulation_error_percent: float | None
    own_tracking_error_percent: float | None
    least_equation_error_percent: float
    reestimate: RecordDifference | None
    changed: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """True if the second record confirms the estimate.

        Equation error and errors of the simulated loop must be as small as on the estimate's own
        records, and no parameter may differ between the records.
        """
        return self.fits and self.follows and not self.changed

    @property
    def fits(self) -> bool:
        """True if the equation error is as small as on the estimate's own records."""
        return is_as_small(
            self.least_equation_error_percent, self.own_equation_error_percent, MAX_VALIDATION_ERROR
        )

    @property
    def follows(self) -> bool:
        """True if the simulated position and force are as close as on the own records."""
        return self.follows_position and is_as_small(
            self.simulation_error_percent, self.own_simulation_error_percent, MAX_VALIDATION_ERROR
        )

    @property
    def follows_position(self) -> bool:
        """True if the simulated position is as close as on the estimate's own records."""
        return is_as_small(
            self.tracking_error_percent, self.own_tracking_error_percent, _MAX_VALIDATION_TRACKING
        )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class Validation(Checked, Presentable, Exact):
    """Validation of all estimates of a result on another record, with frozen parameters.

    ``validation["idm-iv"]`` is the validation of one method.

    Attributes
    ----------
    record : Record
    unit : str
        Unit of the position.
    methods : tuple of MethodValidation
        In the order of the result's estimates; the object iterates over them.
    known_share : float
        Share of the record's samples, 0 to 1, from which the estimates were made. These samples are
        no independent check.
    time_base : str or None
        Reason to doubt the record's sampling period; None if there is none.
    law : LawAgreement or Missing
        The declared control law compared with the record.
    levels : Levels
        Levels of significance and relevance from which parameters count as changed.
    """

    record: Record
    unit: str
    methods: tuple[MethodValidation, ...]
    known_share: float = 0.0
    time_base: str | None = None
    law: LawAgreement | Missing = field(default_factory=lambda: Missing("the law was not checked"))
    levels: Levels = DEFAULT_LEVELS

    def __iter__(self) -> Iterator[MethodValidation]:
        return iter(self.methods)

    def __getitem__(self, method: str) -> MethodValidation:
        found = {each.method: each for each in self.methods}
        name = str(method).lower()
        check_among(("validation of", name, found))
        return found[name]

    def __repr__(self) -> str:
        errors = ", ".join(f"{v.method} {v.equation_error_percent:.4g} %" for v in self)
        return f"validation on {self.record.provenance.source}: equation error {errors}"

    @property
    def errors(self) -> dict[tuple[str, str], tuple[float | None, ...]]:
        """Error of each method, by name and unit of the error; None if it is unknown.

        They are the columns of a table.
        """
        return {
            ("equation error", "%"): tuple(v.equation_error_percent for v in self),
            ("on its own record", "%"): tuple(v.own_equation_error_percent for v in self),
            ("simulation error", "%"): tuple(v.simulation_error_percent for v in self),
            ("position error, rms", self.unit): tuple(v.position_error_rms for v in self),
            ("of the tracking error", "%"): tuple(v.tracking_error_percent for v in self),
            ("re-estimated parameters", "%"): tuple(
                # On the estimates' own record the difference is rounding only.
                None if v.reestimate is None else round(v.reestimate.share_percent, 6)
                for v in self
            ),
        }

    @property
    def checks(self) -> tuple[Check, ...]:
        """Checks of the estimates on the record: of the law, the force and the parameters."""
        found, known, most = list[Check](), self.known_share, _MAX_KNOWN_SHARE
        if self.time_base:
            found.append(Check.unless("time base", DoubtfulTimeBase(reason=self.time_base)))
        if known > most:
            same = KnownSamples(percent=100 * known, is_same_record=self.same_record)
            found.append(Check.unless(_REPEATED, same, "", known, most))
        if not self.same_record:
            law = checked_law(self.law, "estimates")
            found += law, self._force(), self._parameters(), self._loop()
        return tuple(found)

    @property
    def notes(self) -> tuple[Finding, ...]:
        """Findings to be reported: missing simulations, failed checks, and the confirmation.

        The confirmation of the estimates is missing if the record does not confirm all of them.
        """
        reasons = dict.fromkeys(v.reason for v in self if v.reason)
        found: list[Finding] = [NoSimulation(reason=reason) for reason in reasons]
        found += [check.finding for check in self.checks if check.status == "fail"]
        if self.holds and not self.same_record:
            found.append(self._confirmation())
        return tuple(found)

    @property
    def same_record(self) -> bool:
        """True if the estimates were made from this record, or from a record that contains it."""
        return self.known_share >= MIN_COMMON_SAMPLES.value

    @property
    def has_declared_law(self) -> bool:
        """True if the record does not contradict the declared control law."""
        return isinstance(self.law, Missing) or self.law.passed

    @property
    def holds(self) -> bool:
        """True if the record does not contradict the declared law, and confirms every estimate."""
        return self.has_declared_law and all(v.holds for v in self)

    @property
    def check(self) -> Check:
        """Combination of all checks as one check, for the verdict of the validated result.

        It fails if a check fails. If only the check of known samples fails, it is a note, because
        known samples are no evidence against the estimates.
        """
        failed = [check for check in self.checks if check.status == "fail"]
        lines = tuple(check.line for check in failed if check.name != _REPEATED)
        if failed and not lines:
            return Check(name="validation", status="note", finding=failed[0].finding)
        fault = EstimatesDoNotHold(failed=lines) if lines else None
        return Check.unless("validation", fault, self._confirmation())

    def _confirmation(self) -> EstimatesHold:
        """Return the finding that the record confirms the estimates."""
        return EstimatesHold(
            passed=tuple(check.finding for check in self.checks if check.status == "pass"),
            is_reestimated=any(v.reestimate for v in self),
        )

    def _force(self) -> Check:
        """Return the check of the equation errors on this record.

        It fails if an equation error exceeds both a limit in % and twice the error on the
        estimate's own records (`fits`). The part of the error that may be chance is subtracted
        first. The figure is the largest error, of the failed methods if any fail.
        """
        failed = tuple(v.method for v in self if not v.fits)
        shown = [v for v in self if not v.fits] or [*self]
        largest = max(v.least_equation_error_percent for v in shown)
        return Check(
            name="equation error",
            status=status_of(not failed),
            figure=largest,
            threshold=MAX_VALIDATION_ERROR,
            finding=EquationErrorOnRecord(
                failed=failed,
                largest_percent=largest,
                max_percent=MAX_VALIDATION_ERROR,
                max_ratio=_MAX_VALIDATION_ERROR_RATIO,
            ),
        )

    def _loop(self) -> Check:
        """Return the check of the simulated loop.

        It is not evaluated if the record contradicts the declared law, or if no position error is
        known. Methods whose equation error is too large do not fail this check as well.
        """
        failed = [v for v in self if v.fits and not v.follows]
        shown = failed or [v for v in self if v.tracking_error_percent is not None]
        if not (self.has_declared_law and shown):
            reasons = [v.reason for v in self if v.reason]
            usual = "the record follows another control law, or has no position"
            reason = reasons[0] if reasons else usual
            if isinstance(self.law, NotUsed):
                return Check.not_evaluated("simulation", NotUsed(reason))
            return Check.not_evaluated("simulation", Missing(reason))
        worst = max(shown, key=lambda v: v.tracking_error_percent or 0.0)
        return Check(
            name="simulation",
            status=status_of(not failed),
            figure=worst.tracking_error_percent or 0.0,
            finding=SimulationOnRecord(
                failed=tuple(v.method for v in failed),
                by_position=not worst.follows_position,
                tracking_error_percent=worst.tracking_error_percent,
                own_tracking_error_percent=worst.own_tracking_error_percent,
                simulation_error_percent=worst.simulation_error_percent,
                own_simulation_error_percent=worst.own_simulation_error_percent,
            ),
        )

    def _parameters(self) -> Check:
        """Return the check that parameters estimated from the second record are the same.

        It is not evaluated if the record does not determine them.
        """
        differences = {v.method: v.reestimate for v in self if v.reestimate is not None}
        if not differences:
            why = "the parameters cannot be estimated from the second record"
            return Check.not_evaluated("records alike", Missing(why))
        changed = {v.method: v.changed for v in self if v.changed}
        compared = tuple[DifferingParameter, ...]()
        if changed:
            most = max(changed, key=lambda method: differences[method].share_percent)
            compared = differences[most].parameters(changed[most])
        shown = [differences[method] for method in changed] or [*differences.values()]
        largest = max(each.share_percent for each in shown)
        return Check(
            name="records alike",
            status=status_of(not changed),
            figure=largest,
            threshold=100 * self.levels.least_share,
            finding=ReestimatedParameters(
                failed=tuple(changed), changed=compared, largest_percent=largest
            ),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitValidation(Checked, Presentable, Exact):
    """Validation of a fit: simulated output with frozen parameters, compared with a second record.

    Attributes
    ----------
    record : Record
    output : str
        ``control``, ``position``, ``force`` or ``open-loop``.
    unit : str
        Unit of the output.
    horizon : float or None
        Requested length of the windows of an open loop, s; None for a closed loop.
    windows : tuple of slice
        Rows of the errors by window of an open loop, or by segment of the record.
    errors : (n,) array
        Simulated minus recorded output.
    samples : (n,) array of int
        Samples of the record with these errors.
    counted : (n,) array of bool
        True for samples that are measurements.
    percent : float
        Root mean square of the errors, relative to that of the recorded output, %.
    checks : tuple of Check
        Checks of the output, compared with the fit's own records, and of two signs that the record
        is of another axis: it follows another control law, or its sampling period differs from that
        of the fit's records. A record does not name its axis.
    """

    record: Record
    output: str
    unit: str
    horizon: float | None
    windows: tuple[slice, ...]
    errors: Array
    samples: NDArray[np.intp]
    counted: NDArray[np.bool_]
    percent: float
    checks: tuple[Check, ...] = ()

    @property
    def notes(self) -> tuple[Finding, ...]:
        """Findings of the checks that failed or are a note."""
        return tuple(check.finding for check in self.checks if check.status in ("note", "fail"))

    @property
    def error(self) -> float:
        """Root mean square of the errors, in the output's unit."""
        return float(np.sqrt(np.mean(self.errors[self.counted] ** 2)))


def checked_law(law: LawAgreement | Missing, result: Literal["estimates", "fit"]) -> Check:
    """Return the check of the declared law on a second record.

    It is not evaluated if the law cannot be compared. `result` is the kind of the validated result.
    """
    found = law_check(law)
    if isinstance(found, Missing):
        return Check.not_evaluated("control law", found)
    if found.status != "fail":
        return found
    return replace(found, finding=LawOfSecondRecord(result=result, finding=found.finding))


def is_as_small(found: float | None, own: float | None, most: float) -> bool:
    """Return True if an error on a second record is small, or if one of the errors is unknown.

    An error is small up to a limit in %, and up to twice the error on the estimate's own records.

    Parameters
    ----------
    found, own : float or None
        Error on the second record, and on the estimate's own records, %; None if unknown.
    most : float
        Limit, %.
    """
    return found is None or own is None or found <= max(_MAX_VALIDATION_ERROR_RATIO * own, most)
