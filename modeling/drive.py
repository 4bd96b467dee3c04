"""The drive: what turns a control signal into force."""

import math
from dataclasses import dataclass

from .errors import ModelError
from .units import parse_unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A drive with constant gain: ``tau = gain * control``, the control clipped at `limit`.

    Attributes
    ----------
    gain : float
        Force per control, in the coordinate's force unit over `unit` (N/V).
    unit : str
        Unit of the control signal.
    limit : float
        Largest absolute control, in `unit`; infinite for none.

    References
    ----------
    Equation (5) of [Brunot2015]_.
    """

    gain: float
    unit: str = "V"
    limit: float = math.inf

    def __post_init__(self) -> None:
        parse_unit(self.unit)
        if not (math.isfinite(self.gain) and self.gain != 0):
            raise ModelError(f"the drive gain is {self.gain!r}; give a finite number other than 0.")
        if not self.limit > 0:
            raise ModelError(f"the drive limit is {self.limit!r}; give a positive number.")
