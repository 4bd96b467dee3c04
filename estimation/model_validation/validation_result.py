"""What comes of holding estimates, or a fit, against another record, as they are.

An equation error tells little of a parameter that scales a small part of the force: a mass a tenth
larger leaves 6 % of the force where noise may leave as much. What the record itself says of the
parameters, estimated anew by the same method and with twins of its own, tells it: as of two records
of one regression, the difference is tested, and has to matter.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.diagnostics import RecordDifference
from axisid.estimation.diagnostics.control_law import LawAgreement, law_check
from axisid.estimation.records import Record
from axisid.estimation.thresholds import MIN_COMMON_SAMPLES
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Checked, Levels, NotUsed
from axisid.support.arrays import Array, Exact
from axisid.support.errors import Missing, check_among
from axisid.support.presentable import Presentable

_REPEATED = "repeated records"
_MAX_VALIDATION_ERROR_RATIO = 2.0  # equation error on another record by that on the own one
MAX_VALIDATION_ERROR = 10.0  # %, up to which an estimate holds whatever the other error is
# % of the tracking error: measured, at most 0.7 on right records, 5.4 with a coarse encoder that
# has as much on its own; 10 with a gain a tenth off
_MAX_VALIDATION_TRACKING = 5.0
_MAX_KNOWN_SHARE = 0.01  # of the samples were estimated from: windows that touch share one


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
        The same in percent of the recorded tracking error, reference less position: how much of
        what the loop leaves the estimate does not explain.
    reason : str or None
        Why there are no simulated figures.
    own_simulation_error_percent, own_tracking_error_percent : float or None
        On the record that the estimate was made from; None where they are not known, as the latter
        is of a result that was read from a file.
    least_equation_error_percent : float
        The equation error less what chance may make of it in so short a record.
    reestimate : RecordDifference or None
        What the record itself says of the parameters; None where it cannot.
    changed : tuple of str
        Parameters that are others in it; none where that is chance, or makes no force to speak of.
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
        """Whether the simulated loop is as near the record as it is on the estimate's own."""
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
        Part of its samples that the estimates were made from, which says nothing new of them.
    time_base : str or None
        What speaks against the record's sampling period.
    law : LawAgreement or Missing
        The declared control law against the record.
    levels : Levels
        From when on the parameters count as others.
    """

    record: Record
    unit: str
    methods: tuple[MethodValidation, ...]
    known_share: float = 0.0
    time_base: str | None = None
    law: LawAgreement | Missing = field(default_factory=lambda: Missing("it was not looked at"))
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
        """Figures of the methods by name and unit, as a table shows them."""
        return {
            ("equation error", "%"): tuple(v.equation_error_percent for v in self),
            ("on its own record", "%"): tuple(v.own_equation_error_percent for v in self),
            ("simulation error", "%"): tuple(v.simulation_error_percent for v in self),
            ("position error, rms", self.unit): tuple(v.position_error_rms for v in self),
            ("of the tracking error", "%"): tuple(v.tracking_error_percent for v in self),
            ("parameters anew", "%"): tuple(
                # Of the record that they are of, rounding alone is left.
                None if v.reestimate is None else round(v.reestimate.share_percent, 6)
                for v in self
            ),
        }

    @property
    def checks(self) -> tuple[Check, ...]:
        """What the record says of the estimates, as a verdict: its law, force and parameters."""
        found, known, most = list[Check](), self.known_share, _MAX_KNOWN_SHARE
        if self.time_base:
            found.append(
                Check.unless(
                    "time base", f"believe nothing before this is mended: {self.time_base}"
                )
            )
        if known > most:
            said = (
                "this is the record that the estimates were made from, so it says nothing new; "
                "validate on another one"
                if self.same_record
                else f"{100 * known:.0f} % of its samples are among those that the estimates were "
                "made from, which say nothing new; validate on the others"
            )
            found.append(Check.unless(_REPEATED, said, "", known, most))
        if not self.same_record:
            law = checked_law(self.law, "does not hold: the loop of this record is another one: ")
            found += law, self._force(), self._parameters(), self._loop()
        return tuple(found)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is missing and why, and which estimates do not hold."""
        reasons = dict.fromkeys(f"no simulation: {v.reason}" for v in self if v.reason)
        failing = [check.meaning for check in self.checks if check.status == "fail"]
        return (*reasons, *failing, *[self._held()] * (self.holds and not self.same_record))

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
        """All of them as one, of the result that is held against the record.

        That samples are known says nothing against the estimates.
        """
        failed = [check for check in self.checks if check.status == "fail"]
        against = [check.line for check in failed if check.name != _REPEATED]
        if failed and not against:
            return Check(name="validation", status="note", meaning=failed[0].meaning)
        said = f"the estimates do not hold on it, see there: {', '.join(against)}"
        return Check.unless("validation", said if against else None, self._held())

    def _held(self) -> str:
        held = ", ".join(check.meaning for check in self.checks if check.status == "pass")
        if any(v.reestimate for v in self):
            return f"the estimates hold: {held}"
        return (
            f"nothing speaks against the estimates: {held}; they were not estimated anew, so that "
            "less may have changed"
        )

    def _force(self) -> Check:
        times, most = _MAX_VALIDATION_ERROR_RATIO, MAX_VALIDATION_ERROR
        failing = ", ".join(v.method for v in self if not v.fits)
        return Check.unless(
            "equation error",
            failing
            and f"{failing}: does not hold on this "
            f"record (more than {most:g} % and than {times:g} times the error on its own); "
            "check that it is the same axis, its units and its signs",
            "no equation error, less what chance may make of it in so short a record, is both "
            f"beyond {most:g} % and beyond {times:g} times the one on their own record",
            max(v.least_equation_error_percent for v in self),
            most,
        )

    def _loop(self) -> Check:
        """Only where the law does not say more of it, or the force is at fault."""
        lost = [v for v in self if v.fits and not v.follows]
        shown = lost or [v for v in self if v.tracking_error_percent is not None]
        if not (self.has_declared_law and shown):
            said = next(
                (v.reason for v in self if v.reason),
                "the loop of this record is another one, or has no position",
            )
            is_unused = isinstance(self.law, NotUsed)
            return Check.not_evaluated("simulation", NotUsed(said) if is_unused else Missing(said))
        worst = max(v.tracking_error_percent or 0.0 for v in shown)
        return Check.unless(
            "simulation",
            f"{', '.join(v.method for v in lost)}: does not hold on this record: the "
            "simulated loop is far further from it than from its own (its position by "
            f"{worst:.3g} % of the tracking error); check the gains and the period of the "
            "drive, and name a test signal that was added, with columns injected=NAME and "
            "injected_at in run.toml"
            if lost
            else None,
            "the simulated loops follow it",
            worst,
        )

    def _parameters(self) -> Check:
        again = {v.method: v.reestimate for v in self if v.reestimate is not None}
        if not again:
            return Check.not_evaluated("records alike", Missing("they cannot be estimated anew"))
        changed = {v.method: v.changed for v in self if v.changed}
        said = None
        if changed:
            most = max(changed, key=lambda method: again[method].share_percent)
            told = again[most].told(changed[most], "this record", "the estimate's own")
            said = (
                f"{', '.join(changed)}: does not hold on this record: estimated anew {told}, "
                f"which makes {again[most].share_percent:.2g} % of the force; check the load and "
                "what has changed, or whether friction and motion are beyond what the model says"
            )
        return Check.unless(
            "records alike",
            said,
            "estimated anew no parameter differs by more than chance",
            max(each.share_percent for each in again.values()),
            100 * self.levels.least_share,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitValidation(Checked, Presentable, Exact):
    """What the output that frozen parameters simulate leaves of a record.

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
        Simulated less recorded output.
    samples : (n,) array of int
        Of the record, that the errors are at.
    counted : (n,) array of bool
        Which of the samples are measurements.
    percent : float
        Root mean square of what is left, of that of the recorded output.
    checks : tuple of Check
        Whether the output is as near as on the fit's own records, and what says that the record may
        be of another axis, as a record does not know its axis: a control law that it does not have,
        another sample period than that of the fit's records.
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
    def notes(self) -> tuple[str, ...]:
        """What speaks against the fit on this record."""
        return tuple(check.meaning for check in self.checks if check.status in ("note", "fail"))

    @property
    def error(self) -> float:
        """Root mean square of what is left, in the output's unit."""
        return float(np.sqrt(np.mean(self.errors[self.counted] ** 2)))


def checked_law(law: LawAgreement | Missing, lead: str) -> Check:
    """The declared law against a second record; `lead` begins what is told where it fails."""
    if isinstance(found := law_check(law), Missing):
        return Check.not_evaluated("control law", found)
    return replace(found, meaning=lead + found.meaning) if found.status == "fail" else found


def is_as_small(found: float | None, own: float | None, most: float) -> bool:
    """Whether an error is small, or of its size on the estimate's own record, or one is unknown."""
    return found is None or own is None or found <= max(_MAX_VALIDATION_ERROR_RATIO * own, most)
