"""Statistics that say whether instruments can be believed.

First-stage F, alone and conditional on the other columns, and Shea's partial R squared.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import factor
from axisid.estimation.thresholds import (
    MIN_FIRST_STAGE_F,
)
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

_NOTHING = 1e-9  # of the column


@dataclass(frozen=True, slots=True, kw_only=True)
class Strength:
    """How strongly the instruments move one column of the regressor.

    Attributes
    ----------
    r_squared : float
        Of the column's regression on the instruments.
    shea : float
        The same beyond what the other columns' regressions explain.
    f : float
        F statistic of the regression; infinite where it is exact.
    conditional_f : float
        That of [SandersonWindmeijer2016]_, of what the other columns leave of this one:
        instruments may explain each of two columns well and yet not tell them apart.
    """

    r_squared: float
    shea: float
    f: float
    conditional_f: float


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTests:
    """Instruments against the regressor.

    Attributes
    ----------
    columns : tuple of Strength
    condition_number : float
        Of ``Z'X`` for unit columns.
    """

    columns: tuple[Strength, ...]
    condition_number: float

    @property
    def weakest(self) -> float:
        """Smallest conditional F."""
        return min(column.conditional_f for column in self.columns)


def strength_check(judged: Estimate, tests: InstrumentTests | Missing) -> Check | Missing:
    """The weakest column of the regressor of an instrumental estimate, or of one beside `judged`.

    Beside an estimate by output error, which rests on the loop's own rows, weak ones are a note.
    """
    if isinstance(tests, Missing):
        return tests
    names = [q.label for q in judged.form.quantities]
    weakest = min(range(len(names)), key=lambda j: tests.columns[j].conditional_f)
    f = tests.weakest
    strong = f >= MIN_FIRST_STAGE_F.value
    return Check(
        name="instrument strength",
        status=passed(strong, matters=not judged.by_output_error),
        figure=f if np.isfinite(f) else None,
        threshold=MIN_FIRST_STAGE_F.value,
        source="first-stage F of 10, the rule of Staiger and Stock (1997); conditional on the "
        "other columns as in Sanderson and Windmeijer (2016)",
        meaning="the simulated loop explains every column of the regressor"
        if strong
        else f"the simulated loop hardly explains the column of {names[weakest]}: its estimate "
        "by instruments cannot be believed",
    )


def tests_of_instruments(estimate: Estimate | None) -> InstrumentTests | Missing:
    """`instrument_tests` of an estimate's rows, where it has instruments and they tell it."""
    if estimate is None or estimate.Z is None:
        return Missing("no method with instruments gave an estimate")
    names = [q.label for q in estimate.form.quantities]
    try:
        return instrument_tests(estimate.X, estimate.Z, names)
    except EstimationError as error:
        return Missing.of(error.note)


def instrument_tests(X: Array, Z: Array, names: Sequence[str]) -> InstrumentTests:
    """First stage of every column, as in linearmodels' diagnostics.

    Parameters
    ----------
    X, Z : (n, k) arrays
        Regressor and instruments.
    names : sequence of str
        Of the columns' parameters.

    Raises
    ------
    EstimationError
        Either has not full column rank, as where one of several records does not show what all do.
    """
    n, k = X.shape
    regressor, instruments = factor(X, names), factor(Z, names, "the simulated loop")
    basis = instruments.basis.astype(float)
    fitted = basis @ (basis.T @ X)
    seen = factor(fitted, names, "the instruments together with the record")
    plain, projected = (np.sum(each.inverse**2, axis=1) for each in (regressor, seen))
    explained, unseen = np.sum(fitted**2, axis=0), X - fitted
    unexplained = np.sum(unseen**2, axis=0)
    # Of each column what the others, by two-stage least squares, leave; they take k - 1 of the
    # k instruments.
    beside = unseen @ (seen.inverse @ seen.inverse.T / projected).astype(float)
    is_exact = unexplained <= (_NOTHING * regressor.scale) ** 2
    told = np.where(is_exact, 0.0, np.sum(beside**2, axis=0)) / (n - k)
    with np.errstate(divide="ignore"):
        columns = zip(
            explained / (explained + unexplained),
            np.minimum(plain / projected, 1.0),
            explained / k / (unexplained / (n - k)),
            1 / projected / told,
            strict=True,
        )
    product = (Z / np.linalg.norm(Z, axis=0)).T @ (X / regressor.scale)
    return InstrumentTests(
        columns=tuple(
            Strength(r_squared=float(r), shea=float(shea), f=float(f), conditional_f=float(c))
            for r, shea, f, c in columns
        ),
        condition_number=float(np.linalg.cond(product)),
    )
