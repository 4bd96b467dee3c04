"""Validation of estimates, or of a fit, with frozen parameters on a second record.

An equation error says little of a parameter that scales a small part of the force: a mass that is
10 % larger adds 6 % of the force to it, where noise may add as much. The parameters are therefore
estimated from the second record as well, by the same method and with simulated replicas of its own:
as of two records of one regression, the difference is tested, and has to be relevant.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

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
from axisid.support.errors import Missing, check_among
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
_MAX_VALIDATION_ERROR_RATIO = 2.0  # equation error on another record over that on the own one
MAX_VALIDATION_ERROR = 10.0  # %, up to which an estimate holds whatever the other error is
# % of the tracking error: measured, at most 0.7 on correct records, 5.4 with a coarse encoder that
# has as much on its own; 10 with a gain that is 10 % wrong
_MAX_VALIDATION_TRACKING = 5.0
_MAX_KNOWN_SHARE = 0.01  # of the samples that were estimated from: adjacent windows share one


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodValidation:
    """One estimate on a record that it was not made from.

    Attributes
    ----------
    method : str
    equation_error_percent : float
        ``100 ||y - X theta|| / ||y||`` on the record, filtered as for the estimate.
    own_equation_error_percent : float
        The same on the record that the estimate was made from.
    simulation_error_percent : float or None
        ``100 ||y - simulated|| / ||y||``; None where the loop could not be simulated.
    position_error_rms : float or None
        Of the simulated position against the recorded one over the samples that are kept, in
        the coordinate's unit.
    tracking_error_percent : float or None
        The same in percent of the recorded tracking error, reference minus position: the part of
        the tracking error that the estimate does not explain.
    reason : str or None
        Why there are no simulated figures.
    own_simulation_error_percent, own_tracking_error_percent : float or None
        On the record that the estimate was made from; None where they are unknown. The latter is
        unknown for a result that was read from a file.
    least_equation_error_percent : float
        The equation error minus the part that may be chance in so short a record.
    reestimate : RecordDifference or None
        The parameters estimated from the second record, compared with the frozen ones; None where
        the record does not determine them.
    changed : tuple of str
        Parameters that differ in it; none where the difference is chance, or makes a negligible
        force.
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
        """Whether the force fits the motion, the loop the record, and the parameters are the same.

        The errors are compared with those on the estimate's own record.
        """
        return self.fits and self.follows and not self.changed

    @property
    def fits(self) -> bool:
        """Whether the equation error is of the size that it has on the estimate's own record."""
        return is_as_small(
            self.least_equation_error_percent, self.own_equation_error_percent, MAX_VALIDATION_ERROR
        )

    @property
    def follows(self) -> bool:
        """Whether the simulated loop is as close to the record as to the estimate's own."""
        return is_as_small(
            self.simulation_error_percent, self.own_simulation_error_percent, MAX_VALIDATION_ERROR
        ) and is_as_small(
            self.tracking_error_percent, self.own_tracking_error_percent, _MAX_VALIDATION_TRACKING
        )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class Validation(Checked, Presentable, Exact):
    """The estimates of a result, frozen, on another record; ``validation["idm-iv"]`` is one.

    Attributes
    ----------
    record : Record
    unit : str
        Of the position.
    methods : tuple of MethodValidation
        In the order of the result's estimates; the object iterates over them.
    known_share : float
        Part of its samples that the estimates were made from, which is no independent check.
    time_base : str or None
        The reason to doubt the record's sampling period.
    law : LawAgreement or Missing
        The declared control law compared with the record.
    levels : Levels
        Thresholds from which parameters count as changed.
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
        held = ", ".join(f"{v.method} {v.equation_error_percent:.4g} %" for v in self)
        return f"validation on {self.record.provenance.source}: equation error {held}"

    @property
    def errors(self) -> dict[tuple[str, str], tuple[float | None, ...]]:
        """Errors of the methods by name and unit, as a table shows them."""
        return {
            ("equation error", "%"): tuple(v.equation_error_percent for v in self),
            ("on its own record", "%"): tuple(v.own_equation_error_percent for v in self),
            ("simulation error", "%"): tuple(v.simulation_error_percent for v in self),
            ("position error, rms", self.unit): tuple(v.position_error_rms for v in self),
            ("of the tracking error", "%"): tuple(v.tracking_error_percent for v in self),
            ("parameters anew", "%"): tuple(
                # Of the estimates' own record the difference is rounding alone.
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
            lead = "the estimates do not hold, because this record has another control law: "
            law = checked_law(self.law, lead)
            found += law, self._force(), self._parameters(), self._loop()
        return tuple(found)

    @property
    def notes(self) -> tuple[Finding, ...]:
        """Findings to be reported: missing simulations, failed checks, or that all hold."""
        reasons = dict.fromkeys(v.reason for v in self if v.reason)
        unmade = [NoSimulation(reason=reason) for reason in reasons]
        failing = [check.finding for check in self.checks if check.status == "fail"]
        held = [self._held()] if self.holds and not self.same_record else []
        return (*unmade, *failing, *held)

    @property
    def same_record(self) -> bool:
        """Whether it is the record that the estimates were made from, or a part of it."""
        return self.known_share >= MIN_COMMON_SAMPLES.value

    @property
    def has_declared_law(self) -> bool:
        """Whether nothing speaks against the declared control law on this record."""
        return isinstance(self.law, Missing) or self.law.passed

    @property
    def holds(self) -> bool:
        """Whether the law is the record's, and each estimate holds on it."""
        return self.has_declared_law and all(v.holds for v in self)

    @property
    def check(self) -> Check:
        """All checks as one, for the verdict of the result that is validated.

        Known samples are no evidence against the estimates.
        """
        failed = [check for check in self.checks if check.status == "fail"]
        against = tuple(check.line for check in failed if check.name != _REPEATED)
        if failed and not against:
            return Check(name="validation", status="note", finding=failed[0].finding)
        fault = EstimatesDoNotHold(failed=against) if against else None
        return Check.unless("validation", fault, self._held())

    def _held(self) -> EstimatesHold:
        return EstimatesHold(
            passed=tuple(check.finding for check in self.checks if check.status == "pass"),
            is_reestimated=any(v.reestimate for v in self),
        )

    def _force(self) -> Check:
        failed = tuple(v.method for v in self if not v.fits)
        largest = max(v.least_equation_error_percent for v in self)
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
        """Return the check of the simulated loop, unless the law or the force is at fault."""
        lost = [v for v in self if v.fits and not v.follows]
        shown = lost or [v for v in self if v.tracking_error_percent is not None]
        if not (self.has_declared_law and shown):
            reasons = [v.reason for v in self if v.reason]
            why = "the control law of this record is another one, or the record has no position"
            said = [*reasons, why][0]
            is_unused = isinstance(self.law, NotUsed)
            return Check.not_evaluated("simulation", NotUsed(said) if is_unused else Missing(said))
        worst = max(v.tracking_error_percent or 0.0 for v in shown)
        return Check(
            name="simulation",
            status=status_of(not lost),
            figure=worst,
            finding=SimulationOnRecord(
                failed=tuple(v.method for v in lost), tracking_error_percent=worst
            ),
        )

    def _parameters(self) -> Check:
        again = {v.method: v.reestimate for v in self if v.reestimate is not None}
        if not again:
            why = "the parameters cannot be estimated from the second record"
            return Check.not_evaluated("records alike", Missing(why))
        changed = {v.method: v.changed for v in self if v.changed}
        compared = tuple[DifferingParameter, ...]()
        if changed:
            most = max(changed, key=lambda method: again[method].share_percent)
            compared = again[most].parameters(changed[most])
        largest = max(each.share_percent for each in again.values())
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
    """Output that frozen parameters simulate, compared with that of a record.

    Attributes
    ----------
    record : Record
    output : str
        ``control``, ``position``, ``force`` or ``open-loop``.
    unit : str
        Of the output.
    horizon : float or None
        Length of the windows of an open loop, s, that was asked for.
    windows : tuple of slice
        Of the errors: each window of an open loop, or each segment of the record.
    errors : (n,) array
        Simulated minus recorded output.
    samples : (n,) array of int
        Of the record, that the errors are at.
    counted : (n,) array of bool
        Which of the samples are measurements.
    percent : float
        Root mean square of the errors, of that of the recorded output.
    checks : tuple of Check
        Of the output, compared with the fit's own records; and of signs that the record is of
        another axis, as a record does not know its axis: another control law, or another sample
        period than that of the fit's records.
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
        """Findings against the fit on this record."""
        return tuple(check.finding for check in self.checks if check.status in ("note", "fail"))

    @property
    def error(self) -> float:
        """Root mean square of the errors, in the output's unit."""
        return float(np.sqrt(np.mean(self.errors[self.counted] ** 2)))


def checked_law(law: LawAgreement | Missing, lead: str) -> Check:
    """Return the check of the declared law on a second record; `lead` begins a failed sentence."""
    found = law_check(law)
    if isinstance(found, Missing):
        return Check.not_evaluated("control law", found)
    if found.status != "fail":
        return found
    return replace(found, finding=LawOfSecondRecord(lead=lead, finding=found.finding))


def is_as_small(found: float | None, own: float | None, most: float) -> bool:
    """Tell whether an error is small, as large as on the own record, or one of them is unknown."""
    return found is None or own is None or found <= max(_MAX_VALIDATION_ERROR_RATIO * own, most)
