"""The control law of an axis that has one."""

from axisid.codegen.artefacts import GeneratedAxis
from axisid.modeling.declaration import ControlLaw


def law_of(axis: GeneratedAxis) -> ControlLaw:
    """The control law of an axis that is known to have one."""
    law = axis.axis.control
    assert law is not None  # noqa: S101  # whoever asks has refused an axis without one
    return law
