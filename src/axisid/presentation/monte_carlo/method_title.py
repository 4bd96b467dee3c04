"""How tables and figures of a study call a method."""

from axisid.estimation.choices import fitted_output


def method_title(method: str) -> str:
    """``IDM-IV``; a fit as it is asked for, ``fit:control``."""
    return method if fitted_output(method) else method.upper()
