"""Where the instruments' iteration starts: at least squares, where its loop follows the records.

Least squares is nearer to the end than nominal values mostly are, and asks nothing of them. Noise
may move it so far that the loop simulated with it is no instrument; then the nominal values serve.
"""

from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.choices import LEAST_SQUARES_START, NOMINAL_START
from axisid.estimation.problems import Problem
from axisid.estimation.regression import Form, InverseForm, least_squares
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds import MAX_SIMULATION_ERROR
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError
from axisid.support.remedy import Note

from .least_squares import least_squares_point

_FROM_NOMINAL = "the iteration starts from the nominal values, since "


@dataclass(frozen=True, slots=True)
class Start:
    """Where an iteration starts.

    Attributes
    ----------
    physical : (p,) array
    named : {"least-squares", "nominal"}
    loops : tuple of Simulation
        Simulated with it; empty where they are still to be.
    why_not : Note or None
        Why it does not start from least squares, where it was to.
    right : tuple of array or None
        Intercept and regressor of the loops, reduced, where the iteration's own form made them.
    """

    physical: Array
    named: str
    loops: tuple[Simulation, ...] = ()
    why_not: Note | None = None
    right: tuple[Array, Array] | None = None


def start_of(problem: Problem, form: Form, asked: str) -> tuple[Form, Start]:
    """A form, where it is linearised, and where its iteration starts.

    What is not linear is searched for widely by least squares, from where instruments go on
    whatever is asked for. Both forms start from the inverse model's least squares: they are one
    estimate.

    Raises
    ------
    EstimationError
        A model that is not linear has no least squares.
    """
    if not form.is_linear:
        form = least_squares_point(form, problem.rows)
        return form, Start(form.start, LEAST_SQUARES_START)
    if asked == NOMINAL_START:
        return form, nominal_start(form)
    start = _of_least_squares(problem)
    return form, start if isinstance(form, InverseForm) else replace(start, right=None)


def nominal_start(form: Form, why_not: Note | None = None) -> Start:
    """The nominal values of a linear model, and why it is not least squares."""
    said = None if why_not is None else Note.of(_FROM_NOMINAL, why_not)
    return Start(form.start, NOMINAL_START, why_not=said)


def _of_least_squares(problem: Problem) -> Start:
    """Least squares of the inverse model, or the nominal values where that does not serve."""
    form = problem.form(InverseForm)
    try:
        measured = problem.rows(form)
        left = measured.left - measured.intercept
        physical = least_squares(left, problem.factored(form, measured)).theta
        loops = problem.loops(form, physical)
        intercept, right = problem.right_of(form, physical, loops)
    except (DataError, EstimationError) as error:
        return nominal_start(form, error.note)
    unexplained = relative_error_percent(
        measured.left - right @ physical - intercept, measured.left
    )
    if not unexplained < MAX_SIMULATION_ERROR.value:
        said = f"the loop of least squares leaves {unexplained:.3g} % of the force unexplained"
        return nominal_start(form, Note(said))
    return Start(np.asarray(physical), LEAST_SQUARES_START, loops, right=(intercept, right))
