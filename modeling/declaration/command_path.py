"""What a drive makes of a command before it acts: a limited rate, steps, a dead band."""

import math
from dataclasses import asdict, dataclass

from axisid.modeling.quantities import number
from axisid.support.errors import ModelError
from axisid.support.user_values import quoted


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
        said = []
        if self.is_limited:
            said.append(f"changes by {self.rate_limit:g} {unit}/s at most")
        if self.quantisation:
            said.append(f"is rounded to steps of {self.quantisation:g} {unit}")
        if self.deadband:
            said.append(f"makes no force within {self.deadband:g} {unit} of 0")
        return f"the command {', '.join(said)}" if said else ""


def command_path(rate_limit: object, quantisation: object, deadband: object) -> CommandPath:
    """Check what is declared of the way of a command.

    Raises
    ------
    ModelError
        A value is no number, is negative, or lets no command through.
    """
    rate = number(rate_limit, "the drive's rate_limit", finite=False)
    if not rate > 0:
        raise ModelError(
            f"the drive's rate_limit is {quoted(rate_limit)}; give a positive number, in the "
            "control's unit per second, or leave it out.",
            code="drive-rate",
        )
    step = number(quantisation, "the drive's quantisation")
    band = number(deadband, "the drive's deadband")
    for value, what in ((step, "quantisation"), (band, "deadband")):
        if value < 0:
            raise ModelError(
                f"the drive's {what} is {quoted(value)}; give a number of 0 or more, in the "
                "control's unit.",
                code="drive-band",
            )
    return CommandPath(rate_limit=rate, quantisation=step, deadband=band)


def check_within(path: CommandPath, limit: float) -> None:
    """Refuse a way through which no command within the limit comes.

    Raises
    ------
    ModelError
        No command within the limit makes a force.
    """
    if math.isinf(limit) or path.end(limit) > 0:
        return
    what = "quantisation" if path.quantisation > limit else "deadband"
    raise ModelError(
        f"the drive's {what} is {getattr(path, what):g} and its limit {limit:g}, so that no "
        f"command makes a force; give a {what} below the limit, both in the control's unit.",
        code="drive-band-and-limit",
    )
