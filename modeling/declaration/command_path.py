"""Path from a command to the acting control: rate limit, quantisation, dead band, drive times."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from axisid.modeling.quantities import Parameter, number, settle
from axisid.support.checks import refuse
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

#: Points at which a control may be recorded, the default first.
LOGGED = ("command", "applied", "current")
#: Times of a drive, and for each time the points of `LOGGED` after it. A control that was recorded
#: at one of these points does not show the time.
HIDDEN_FROM = {"lag": ("current",), "delay": ("applied", "current")}
_AMOUNTS = ("quantisation", "deadband")
_LEAST_STEP = 1e-100  # a control divided by a smaller step may overflow


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandPath:
    """Path from the commands of a sampled law to the control that acts, sample by sample.

    The rate limit comes first, then the quantisation, then the dead band.

    Attributes
    ----------
    rate_limit : float
        Largest change per second, in the control's unit; infinite for none.
    quantisation : float
        Step, in the control's unit: the control is rounded to the nearest multiple, halves up. 0
        for none.
    deadband : float
        Half width, in the control's unit: a control up to this size becomes 0, and a larger control
        is reduced by this width. 0 for none.
    """

    rate_limit: float = math.inf
    quantisation: float = 0.0
    deadband: float = 0.0

    def __post_init__(self) -> None:
        given = {name: quoted(getattr(self, name)) for name in ("rate_limit", *_AMOUNTS)}
        settle(
            self,
            rate_limit=number(self.rate_limit, "the drive's rate_limit", finite=False),
            **{n: number(getattr(self, n), f"the drive's {n}") for n in _AMOUNTS},
        )
        refuse(
            ModelError,
            (
                not self.rate_limit > 0,
                f"rate_limit is {given['rate_limit']}. Give a positive number, in the control's "
                "unit per second, or omit rate_limit",
            ),
            *(
                (
                    getattr(self, name) < 0,
                    f"{name} is {given[name]}. Give a number of 0 or more, in the control's unit",
                )
                for name in _AMOUNTS
            ),
            (
                0 < self.quantisation < _LEAST_STEP,
                f"quantisation is {self.quantisation:g}, below {_LEAST_STEP:g}, which is too small "
                "to be seen in a control. Give a step in the control's unit, or 0 for none",
            ),
            before="the drive's ",
            code="drive",
        )

    @property
    def is_plain(self) -> bool:
        """Return whether the command acts unchanged."""
        return self == CommandPath()

    @property
    def declared(self) -> dict[str, float]:
        """Return the settings that change a command, by name."""
        return {name: x for name, x in asdict(self).items() if x not in (0.0, math.inf)}

    @property
    def is_limited(self) -> bool:
        """Return whether the rate is limited, so that the last acting control must be stored."""
        return math.isfinite(self.rate_limit)

    def end(self, command: float) -> float:
        """Return the steady acting control of a constant command, in the control's unit."""
        if self.quantisation:
            command = math.floor(command / self.quantisation + 0.5) * self.quantisation
        return math.copysign(max(abs(command) - self.deadband, 0.0), command)

    def command(self, acting: float) -> float:
        """Return a constant command with a given steady acting control, without quantisation."""
        if acting == 0:
            return 0.0
        return acting + math.copysign(self.deadband, acting)

    def text(self, unit: str) -> str:
        """Return a clause on the changes to a command, in order; empty if there are none."""
        steps = (
            (self.is_limited, f"changes by at most {self.rate_limit:g} {unit}/s"),
            (self.quantisation, f"is rounded to steps of {self.quantisation:g} {unit}"),
            (self.deadband, f"produces no force within {self.deadband:g} {unit} of 0"),
        )
        active = [step for is_active, step in steps if is_active]
        return f"the command {', '.join(active)}" if active else ""


def estimated_time(
    given: Mapping[str, object], before: tuple[str, Parameter] | None, logged: object
) -> tuple[str, Parameter] | None:
    """Return the name of the drive time to be estimated (``lag`` or ``delay``) and its parameter.

    It is None if neither is to be estimated.

    Parameters
    ----------
    given : mapping
        Lag and delay by name, as numbers or parameters.
    before : (str, Parameter) or None
        Time to be estimated of the drive from which this drive is made by `replace`; None if that
        drive has none. A parameter in `given` takes precedence.
    logged : str
        Point at which the control was recorded, one of `LOGGED`.

    Raises
    ------
    ModelError
        Both times are parameters, or the parameter has a property that the search does not support,
        or the recorded control does not show the time.
    """
    found = {name: p for name, p in given.items() if isinstance(p, Parameter)}
    if len(found) > 1:
        raise ModelError(
            "lag and delay of the drive cannot both be estimated, because a record shows only "
            "their sum: at the frequencies of a motion the lag, the delay and the half sample of "
            "the hold shift the force equally. Give the lag or the delay as a number.",
            code="drive",
        )
    estimated = next(iter(found.items()), before)
    if estimated is None:
        return None
    name, p = estimated
    is_bounded = p.lower not in (0.0, -math.inf) or p.upper != math.inf
    refuse(
        ModelError,
        (
            p.unit != "s" or p.nominal < 0 or p.known is not None or is_bounded,
            f"the drive's {name} is the parameter {p.name!r} of {p.nominal:g} {p.unit}, which "
            "cannot be estimated. Give a parameter in s, with a nominal value of 0 or more, "
            f"without a known value and without a bound except 0. Give a known {name} as a number, "
            f"{name}=...",
        ),
        (
            logged in HIDDEN_FROM[name],
            f"the drive's {name} cannot be estimated, because the control was recorded after the "
            f"{name} (logged={logged!r}). Give the {name} as a number",
        ),
        code="drive",
    )
    return estimated
