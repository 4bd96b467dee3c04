"""What a method of estimation is."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

from axisid.estimation.regression import Equations, Form, Solution
from axisid.support.arrays import Array

from .fit import Fit
from .problem import Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Method(ABC):
    """A way from a problem's rows to an estimate.

    Attributes
    ----------
    name : str
        As users give it, ``idm-ls``.
    form : type of Form
        That is regressed.
    """

    name: str
    form: type[Form]

    @abstractmethod
    def fit(self, problem: Problem) -> Fit:
        """Solve the rows.

        Raises
        ------
        ModelError
            The axis has no such form.
        EstimationError
            The rows cannot be solved; what is missing is named.
        """


def at_point(solution: Solution, measured: Equations, physical: Array) -> Solution:
    """A solution moved to where the measured rows are linearised, (p,): their residuals there."""
    left = measured.left - measured.known - measured.regressor @ physical
    return replace(solution, theta=physical, residuals=left)
