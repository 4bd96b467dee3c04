"""Choice of the method whose estimate is reported and checked."""

from collections.abc import Callable, Mapping

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import DirectForm
from axisid.support.missing import Missing

from .agreement_of_estimates import less_precise
from .hausman import HausmanTest, significant_differences

#: Tests of the difference between two estimates, by parameter, or the reason why there are none.
Differences = Mapping[str, HausmanTest] | Missing


def judged_method(
    estimates: Mapping[str, Estimate],
    laws_hold: Callable[[], bool],
    iv_less_didim: Callable[[], Differences],
    level: float,
) -> str:
    """Return the method to report and check: instruments, output error, or least squares.

    Output error (DIDIM) relies on the declared control law. It is reported where every record
    follows its law, except where the instruments give a significantly different and more precise
    estimate of a parameter. Otherwise the estimate with instruments is reported, if there is one,
    and least squares if there is none. The inverse model comes before the direct one.

    Parameters
    ----------
    estimates : mapping of str to Estimate
        Estimates by method.
    laws_hold : callable
        Function that returns True if the control of every record follows the declared law; called
        only if needed.
    iv_less_didim : callable
        Function that returns the differences of IDM-IV minus DIDIM, or the reason why there are
        none; called only if needed.
    level : float
        Significance level of these differences.
    """
    # The preferred method without and with reliance on the law.
    first, by_law = _best(estimates, by_law=False), _best(estimates, by_law=True)
    if by_law == first or not laws_hold():
        return first
    differences = iv_less_didim()
    if isinstance(differences, Missing):
        return by_law
    moved = significant_differences(differences, level)
    if less_precise(moved, estimates[first], estimates[by_law]):
        return first
    return by_law


def _best(estimates: Mapping[str, Estimate], *, by_law: bool) -> str:
    """Return the preferred method among those with an estimate.

    Methods with instruments or simulated rows come before least squares. Of these, output error
    comes first with `by_law`, otherwise instruments. Of the remaining methods, those of the inverse
    model come before those of the direct model.
    """

    def order(method: str) -> tuple[bool, bool, bool]:
        """Return the sort key of a method; the preferred method has the smallest key."""
        estimate = estimates[method]
        is_direct = isinstance(estimate.form, DirectForm)
        return estimate.Z is None, estimate.by_output_error != by_law, is_direct

    return min(estimates, key=order)
