"""What NumPy says of arithmetic beyond floating point, which is no user's business."""

import warnings


def without_arithmetic_warnings() -> None:
    """Have this process say nothing of its arithmetic: what comes of it is judged and told."""
    warnings.filterwarnings("ignore", ".* encountered in ", RuntimeWarning)
