"""The parametric bootstrap of a problem's estimates: twins of its records, the same for all."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from axisid.estimation.problems import Problem
from axisid.estimation.regression import Hac
from axisid.estimation.simulation import Simulation
from axisid.estimation.twins import Chain, Twins, calibrated, measured_chain
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError, ModelError

from .method import Fit
from .methods import METHODS

TOO_FEW = "more than half of the loops with its noise cannot be simulated, or estimated from"
_ROUNDS = 4
_SETTLED = 0.3  # deviations by which the parameters of the twins' loops still move


@dataclass(frozen=True, kw_only=True)
class Bootstrap:
    """Twins of the records of a problem.

    Their loops are those of the output error of the force, or of instruments where that comes to
    nothing, less its bias, which is found again where it leads: noise in the loop biases it least.
    What is judged by the twins is any method.

    Attributes
    ----------
    problem : Problem
    count : int
    """

    problem: Problem
    count: int

    @cached_property
    def twins(self) -> Twins | str:
        """Or why there are none."""
        if any(data.record.motion != ("position",) for data in self.problem.data):
            return "what is measured beside the position has noise that is not known"
        why = "the loop does not follow the record"
        for method in ("didim", "idm-iv"):
            try:
                fit = METHODS[method].fit(self.problem)
                if fit.follows:
                    return self._settled(fit)
            except (ModelError, DataError, EstimationError) as error:
                why = error.problem.rstrip("; ")
        return why

    def _settled(self, fit: Fit) -> Twins | str:
        form, solution, problem = fit.form, fit.solution, self.problem
        physical = at = form.physical(solution.theta)[0]
        model, loops = Hac(), fit.loops
        deviations = np.sqrt(np.diag(model.matrix(solution)))
        freedom = np.full(len(solution.theta), np.inf)
        for _ in range(_ROUNDS):
            chains = self._chains(fit, at, loops)
            if all(each.is_silent for each in chains):
                return "no noise is measured beside the loop"
            twins = Twins(problem=problem, form=form, at=at, chains=chains, count=self.count)
            found = calibrated(twins, form, fit.solver, solution, model, freedom)
            if found is None:
                return TOO_FEW
            before, at = at, physical - found.bias
            apart = np.abs(form.regressed(at) - form.regressed(before))
            if np.all(apart <= _SETTLED * found.own_scale * deviations):
                return twins
            loops = problem.loops(form, at)
        return "the parameters of their loops do not settle"

    def _chains(
        self, fit: Fit, physical: Array, loops: tuple[Simulation, ...]
    ) -> tuple[Chain, ...]:
        of_records = self.problem.by_record(loops)
        return tuple(
            measured_chain(data, fit.form.own(physical, i), own)
            for i, (data, own) in enumerate(zip(self.problem.data, of_records, strict=True))
        )
