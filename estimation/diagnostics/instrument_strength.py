"""How strong the instruments of an estimate are.

By the first-stage F, alone and conditional on the other columns, and Shea's partial R squared.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from axisid.estimation.diagnostic_checks import Check, status_of, unless_faulty
from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import factor
from axisid.estimation.thresholds import MIN_FIRST_STAGE_F
from axisid.support.arrays import Array, MaybeInfinite, MaybeNan
from axisid.support.errors import Missing, unless_missing


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentStrength:
    """How strongly the instruments move one column of the regressor.

    Attributes
    ----------
    r_squared : float
        Of the column's regression on the instruments.
    shea : float
        The same beyond what the other columns' regressions explain.
    f : float
        F statistic of the regression; infinite, or null, for an exact one.
    conditional_f : float
        Conditional on the other columns [SandersonWindmeijer2016]_, of what they leave of this one:
        instruments may explain each of two columns well and yet not tell them apart. Infinite, or
        null, where it is exact.
    """

    r_squared: MaybeNan
    shea: MaybeNan
    f: MaybeInfinite
    conditional_f: MaybeInfinite


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTests:
    """Instruments against the regressor.

    Attributes
    ----------
    columns : tuple of InstrumentStrength
    condition_number : float
        Of ``Z'X``, unit columns.
    """

    columns: tuple[InstrumentStrength, ...]
    condition_number: MaybeInfinite


@unless_missing
def strength_check(tests: InstrumentTests, judged: Estimate) -> Check:
    """The weakest column of the regressor of an instrumental estimate, or of one beside `judged`.

    Beside an estimate by output error, which rests on the loop's own rows, weak ones are a note.
    """
    j, f = min(enumerate(c.conditional_f for c in tests.columns), key=lambda each: each[1])
    strong = f >= MIN_FIRST_STAGE_F.value
    return Check(
        name="instrument strength",
        status=status_of(strong, matters=not judged.by_output_error),
        figure=f if np.isfinite(f) else None,
        threshold=MIN_FIRST_STAGE_F.value,
        source="first-stage F of 10, the rule of Staiger and Stock (1997); conditional on the "
        "other columns as in Sanderson and Windmeijer (2016)",
        meaning="the simulated loop explains every column of the regressor"
        if strong
        else "the simulated loop hardly explains the column of "
        f"{judged.form.quantities[j].label}: its estimate by instruments cannot be believed",
    )


def tests_of_instruments(estimate: Estimate | None) -> InstrumentTests | Missing:
    """`instrument_tests` of an estimate's rows, weighted by their records, where they tell it."""
    if estimate is None or estimate.Z is None:
        return Missing("no method with instruments gave an estimate")
    X, Z = (estimate.weights[:, None] * each for each in (estimate.X, estimate.Z))
    return unless_faulty(
        partial(instrument_tests, X, Z, [q.label for q in estimate.form.quantities])
    )


@np.errstate(divide="ignore")
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
    is_exact = unexplained <= (1e-9 * regressor.scale) ** 2
    columns = zip(
        explained / (explained + unexplained),
        np.minimum(plain / projected, 1.0),
        explained / k / (unexplained / (n - k)),
        1 / projected / (np.where(is_exact, 0.0, np.sum(beside**2, axis=0)) / (n - k)),
        strict=True,
    )
    return InstrumentTests(
        columns=tuple(
            InstrumentStrength(
                r_squared=float(r), shea=float(shea), f=float(f), conditional_f=float(c)
            )
            for r, shea, f, c in columns
        ),
        condition_number=float(
            np.linalg.cond((Z / np.linalg.norm(Z, axis=0)).T @ (X / regressor.scale))
        ),
    )
