"""From a command to what acts: a limited rate, steps, a dead band, and the times of a drive."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from axisid.modeling.quantities import Parameter, number, settle
from axisid.support.errors import ModelError, quoted, refuse

#: Where a recorded control may have been taken, first what it is by default.
LOGGED = ("command", "applied", "current")
#: Times of a drive, and what of `LOGGED` is recorded behind each, where no motion shows it.
HIDDEN_FROM = {"lag": ("current",), "delay": ("applied", "current")}
_AMOUNTS = ("quantisation", "deadband")
_LEAST_STEP = 1e-100  # of which any control is a finite number


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandPath:
    """From the commands of a sampled law to the control that acts, in this order, sample by sample.

    Attributes
    ----------
    rate_limit : float
        Most by which it changes in a second, in the control's unit; infinite for none.
    quantisation : float
        Step to whose multiples it is rounded, halves up; 0 for none.
    deadband : float
        Half width: what is no larger becomes 0, and what is larger is taken by so much towards 0.
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
                f"rate_limit is {given['rate_limit']}; give a positive number, in the control's "
                "unit per second, or leave it out",
            ),
            *(
                (
                    getattr(self, name) < 0,
                    f"{name} is {given[name]}; give a number of 0 or more, in the control's unit",
                )
                for name in _AMOUNTS
            ),
            (
                0 < self.quantisation < _LEAST_STEP,
                f"quantisation is {self.quantisation:g}, below {_LEAST_STEP:g}, which no control "
                "shows; give a step in the control's unit, or 0 for none",
            ),
            before="the drive's ",
            code="drive",
        )

    @property
    def is_plain(self) -> bool:
        """Whether the command acts as it is."""
        return self == CommandPath()

    @property
    def declared(self) -> dict[str, float]:
        """What is declared of it, by name."""
        return {name: x for name, x in asdict(self).items() if x not in (0.0, math.inf)}

    @property
    def is_limited(self) -> bool:
        """Whether it remembers what acted at the sample before."""
        return math.isfinite(self.rate_limit)

    def end(self, command: float) -> float:
        """What acts of a command in the end, when it has stayed the same."""
        if self.quantisation:
            command = math.floor(command / self.quantisation + 0.5) * self.quantisation
        return math.copysign(max(abs(command) - self.deadband, 0.0), command)

    def command(self, acting: float) -> float:
        """A command of which such a control comes, but for the quantisation."""
        return acting + math.copysign(self.deadband, acting) if acting else 0.0

    def text(self, unit: str) -> str:
        """What becomes of a command, in its order; empty where nothing does."""
        steps = (
            (self.is_limited, f"changes by {self.rate_limit:g} {unit}/s at most"),
            (self.quantisation, f"is rounded to steps of {self.quantisation:g} {unit}"),
            (self.deadband, f"makes no force within {self.deadband:g} {unit} of 0"),
        )
        said = [step for is_there, step in steps if is_there]
        return f"the command {', '.join(said)}" if said else ""


def estimated_time(
    given: Mapping[str, object], before: tuple[str, Parameter] | None, logged: object
) -> tuple[str, Parameter] | None:
    """Which time of a drive is estimated, and as what it is declared; None for neither.

    Parameters
    ----------
    given : mapping
        Its lag and its delay, as numbers or parameters.
    before : (str, Parameter) or None
        What was estimated of the drive that this one is made of; a time given anew comes first.
    logged : str

    Raises
    ------
    ModelError
        Both are parameters, or one says what the search for it does not hold, or cannot be seen in
        what was recorded.
    """
    found = {name: p for name, p in given.items() if isinstance(p, Parameter)}
    if len(found) > 1:
        raise ModelError(
            "both lag and delay of the drive are to be estimated, and a record shows their sum "
            "alone: at the frequencies of a motion they, and the half sample of the hold, move the "
            "force alike; give one of them as a number.",
            code="drive",
        )
    one = next(iter(found.items()), before)
    if one is None:
        return None
    name, p = one
    bounded = p.lower not in (0.0, -math.inf) or p.upper != math.inf
    refuse(
        ModelError,
        (
            p.unit != "s" or p.nominal < 0 or p.known is not None or bounded,
            f"the drive's {name} is the parameter {p.name!r} of {p.nominal:g} {p.unit}, which the "
            "search for it does not take; give one in s, with a nominal value of 0 or more, no "
            f"known value and no bound but 0, or what is known as a number, {name}=...",
        ),
        (
            logged in HIDDEN_FROM[name],
            f"the drive's {name} is to be estimated, and the control was recorded behind it "
            f"(logged={logged!r}), so that no motion shows it; give it as a number",
        ),
        code="drive",
    )
    return one
