"""Errors of data and of estimation; see `axisid.modeling.errors` for the others."""

from axisid.modeling import AxisidError


class DataError(AxisidError):
    """The record is missing, malformed, or cannot serve what is asked of it."""

    exit_code = 3


class EstimationError(AxisidError):
    """The record was read, but no estimate came of it."""

    exit_code = 6
