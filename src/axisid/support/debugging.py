"""Whether whoever runs the program asked to see where it faults."""

import os


def asks_for_tracebacks() -> bool:
    """Whether ``AXISID_DEBUG`` is set: a fault then ends the program where it is."""
    return bool(os.environ.get("AXISID_DEBUG"))
