"""What tests ask of a fit."""

from collections.abc import Mapping

import numpy as np

from axisid.estimation.checks import Check
from axisid.estimation.fitting import OutputFit
from axisid.support.arrays import Array

#: Of the axis `emps2015`.
TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}


def off(found: OutputFit, truth: Mapping[str, float] = TRUTH) -> Array:
    """How far parameters are from their true values, in their deviations."""
    return np.array([(found[n].value - value) / found[n].deviation for n, value in truth.items()])


def checks(found: OutputFit) -> dict[str, Check]:
    """By name."""
    return {check.name: check for check in found.checks}
