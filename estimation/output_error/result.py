"""The result of a fit of outputs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import CONTROL, OPEN_LOOP
from axisid.estimation.diagnostics.control_law import (
    CONSTANT,
    DRIFT,
    GAINS,
    SCALE,
    EstimatedGains,
    LawAgreement,
    first_failing,
    found_law_agreement,
)
from axisid.estimation.estimates import Value, degrees_of_freedom_of
from axisid.estimation.methods import filtered_record
from axisid.estimation.misspecification import Misspecification, find_misspecification, scores_of
from axisid.estimation.output_residuals import record_rows
from axisid.estimation.signals import Prefilter
from axisid.estimation.unknowns import axis_at
from axisid.estimation.verdict_checks import (
    DEFAULT_LEVELS,
    Check,
    Checked,
    Levels,
    NotUsed,
    unless_faulty,
    value_or,
)
from axisid.modeling.parsing import FunctionLike
from axisid.support.arrays import Array, Exact, MaybeInfinite
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable

from .covariance import UnseenDirection, named_directions
from .fit_search import FitSearch
from .inference import FitInference, inferred
from .parametric_bootstrap import (
    PERCENT,
    MovesByExplanation,
    moves_by_explanation,
    outputs_by_noise,
)

_OF_POSITION = 16  # simulated replicas with noise of the position only


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordError:
    """Error of the simulated output of a fit relative to the recorded output of one record.

    Attributes
    ----------
    output : str
        Fitted output; empty in files of earlier versions, for one output.
    unit : str
        Unit of the output.
    weight : float
        Weight of the errors in the fit, 1/unit of the output.
    rows : int
        Number of samples that are used.
    error : float
        Root mean square error, in the output's unit.
    percent : float
        Error relative to the recorded output (rms), %.
    order : int
        Order of the autoregression of the errors, of all outputs together.
    noise : float
        Root mean square of the noise in the error, in the output's unit: the effect of the record's
        white position noise in the loop, or the innovation of the autoregression of the errors,
        whichever is larger.
    """

    output: str = ""
    unit: str = ""
    weight: float = 1.0
    rows: int
    error: float
    percent: MaybeInfinite
    order: int
    noise: float

    @property
    def percent_beyond_noise(self) -> float:
        """Error beyond noise (rms), % of the recorded output (rms)."""
        share = 1 - (self.noise / self.error) ** 2 if self.error else 0.0
        return self.percent * float(np.sqrt(max(share, 0.0)))


@dataclass(frozen=True, kw_only=True, eq=False)
class OutputFit(FitSearch, FitInference, Checked, Presentable, Exact):
    """Parameters whose simulated output follows that of the records.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis with its declared values.
    records : tuple of Record
        Fitted records.
    outputs : tuple of str
        Fitted outputs: ``control``, ``position``, ``force``, or ``open-loop`` alone.
    loss : str
        ``squares``, ``soft-l1`` or ``huber``.
    parameters : NamedValues
        Values by name, with unit, standard errors and 95 % interval.
    start : (P,) array
        Parameters at which the first search started, SI.
    started : str
        Kind of the start: ``instruments``, ``least-squares``, ``nominal`` or ``given``.
    remarks : tuple of str
        Reasons why other starts were not used.
    without_prior : mapping of str to (float, float)
        Estimates of parameters with a prior value from the records alone, with standard errors, by
        name.
    judge : callable
        Function that returns the checks of a fit.
    levels : Levels
        Levels from which checks report a missing term or a difference.
    """

    without_prior: Mapping[str, tuple[float, float]] = field(repr=False, compare=False)
    judge: Callable[["OutputFit"], tuple[Check, ...]] = field(repr=False, compare=False)
    levels: Levels = DEFAULT_LEVELS

    @classmethod
    def of(
        cls,
        search: FitSearch,
        judge: Callable[["OutputFit"], tuple[Check, ...]],
        levels: Levels,
    ) -> "OutputFit":
        """Return the result of the searches of a fit, with its inference.

        Parameters
        ----------
        search : FitSearch
            The finished searches.
        judge : callable
            Returns the checks of the result.
        levels : Levels
            Levels from which checks report a missing term or a difference.
        """
        u, inference = search.unknowns, inferred(search)
        without_prior: dict[str, tuple[float, float]] = {}
        if search.alone is not None:
            alone = inferred(replace(search, unknowns=u.without_prior, best=search.alone))
            deviations = np.sqrt(np.maximum(alone.variances, 0.0))
            without_prior = {
                u.names[j]: (float(alone.physical[j]), float(deviations[j]))
                for j in np.flatnonzero(u.has_prior)
            }
        return cls(
            **vars(search),
            **vars(inference),
            without_prior=without_prior,
            judge=judge,
            levels=levels,
        )

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for a pickle: results from simulated replicas, without the replicas.

        The replicas are left out because of their size.
        """
        names = (each.name for each in fields(self))
        state = {
            n: getattr(self, n)
            for n in (*names, "law_moves_by_explanation", "lacks", "of_records", "checks")
        }
        sandwich = replace(self.judged_sandwich, twins=None)
        return state | {
            "predictions_with_changed_known": (),
            "loops": (),
            "judged_sandwich": sandwich,
        }

    @cached_property
    def axes(self) -> tuple[GeneratedAxis, ...]:
        """The axis of each record, with the estimated gains of the control law."""
        return tuple(axis_at(axis, self.form, self.physical) for axis in self.form.axes)

    @property
    def at_bound(self) -> Mapping[str, Literal["lower", "upper"]]:
        """Side of the bound, ``lower`` or ``upper``, by name of each parameter at a bound.

        The interval of such a parameter begins at the bound and is on the allowed side.
        """
        return {each.name: "lower" if each.is_lower else "upper" for each in self.held}

    @property
    def bounds(self) -> Mapping[str, tuple[float, float]]:
        """Lower and upper bound of each parameter in the fit, SI, by name."""
        u = self.unknowns
        return {n: (float(a), float(b)) for n, a, b in zip(u.names, u.lower, u.upper, strict=True)}

    @property
    def fixed(self) -> Mapping[str, float]:
        """Values of the fixed parameters, SI, by name."""
        u = self.unknowns
        return {u.names[j]: float(u.fixed[j]) for j in np.flatnonzero(~u.free)}

    @property
    def prior(self) -> Mapping[str, tuple[float, float]]:
        """Prior value and its standard error, SI, by name of each parameter with a prior value."""
        u = self.unknowns
        return {
            u.names[j]: (float(u.prior[j]), float(u.prior_sd[j]))
            for j in np.flatnonzero(u.has_prior)
        }

    @property
    def unseen(self) -> tuple[UnseenDirection, ...]:
        """Parameters, or combinations of them, that neither outputs nor prior values show."""
        return named_directions(*self.not_shown, self.names)

    @property
    def local(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the parameters, one for each record, by name of the local parameter."""
        return self.form.local

    @cached_property
    def of_records(self) -> tuple[RecordError, ...]:
        """Errors of the simulated outputs, one for each output of each record.

        The noise in an error is the larger one of two estimates: the effect of position noise in
        simulated replicas, and the innovation of the autoregression of the errors.
        """
        # Effect of position noise in replicas; missing terms would look like disturbance forces.
        weights, outputs, errors = self.weighing.weights, self.outputs, []
        twins = value_or(
            np.zeros((len(weights), 1)),
            partial(
                outputs_by_noise,
                self.loops,
                self.best.physical,
                self.predictions,
                _OF_POSITION,
                disturbed=False,
                paired=False,
            ),
        )
        models = self.judged_sandwich.autoregressions
        for spans, model in zip(self.predictions.spans, models, strict=True):
            every = zip(outputs, self.predictions.units, np.diag(model.variance), strict=True)
            for place, (output, unit, variance) in enumerate(every):
                rows = record_rows(spans, place, len(outputs))
                used, weight = weights[rows] > 0, float(weights[rows].max())
                # Error of this output of this record, relative to the recorded output.
                e, y = (x[rows][used] for x in (self.best.errors, self.predictions.measured))
                error, size = float(np.linalg.norm(e)), float(np.linalg.norm(y))
                percent = 0.0
                if size:
                    percent = 100 * error / size
                elif error:
                    percent = float("inf")
                # Variance of the noise in the weighted error: the larger of the two estimates.
                by_twins = (weights[rows][used, None] * twins[rows][used]) ** 2
                noise = max(variance, float(by_twins.mean()) if len(e) else 0.0, 0.0)
                errors.append(
                    RecordError(
                        output=output,
                        unit=unit,
                        weight=weight,
                        rows=len(e),
                        error=error / max(len(e), 1) ** 0.5,
                        percent=percent,
                        order=model.order,
                        noise=float(np.sqrt(noise)) / (weight or 1.0),
                    )
                )
        return tuple(errors)

    @property
    def errors(self) -> tuple[Array, ...]:
        """Simulated minus recorded output by record, (N,); (N, m) for m outputs."""
        errors, count = self.best.errors, len(self.outputs)
        whole = (errors[record_rows(spans)] for spans in self.predictions.spans)
        return tuple(whole) if count == 1 else tuple(each.reshape(-1, count) for each in whole)

    @cached_property
    def law(self) -> LawAgreement | Missing:
        """Agreement of the declared law with the recorded control, for the first record that fails.

        That of the first record if no record fails; Missing if the law cannot be compared.
        """
        return first_failing(self.laws)

    @cached_property
    def law_moves(self) -> Mapping[str, Array]:
        """Change of the parameters if a term of the control law were 1 % larger, (P,) by term.

        Empty if there is no sampled law, or if a loop cannot be simulated.
        """
        moves = value_or(({},), lambda: self._moves_of_records)
        return {name: np.asarray(np.sum([of[name] for of in moves], axis=0)) for name in moves[0]}

    @cached_property
    def law_move(self) -> Array | None:
        """Change of the parameters if the law had the gains of the recorded control, (P,).

        None if no record shows these gains, or if the change could not be calculated.
        """
        return self.law_shift[0] if isinstance(self.law_shift, tuple) else None

    @property
    def law_shift(self) -> tuple[Array, Array] | Missing | None:
        """Change of the parameters if the law had the gains that the recorded control shows.

        The change and its standard errors, (P,) each. None if no record shows these gains; Missing
        if the change could not be calculated.
        """
        moves = self.law_moves_by_explanation
        return moves if isinstance(moves, Missing) else moves.get((GAINS,))

    @cached_property
    def law_moves_by_explanation(self) -> MovesByExplanation | Missing:
        """Changes of the parameters by each explanation of the difference from the declared law.

        The explanations are other gains, and every plausible explanation of the recorded control,
        such as a scale or an offset; changes and standard errors are by kind of explanation.
        Missing if they could not be calculated.
        """
        return unless_faulty(
            lambda: moves_by_explanation(
                self._slopes_by_explanation, self.laws, self.loops, self.estimated_gains
            )
        )

    @cached_property
    def _slopes_by_explanation(self) -> tuple[Mapping[str, Array], ...]:
        """Derivatives of the parameters, (P,), by each value of an `Explanation`, by record.

        Values are factors of the law's terms, and scale, constant and drift of the recorded
        control. Scale, constant and drift have no effect on a fit of other outputs than the
        control.
        """
        slopes = []
        for spans, moves in zip(self.predictions.spans, self._moves_of_records, strict=True):
            of = {name: move / PERCENT for name, move in moves.items()}
            of |= dict.fromkeys((SCALE, CONSTANT, DRIFT), np.zeros(len(self.physical)))
            if CONTROL in self.outputs:
                rows = record_rows(spans, self.outputs.index(CONTROL), len(self.outputs))
                influence, control = self.influence[:, rows], self.predictions.measured[rows]
                over_time = np.linspace(-0.5, 0.5, len(control))
                # The recorded control is larger than the acting one by this value.
                of[SCALE] = -influence @ control
                of[CONSTANT] = -influence.sum(axis=1)
                of[DRIFT] = -influence @ over_time
            slopes.append(of)
        return tuple(slopes)

    @cached_property
    def _moves_of_records(self) -> tuple[Mapping[str, Array], ...]:
        """Changes of the parameters, (P,) by term, if a term of a record's law were 1 % larger.

        One mapping for each record.
        """
        slopes = self.predictions.jacobian_by_law(self.physical)
        return tuple(
            {name: -PERCENT * (self.influence[:, r] @ slope[r]) for name, slope in slopes.items()}
            for r in map(record_rows, self.predictions.spans)
        )

    @cached_property
    def lacks(self) -> tuple[tuple[Misspecification, ...] | Missing, ...]:
        """Misspecifications of the model by record, the largest first.

        Misspecifications are missing terms and outliers, among others. Missing for a record in
        which they cannot be searched.
        """
        return tuple(
            unless_faulty(partial(self._misspecifications_of, i)) for i in range(len(self.records))
        )

    def _misspecifications_of(self, number: int) -> tuple[Misspecification, ...] | Missing:
        """Return the misspecifications that one record shows (`number`, from 0).

        Missing terms do not depend on the fitted output: they are searched in the residual of the
        inverse model at the parameters of the fit, and compared with simulated replicas of the
        record. The intervals of the record's parameters tell which effects are relevant. Missing
        for friction with internal state.
        """
        axis, loops = self.axes[number], self.loops[number]
        if axis.states:
            return Missing(
                "missing terms are searched in the rows of the inverse model, which friction with "
                "internal state does not have"
            )
        data = filtered_record(axis, self.records[number], Prefilter())
        # Derivatives of the record's parameters by those of the fit, and the record's parameters
        # that depend on a parameter that was estimated from the records alone.
        model, searched = self.form.of_model, set(self.searched) - self.prior.keys()
        joint = self.physical[: len(model.physical_quantities)]
        slopes = np.zeros((len(axis.parameters), len(self.physical)))
        slopes[:, : len(joint)] = model.record_jacobian(number) @ np.linalg.inv(
            model.physical(model.regressed(joint))[1]
        )
        free = np.flatnonzero(slopes[:, [n in searched for n in self.names]].any(axis=1)).tolist()
        # Residuals of the record and of its replicas, at the record's own parameters.
        chain = None if isinstance(loops, Missing) else loops.chain
        theta = self.form.own(self.physical, number)
        scores = scores_of(data.by_position or data, theta, chain, free)
        # Half widths of the intervals of the record's parameters: each parameter separately, as an
        # infinite variance of one parameter must not reach another parameter.
        distribution = self.distribution(self.at_bound)
        half_widths: list[float] = []
        for q, row in zip(axis.parameters, slopes, strict=True):
            of_parameter = distribution.through((q,), joint[:1], row[None]).values
            half_widths += [float(np.ptp(v.interval)) / 2 or np.inf for v in of_parameter.values()]
        return find_misspecification(scores, np.array(half_widths), len(self.records), self.levels)

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Checks of the fit, in the order in which they are reported."""
        return self.judge(self)

    @cached_property
    def laws(self) -> tuple[LawAgreement | Missing, ...]:
        """Agreement of the declared law with the recorded control, by record.

        Missing for a record in which the law cannot be compared; NotUsed for an open loop.
        """
        if self.outputs == (OPEN_LOOP,):
            why = NotUsed("the open loop has the recorded control and no control law")
            return (why,) * len(self.records)
        return tuple(
            unless_faulty(partial(found_law_agreement, axis, record, self.estimated_gains))
            for axis, record in zip(self.axes, self.records, strict=True)
        )

    @cached_property
    def estimated_gains(self) -> EstimatedGains:
        """Gains of the law that the fit estimated and that are not at a bound, with covariance."""
        law = self.axis.control
        names = () if law is None else tuple(name for name in law.gains if name in self.searched)
        places = [self.names.index(name) for name in names]
        dof = min((degrees_of_freedom_of(self.parameters[name]) for name in names), default=np.inf)
        return EstimatedGains(names, self.covariance[np.ix_(places, places)], dof)

    @property
    def searched(self) -> tuple[str, ...]:
        """Names of the parameters that are neither fixed nor at a bound."""
        return tuple(n for n in self.names if n not in self.fixed and n not in self.at_bound)

    def derive(self, function: FunctionLike) -> Value:
        """Return a function of the parameters, with its unit and interval.

        Parameters
        ----------
        function : str or SymPy expression
            Function of the parameters, such as ``"M/Fv"``, as in `Estimate.derive`.

        Returns
        -------
        Value
            Value of the function, with standard errors by the delta method for every covariance.

        Raises
        ------
        UsageError
            The function cannot be read, its units do not match, or it depends on a parameter at a
            bound.
        EstimationError
            The function has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function is not linear within the uncertainty, so that the delta method is not
            accurate.
        """
        advice = "fit with bootstrap= and look at the parameters"
        return self.distribution(self.at_bound).derived(function, advice)

    @property
    def deviations(self) -> Array:
        """Standard errors of the parameters, (P,)."""
        return np.array([value.deviation for value in self.parameters.values()])

    @property
    def output(self) -> str:
        """Names of the fitted outputs as text, such as ``control and position``."""
        return " and ".join(self.outputs)

    @property
    def unit(self) -> str:
        """Unit of the first output."""
        return self.predictions.units[0]

    @property
    def error(self) -> float:
        """Root mean square error of all records, of the first output, in its unit."""
        of_first = self.of_records[:: len(self.outputs)]
        squares = sum(each.rows * each.error**2 for each in of_first)
        return float(np.sqrt(squares / sum(each.rows for each in of_first)))

    @property
    def error_percent(self) -> float:
        """Error (rms), % of the recorded output (rms); the largest over records and outputs."""
        return max(each.percent for each in self.of_records)

    @property
    def percent_beyond_noise(self) -> float:
        """Error beyond noise (rms), % of the recorded output (rms); the largest of all."""
        return max(each.percent_beyond_noise for each in self.of_records)
