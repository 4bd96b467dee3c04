"""Choice of the method whose estimate is reported and checked."""

from collections.abc import Callable, Mapping

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import DirectForm
from axisid.support.missing import Missing

from .agreement_of_estimates import less_precise
from .hausman import HausmanTest, significant_differences

Differences = Mapping[str, HausmanTest] | Missing


def judged_method(
    estimates: Mapping[str, Estimate],
    laws_hold: Callable[[], bool],
    iv_less_didim: Callable[[], Differences],
    level: float,
) -> str:
    """Return the method to report and check: instruments, output error, or least squares.

    Output error (DIDIM) relies on the declared control law. It is reported where every record
    follows its law, except where instruments differ from it significantly and are more precise.
    Otherwise instruments are reported where there are any. The inverse model comes before the
    direct one.

    Parameters
    ----------
    estimates : mapping of str to Estimate
        Estimates by method.
    laws_hold : callable
        Whether the control of every record follows the declared law; called only if needed.
    iv_less_didim : callable
        Differences of IDM-IV minus DIDIM, or the reason why there are none; called only if needed.
    level : float
        Significance level of these differences.
    """
    first, by_law = _best(estimates, by_law=False), _best(estimates, by_law=True)
    if by_law == first or not laws_hold():
        return first
    apart = iv_less_didim()
    if isinstance(apart, Missing):
        return by_law
    moved = significant_differences(apart, level)
    if less_precise(moved, estimates[first], estimates[by_law]):
        return first
    return by_law


def _best(estimates: Mapping[str, Estimate], *, by_law: bool) -> str:
    """Return the preferred method among those with an estimate.

    Methods with instruments or simulated rows come before least squares. With `by_law`, output
    error then comes before instruments, otherwise after them. Among methods that are equal in this,
    those of the inverse model come before those of the direct one.
    """

    def order(method: str) -> tuple[bool, bool, bool]:
        """Return the key of a method by which the preferred one is the smallest."""
        estimate = estimates[method]
        is_direct = isinstance(estimate.form, DirectForm)
        return estimate.Z is None, estimate.by_output_error != by_law, is_direct

    return min(estimates, key=order)
