"""The drive: what turns a control signal into force."""

import math
from dataclasses import dataclass

import sympy

from axisid.modeling.quantities import expression, number, parse_unit
from axisid.support.errors import ModelError


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A drive: ``tau = gain * control``, the control clipped at `limit`.

    Attributes
    ----------
    gain : float
        Force per control, in the coordinate's force unit over `unit` (N/V).
    unit : str
        Unit of the control signal.
    limit : float
        Largest absolute control, in `unit`; infinite for none.
    relative_sd : float
        Standard deviation of the gain over the gain, 0.005 for 0.5 %. What it adds to the
        estimates is shown apart from their statistical uncertainty.
    profile : expression
        The force at a position over its nominal value `tau`, from the coordinate and constants: a
        motor whose force constant depends on the position. It divides the force balance, so that
        `tau`, and a force column of a record, are nominal; the inertia that `tau` sees then depends
        on the position, and there is no direct regressor.

    References
    ----------
    Equation (5) of [Brunot2015]_.
    """

    gain: float
    unit: str = "V"
    limit: float = math.inf
    relative_sd: float = 0.0
    profile: sympy.Expr = sympy.S.One

    def __post_init__(self) -> None:
        parse_unit(self.unit)
        object.__setattr__(self, "gain", number(self.gain, "the drive gain"))
        object.__setattr__(self, "limit", number(self.limit, "the drive limit", finite=False))
        if self.gain == 0:
            raise ModelError(f"the drive gain is {self.gain!r}; give a finite number other than 0.")
        object.__setattr__(
            self, "relative_sd", number(self.relative_sd, "the drive gain's relative deviation")
        )
        if not 0 <= self.relative_sd < 1:
            raise ModelError(
                f"the drive gain's relative deviation is {self.relative_sd!r}; give a fraction "
                "from 0 to below 1, such as 0.005 for 0.5 %."
            )
        object.__setattr__(self, "profile", expression(self.profile, "the drive's profile"))
        if not self.limit > 0:
            raise ModelError(f"the drive limit is {self.limit!r}; give a positive number.")
