"""Instruments beside least squares that has none, so that what noise does to it is told.

They are those that would have been given had they been asked for; where there is a reference, or a
sampled law and its period, they cost a few simulated loops.
"""

from collections.abc import Mapping

import numpy as np

from axisid.estimation.checks import Check
from axisid.estimation.choices.methods import instruments_of
from axisid.estimation.diagnostics.estimates import strength_check, tests_of_instruments
from axisid.estimation.estimates import Estimate
from axisid.estimation.methods import METHODS, Bootstrap, estimate_by
from axisid.estimation.problems import Problem
from axisid.estimation.regression import Hac
from axisid.estimation.twins import DEFAULT_COUNT
from axisid.support.errors import AxisidError
from axisid.support.missing import Missing


def instruments_beside(problem: Problem, ls: Estimate) -> Estimate | Missing:
    """Instruments of the form of least squares, or why nothing is told by them.

    Parameters
    ----------
    problem : Problem
        What `ls` was made from.
    ls : Estimate
    """
    model = ls.covariance_model
    lags = model.lags if isinstance(model, Hac) else None
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused by name
            method = METHODS[instruments_of(ls.method)]
            known = ls.filter_bias is not None
            twins = Bootstrap(problem=problem, count=DEFAULT_COUNT, methods=(method.name,))
            iv = estimate_by(problem, method, lags, ls.chosen, twins if known else None)
    except AxisidError as error:
        return Missing.of(error.note)
    strength = strength_check(iv, tests_of_instruments(iv))
    if isinstance(strength, Check) and strength.status == "fail":
        return Missing("the instruments are too weak to tell")
    return iv


def without_instruments(estimates: Mapping[str, Estimate]) -> Estimate | None:
    """Least squares, inverse model first, where nothing is by instruments; None for none."""
    if any(estimate.Z is not None for estimate in estimates.values()):
        return None
    able = [e for e in estimates.values() if instruments_of(e.method)]
    return min(able, key=lambda estimate: estimate.is_direct, default=None)
