"""Fits of the output error as methods of a study: ``fit:control``, ``fit:position``."""

from axisid.estimation.choices import fit_names, fitted_output
from axisid.support.errors import UsageError
from axisid.support.user_values import is_among, quoted

#: What the intervals of a fit are of: errors that follow an autoregression.
COLOURED, IID = "coloured", "iid"


def stated_by(method: str, chosen: str) -> str:
    """What the printed intervals of a method are of: those of identifications are chosen."""
    return COLOURED if fitted_output(method) else chosen


def split_methods(methods: tuple[object, ...]) -> tuple[list[object], list[str]]:
    """Methods of `identify`, unchecked, and fits.

    Raises
    ------
    UsageError
        There is no fit of such an output.
    """
    others: list[object] = []
    fits: list[str] = []
    for method in methods:
        if not (isinstance(method, str) and fitted_output(method)):
            others.append(method)
        elif is_among(method, fit_names()):
            fits.append(method)
        else:
            raise UsageError(
                f"there is no method {quoted(method)}; the fits are {', '.join(fit_names())}.",
                code="unknown-fit",
            )
    return others, fits
