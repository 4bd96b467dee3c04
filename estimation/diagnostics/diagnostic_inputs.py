"""Inputs of the checks of a result: the result, and quantities that several checks use."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from axisid.estimation.diagnostics.control_law import LawAgreement, RecordLaws
from axisid.estimation.estimates import Estimate, estimate_of_record
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.misspecification import (
    JackknifeInterval,
    LackOfFit,
    Misspecification,
    RecordScores,
    find_misspecification,
    groupings,
    jackknife_intervals,
    lack_of_fit,
    scores_at,
)
from axisid.estimation.noise_models import noise_free_record
from axisid.estimation.records import position_step
from axisid.estimation.regression import recorded_loops
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.verdict_checks import (
    DEFAULT_LEVELS,
    Check,
    Levels,
    NotUsed,
    unless_faulty,
    value_or,
)
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .agreement_of_estimates import (
    DDM_LESS_IDM,
    FEWEST_STEPS,
    LESS,
    LS_LESS_IV,
    SECOND_OPINION,
    InstrumentTests,
    strength_check,
    tests_of_instruments,
)
from .alignment import Alignment, alignment_check, alignment_of, force_timing, law_in_time
from .column_comparison import ColumnComparison, compared_motion
from .hausman import HausmanTest, hausman
from .judged_method import judged_method
from .parameter_checks import Excitation, excitation
from .pooling import PoolingTest, pooling_test
from .quantisation_bias import quantisation_bias

ONE_RECORD = Missing("there is one record")


@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosticInputs:
    """A result to be checked, and quantities that several diagnostics use, each computed once.

    The inputs of several records have one part for each record, see `parts`. A part has the
    estimates from all records, restricted to the rows and parameters of its record.

    Attributes
    ----------
    problem : Problem
        Problem that the estimates were made from.
    estimates : mapping of str to Estimate
        Estimates by method.
    levels : Levels
        Thresholds of the checks.
    whole : DiagnosticInputs or None
        Inputs for all records if these inputs are a part for one record; otherwise None.
    number : int
        Index of this record among all records.
    compared_laws : RecordLaws or None
        Comparison of the control law with each record, if it is already made; otherwise None.
    """

    problem: Problem
    estimates: Mapping[str, Estimate]
    levels: Levels = DEFAULT_LEVELS
    whole: "DiagnosticInputs | None" = None
    number: int = 0
    compared_laws: RecordLaws | None = None

    @cached_property
    def method(self) -> str:
        """Method whose estimate is reported and checked, see `judged_method`."""
        return judged_method(
            self.estimates,
            lambda: self.laws_hold,
            lambda: self._difference("idm-iv", "didim"),
            self.levels.level,
        )

    @cached_property
    def record_laws(self) -> RecordLaws:
        """Comparison of the control law with each record; an earlier comparison is reused."""
        if self.compared_laws is not None:
            return self.compared_laws
        return RecordLaws.of(self.problem.data)

    @property
    def laws(self) -> tuple[LawAgreement | Missing, ...]:
        """Comparison of the control law with each record, or the reason why it is unavailable."""
        return self.record_laws.agreements

    @property
    def laws_hold(self) -> bool:
        """True if the control of every record follows the declared law."""
        return self.record_laws.hold

    def _difference(self, one: str, other: str) -> Mapping[str, HausmanTest] | Missing:
        """Return the tests of the difference between the estimates of two methods, by parameter.

        The difference is that of method `one` minus method `other`. Missing, with the reason, where
        a method gave no estimate or the test is unavailable.
        """
        if not {one, other} <= {*self.estimates}:
            return Missing(f"{one.upper()} and {other.upper()} did not both give an estimate")
        return unless_faulty(partial(hausman, self.estimates[one], self.estimates[other]))

    @property
    def data(self) -> FilteredRecord:
        """The filtered record; the first one of several."""
        return self.problem.data[0]

    @cached_property
    def parts(self) -> "tuple[DiagnosticInputs, ...]":
        """Inputs for each record separately, with the estimates from all records.

        Inputs for a single record have themselves as their only part.
        """
        if not self.has_parts:
            return (self,)
        return tuple(
            DiagnosticInputs(
                problem=Problem(axis=data.axis, data=(data,)),
                estimates={
                    n: estimate_of_record(e, self.problem, i) for n, e in self.estimates.items()
                },
                levels=self.levels,
                whole=self,
                number=i,
            )
            for i, data in enumerate(self.problem.data)
        )

    @property
    def has_parts(self) -> bool:
        """True if the estimates are of several records, or of parameters that records share."""
        return len(self.problem.data) > 1 or self.problem.joint_form is not None

    @cached_property
    def alike(self) -> PoolingTest | Missing:
        """Test of each of several records against the others; Missing for a single record."""
        if len(self.problem.data) == 1:
            return ONE_RECORD
        return pooling_test(self.problem, self.preferred, self.levels)

    @property
    def preferred(self) -> Estimate:
        """Reported estimate, to which the checks of a single estimate apply."""
        return self.estimates[(self.whole or self).method]

    @property
    def rests_on_loop(self) -> bool:
        """True if the reported estimate, its bias or its standard errors use simulated loops.

        Instruments, output error and simulated replicas of the record use them.
        """
        judged = (self.whole or self).preferred
        return judged.Z is not None or judged.by_output_error or bool(judged.inference.chains)

    def if_used(self, found: Check | Missing) -> Check | Missing:
        """Return a check of the control law or the simulated loop, or why it is missing.

        The reason becomes `NotUsed` where the reported estimate relies on neither the law nor the
        loop.
        """
        if self.rests_on_loop or not isinstance(found, Missing):
            return found
        return NotUsed(found.reason)

    @cached_property
    def law(self) -> LawAgreement | Missing:
        """Comparison of the control law with the record, or the reason why it is unavailable.

        If the control follows the law some samples later, the comparison also states whether the
        law or the log is wrong, which the motion shows, see `law_in_time`.
        """
        found = (self.whole or self).laws[self.number]
        if isinstance(found, Missing) or not found.delay:
            return found
        return law_in_time(found, self.data, self.timing)

    @cached_property
    def timing(self) -> int | Missing:
        """Whole samples between the recording of the force and its action, or why unknown.

        The delay of the hold is not counted, see `force_timing`.
        """
        return force_timing(self.alignment, self.data)

    @cached_property
    def instruments(self) -> InstrumentTests | Missing:
        """Tests of the instruments of the reported estimate, or the reason why there are none.

        An output-error estimate has no instruments; the tests are then those of IDM-IV.
        """
        return tests_of_instruments(
            self.estimates.get("idm-iv") if self.preferred.by_output_error else self.preferred
        )

    @cached_property
    def strength(self) -> Check | Missing:
        """Check of the strength of `instruments`, or the reason why it cannot be made."""
        return strength_check(self.instruments, self.preferred)

    @cached_property
    def excitation(self) -> tuple[Excitation, ...]:
        """Excitation of each physical parameter by the motion in the regressor.

        For an output-error estimate, it is the motion of the simulated loops, otherwise the
        measured motion.
        """
        problem, estimate = self.problem, self.preferred
        if estimate.by_output_error:
            loops = problem.by_record(problem.loops(estimate.form, estimate.physical))
            data = (noise_free_record(d, own) for d, own in zip(problem.data, loops, strict=True))
            problem = replace(problem, data=tuple(data))
        return excitation(problem, estimate.physical)

    @cached_property
    def alignment(self) -> Alignment | Missing:
        """Estimated delay of the force, or the reason why it cannot be estimated.

        If the reported estimate has instruments and no simulated replicas, the instruments of the
        delay are those of the simulated loop. Otherwise the delay is estimated with `scores`.
        """
        if isinstance(self.strength, Check) and self.strength.status == "fail":
            return Missing("the instruments are too weak to measure a delay")
        judged = self.preferred
        by_loop = judged.Z is not None and not judged.inference.chains
        return alignment_of(scores_at(self.data, judged, by_loop=True) if by_loop else self.scores)

    @cached_property
    def motions(self) -> Mapping[str, ColumnComparison | Missing]:
        """Comparison of each measured velocity and acceleration with a derivative, by role.

        A velocity without a recorded position is compared with that of the simulated loop.
        """
        record, velocities = self.data.record, tuple[Array, ...]()
        if record.integrated and record.reference is not None:
            loops = partial(recorded_loops, self.data, self.preferred.physical)
            velocities = tuple(loop.velocity for loop in value_or((), loops))
        return {
            role: compared_motion(record, role, velocities)
            for role in record.motion
            if role != "position"
        }

    @cached_property
    def scores(self) -> RecordScores | Missing:
        """Residuals of the record and of its simulated replicas with the reported estimate.

        Missing, with the reason, where they are unavailable.
        """
        return scores_at(self.data, self.preferred)

    @cached_property
    def lacking(self) -> tuple[Misspecification, ...] | Missing:
        """Missing terms, changed parameters, faulty signals and outliers of this record.

        Missing, with the reason, where the search is not possible.
        """
        half_widths = np.ptp([v.interval for v in self.preferred.parameters.values()], axis=1) / 2
        return find_misspecification(
            self.scores, half_widths, len((self.whole or self).problem.data), self.levels
        )

    @property
    def with_missing_terms(self) -> Mapping[str, tuple[float, ...]]:
        """Values of the parameters with the missing terms in the model, by name.

        The model contains all missing terms that were found. A parameter that then differs between
        directions has two values, forward and backward. Empty without missing terms.
        """
        lacking = value_or((), lambda: self.lacking)
        terms = [lack for lack in lacking if lack.is_term]
        return terms[-1].parameters if terms else {}

    @cached_property
    def aligned(self) -> Check | Missing:
        """Check of the delay of the force, or why it cannot be made."""
        late: Misspecification | Missing | None = Missing("there are no simulated replicas")
        if isinstance(self.lacking, Missing):
            late = self.lacking
        elif not isinstance(self.scores, Missing) and self.scores.twins:
            # The delay among the missing terms, which replicas distinguish from noise.
            late = next((lack for lack in self.lacking if lack.kind == "delay"), None)
        widths = {name: np.ptp(v.interval) / 2 for name, v in self.preferred.parameters.items()}
        return alignment_check(
            self.alignment,
            self.data,
            late=late,
            half_widths=widths,
            law=self.law,
            timing=self.timing,
        )

    @cached_property
    def steps(self) -> Mapping[str, float]:
        """Bias of least squares by the steps of a logged position, by parameter.

        It is the bias by steps of the log that the control loop does not read. It is infinite for
        every parameter where the motion has too few steps for these to act as noise. Empty where
        the position has no steps, for an estimate with instruments, where simulated replicas give
        the bias, for a direct model, and for several records.
        """
        ls, record = self.preferred, self.data.record
        by_loops = ls.Z is not None or ls.filter_bias is not None
        step = 0.0 if self.whole or self.has_parts or by_loops else position_step(record)
        if not step or ls.is_direct:
            return {}
        if float(np.ptp(record.position)) < FEWEST_STEPS * step:
            return dict.fromkeys(ls.parameters, np.inf)
        by = quantisation_bias(ls.form, self.data, step, ls.physical)
        return dict(zip(ls.parameters, map(float, by), strict=True))

    @cached_property
    def lack_of_fit(self) -> LackOfFit | None:
        """Split of the residual of the reported estimate into a repeating part and noise.

        None where the reference does not repeat, or there is none.
        """
        return lack_of_fit(self.preferred, self.data)

    @cached_property
    def bands(self) -> Mapping[str, Mapping[str, JackknifeInterval]]:
        """Jackknife intervals for the effect of the model error, by method and parameter."""
        # Model error or noise may dominate the residual.
        found = self.lack_of_fit
        noisy = found is None or not found.is_mostly_repeated
        # Estimates of one problem have the same rows.
        ways = groupings(self.data, self.preferred.rows.astype(np.intp))
        return {n: jackknife_intervals(e, ways, noisy=noisy) for n, e in self.estimates.items()}

    @cached_property
    def compared(self) -> Mapping[str, Mapping[str, HausmanTest] | Missing]:
        """Tests of the differences between estimates, by pair of methods and by parameter.

        Missing, with the reason, for a pair that cannot be compared. Where there are instruments,
        the pairs are IDM-IV and DIDIM, and least squares and instruments of each model; otherwise
        least squares of both models. Only pairs with both estimates are included.
        """
        pairs: tuple[str, ...] = (DDM_LESS_IDM,)
        if any(each.Z is not None for each in self.estimates.values()):
            pairs = (SECOND_OPINION, *LS_LESS_IV)
        is_weak = isinstance(self.strength, Check) and self.strength.status != "pass"
        compared: dict[str, Mapping[str, HausmanTest] | Missing] = {}
        for pair in pairs:
            first, second = pair.split(LESS)
            if not {first, second} <= {*self.estimates}:
                continue
            if is_weak:
                reason = "the instruments are too weak for a comparison of the estimates"
                compared[pair] = Missing(reason)
            else:
                compared[pair] = (self.whole or self)._difference(first, second)
        return compared
