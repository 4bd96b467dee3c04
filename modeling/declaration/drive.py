"""The drive: what turns a control signal into force."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

import sympy

from axisid.modeling.quantities import (
    CONTROL,
    FORCE,
    POSITION,
    VELOCITY,
    Coordinate,
    Parameter,
    Signal,
    expression,
    multiplied_out,
    number,
    parse_unit,
    rounded,
    settle,
    signals_in,
    with_numbers,
    written,
)
from axisid.support.errors import ModelError, quoted, refuse

from .command_path import (
    HIDDEN_FROM,
    LOGGED,
    CommandPath,
    estimated_time,
)

#: The gain in the force of a drive: a symbol and not its number, whose reciprocal is rounded again.
DRIVE_GAIN = sympy.Symbol("drive_gain", real=True)
#: What the force of a drive with a lag goes to, in generated code.
FORCE_TARGET = "force_target"
_WHOLE = 1e-6  # of a sample: what a delay may be off whole samples by its rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """Response of a drive to commands that are held from sample to sample.

    Attributes
    ----------
    lag : float
        Time constant, s; 0 for none.
    whole : int
        Whole samples of the delay.
    share : float
        What the delay is more, of a sample: from 0 to below 1.
    period : float
        For which a command is held, s.
    steepest : float
        Most by which the control that acts changes from a sample to the next; infinite for none.
    by_motion : bool
        Whether the force depends on the motion. Without a lag it then is the control that is held,
        and the force follows the motion between the samples.
    """

    lag: float
    whole: int
    share: float
    period: float
    steepest: float = math.inf
    by_motion: bool = False

    @property
    def is_held(self) -> bool:
        """Return whether the force stays the same from a sample to the next."""
        return not (self.lag or self.share or self.by_motion)

    @property
    def holds_control(self) -> bool:
        """Return whether a control is held while the force changes with the motion."""
        return self.by_motion and not self.lag

    @property
    def keeps_force(self) -> bool:
        """Return whether the force there is at a sample is among what is remembered."""
        return bool(self.lag) or self.by_motion

    @property
    def late(self) -> int:
        """Samples before the one whose command acts at a sample, without a lag."""
        return self.whole + (self.share > 0)

    @property
    def remembered(self) -> tuple[str, ...]:
        """Return the values that it keeps from sample to sample, by name.

        The control that acted, if its rate is limited, and `forces`.
        """
        return (*("control_before",) * math.isfinite(self.steepest), *self.forces)

    @property
    def forces(self) -> tuple[str, ...]:
        """The forces of the commands before, the newest first, and what has come of them.

        The commands themselves where they are held.
        """
        count = self.whole + (not self.is_held)
        what = "command" if self.holds_control else "force_of_command"
        pending = tuple(f"{what}{i + 1}" for i in range(count))
        return (*pending, "force_now") if self.keeps_force else pending


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A drive: ``tau = gain * control``, the control clipped at `limit`.

    A drive of another force is a class of its own with another `force` and `inverse`, and with a
    `force_by_gain` of its own where its gain is another symbol than `DRIVE_GAIN`.

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
    scaled_by : expression
        What the gain is times, a number of recorded signals and constants: ``supply / 24`` of an
        amplifier without a supply of its own. A sampled law's force keeps that of its last sample.
    lag : float or Parameter
        Time constant of the first-order lag between the command and the force, s, as a current loop
        has: ``lag * dtau/dt = force of the command - tau``. 0 for none. A parameter, in s, without
        bounds and known value, is estimated from the record; until then its nominal value stands.
    delay : float or Parameter
        Time from the command to when it acts, before the lag, s: of a bus, of the drive's own
        cycle. It need not be whole samples; 0 for none. Estimated as a lag is, but one of them.
    logged : str
        Where on this way the recorded control was taken: ``command``, what the law gives;
        ``applied``, what acts after the delay, or ``current``, what is there after the lag. The
        last two lie behind rate limit, quantisation and dead band, too.
    rate_limit : float
        Most by which the control that acts changes in a second, in `unit` per second: at each
        sample by so much times the law's period, towards the command. Infinite for none.
    quantisation : float
        Step of the control, in `unit`, as a converter or a pulse width has: it is rounded to the
        nearest multiple, halves up. 0 for none.
    deadband : float
        Half width, in `unit`: a control that is no larger makes no force, and of a larger one the
        force is that of the control less the dead band, as of a valve with overlap. 0 for none.
    estimated : (str, Parameter) or None
        Which time is estimated, ``lag`` or ``delay``, and as what it was declared; follows from
        what is given for them.

    Notes
    -----
    A command passes the limit, the rate limit, the quantisation, the dead band, the delay, the gain
    and the lag, in this order; all but the lag act sample by sample, so that the delay could stand
    before the others as well. The limit is the command's. All are those of a sampled law's held
    commands: what the force is between two samples is then known exactly, from exponentials.

    References
    ----------
    Equation (5) of [Brunot2015]_.
    """

    gain: float
    unit: str = "V"
    limit: float = math.inf
    relative_sd: float = 0.0
    profile: sympy.Expr = sympy.S.One
    scaled_by: sympy.Expr = sympy.S.One
    # Read they are numbers, whatever they were given as.
    lag: float | Any = 0.0
    delay: float | Any = 0.0
    logged: str = LOGGED[0]
    rate_limit: float = math.inf
    quantisation: float = 0.0
    deadband: float = 0.0
    estimated: tuple[str, Parameter] | None = None

    def __post_init__(self) -> None:
        given = {name: getattr(self, name) for name in HIDDEN_FROM}
        found = estimated_time(given, self.estimated, self.logged)
        if found is not None:  # a parameter's nominal value stands in its place
            name, parameter = found
            changed = {name: parameter.nominal} if isinstance(given[name], Parameter) else {}
            settle(self, estimated=found, **changed)
        parse_unit(self.unit)
        path = self.path
        settle(
            self,
            gain=number(self.gain, "the drive gain"),
            limit=number(self.limit, "the drive limit", finite=False),
            relative_sd=number(self.relative_sd, "the drive gain's relative deviation"),
            profile=expression(self.profile, "the drive's profile"),
            scaled_by=expression(self.scaled_by, "the drive's scaled_by"),
            lag=number(self.lag, "the drive's lag"),
            delay=number(self.delay, "the drive's delay"),
            **asdict(path),
        )
        missing = signals_in(self.scaled_by) - signals_in(self.force)
        hides = "quantisation" if self.quantisation > self.limit else "deadband"
        refuse(
            ModelError,
            (
                self.gain == 0,
                f"the drive gain is {self.gain!r}. Give a finite number other than 0",
                "model",
            ),
            (
                not 0 <= self.relative_sd < 1,
                f"the relative standard deviation of the drive gain is {self.relative_sd!r}. Give "
                "a fraction from 0 to below 1, such as 0.005 for 0.5 %",
            ),
            (
                missing,
                f"the drive {type(self).__name__} defines its own force, which does not contain "
                f"scaled_by ({self.scaled_by}). Write {', '.join(map(str, missing))} into its "
                "force and inverse",
            ),
            (
                not self.limit > 0,
                f"the drive limit is {self.limit!r}. Give a positive number",
                "model",
            ),
            *(
                (
                    getattr(self, name) < 0,
                    f"the drive's {name} is {getattr(self, name)!r} s. Give a time of 0 or more, "
                    "because a force follows its command",
                )
                for name in HIDDEN_FROM
            ),
            (
                math.isfinite(self.limit) and not path.end(self.limit) > 0,
                f"the drive's {hides} is {getattr(path, hides):g} and its limit {self.limit:g}, so "
                f"no command produces a force. Give a {hides} below the limit, both in the "
                "control's unit",
            ),
            (
                self.logged not in LOGGED,
                f"logged is {quoted(self.logged)}. Give the point at which the control was "
                f"recorded: {', '.join(LOGGED[:-1])} or {LOGGED[-1]}",
            ),
            (
                self.logged == "applied" and not self.delay and path.is_plain,
                "logged='applied' is the control after the drive's delay, rate limit, quantisation "
                "and dead band, but none of them is declared. Declare delay=... or another of "
                "them, or declare logged='command'",
            ),
            (
                self.logged == "current" and not self.lag,
                "logged='current' is the control after the drive's lag, but no lag is declared. "
                "Declare lag=..., or logged='command'",
            ),
            code="drive",
        )

    @property
    def force(self) -> sympy.Expr:
        """Force by the control, `CONTROL`, and by the constants of the drive."""
        return DRIVE_GAIN * CONTROL * with_numbers(self.scaled_by)

    @property
    def force_by_gain(self) -> sympy.Expr:
        """Slope of `force` by the logarithm of the gain, by the same symbols."""
        return DRIVE_GAIN * self.force.diff(DRIVE_GAIN)

    @property
    def is_gain(self) -> bool:
        """Return whether the force is the gain times the control, and nothing else."""
        return bool(self.force == DRIVE_GAIN * CONTROL)

    @property
    def is_times_gain(self) -> bool:
        """Return whether the force is the gain times what the gain has no part in."""
        off = (self.force_by_gain - self.force).replace(sympy.Abs, lambda x: x * sympy.sign(x))
        return bool(multiplied_out(off) == 0)

    @property
    def inverse(self) -> sympy.Expr:
        """Control by the force, `FORCE`, whatever the limit, and by the constants of the drive."""
        return FORCE / (DRIVE_GAIN * with_numbers(self.scaled_by))

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """Value of each symbol in `force` and `inverse` that is no signal."""
        return {DRIVE_GAIN: self.gain}

    def with_time(self, name: str, value: float) -> "Drive":
        """The same with a number, s, for its lag or its delay, which is no longer estimated."""
        changed: dict[str, Any] = {name: value, "estimated": None}
        return replace(self, **changed)

    def estimating(self, name: str) -> "Drive":
        """The same with its lag or its delay to be estimated, from where it is declared."""
        changed: dict[str, Any] = {
            name: Parameter(name, "s", nominal=float(getattr(self, name)), lower=0.0)
        }
        if self.estimated is not None:  # as it was declared, and beside another one refused
            changed |= dict([self.estimated])
        return replace(self, **changed)

    @property
    def path(self) -> CommandPath:
        """From a command within the limit to the control that acts, sample by sample."""
        return CommandPath(
            rate_limit=self.rate_limit, quantisation=self.quantisation, deadband=self.deadband
        )

    @property
    def of_held_commands(self) -> tuple[str, ...]:
        """What is declared of it that is that of commands held from sample to sample, by name."""
        estimated = "" if self.estimated is None else self.estimated[0]
        timing = (n for n in ("lag", "delay") if getattr(self, n) or n == estimated)
        return (*timing, *self.path.declared)

    @property
    def logs_what_acts(self) -> bool:
        """Return whether the control is recorded after rate limit, quantisation and dead band."""
        return self.logged != LOGGED[0]

    def behind_path(self) -> Self:
        """The drive of the controls that act, from where they act, or from where they are logged.

        Of a control that is recorded behind the delay, or the lag, that is no more to come.
        """
        lag = 0.0 if self.logged == "current" else self.lag
        delay = 0.0 if self.logs_what_acts else self.delay
        plain: dict[str, Any] = asdict(CommandPath())
        return replace(self, lag=lag, delay=delay, logged=LOGGED[0], **plain)

    def response(self, period: float, *, by_motion: bool = False) -> Response:
        """From commands that are held for a period, s, to the force."""
        samples = self.delay / period
        whole = math.floor(samples + _WHOLE)
        share = samples - whole
        return Response(
            lag=self.lag,
            whole=whole,
            share=share if share > _WHOLE else 0.0,
            period=period,
            steepest=self.rate_limit * period,
            by_motion=by_motion,
        )

    def along(self, coordinate: Coordinate) -> dict[sympy.Symbol, sympy.Symbol]:
        """What position and velocity of its expressions are on an axis."""
        return {POSITION: coordinate.symbol, VELOCITY: coordinate.velocity}

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse an axis that the drive's figures or formulas do not fit; a gain fits any."""

    @property
    def remark(self) -> str:
        """What of the motor is not in the force, to be told with a result; empty for nothing."""
        return ""

    @property
    def timing_text(self) -> str:
        """How and when a command acts, and where the control is recorded; empty for at once."""
        if not self.of_held_commands:
            return ""
        path = self.path.text(self.unit)
        said = {name: f"{getattr(self, name):g} s" for name in HIDDEN_FROM if getattr(self, name)}
        if self.estimated is not None:
            name, parameter = self.estimated
            said[name] = f"{parameter.nominal:g} s (where the search for {parameter.name} starts)"
        delay = f"{said['delay']} after its command" if "delay" in said else ""
        lag = f"with a lag of {said['lag']}" if "lag" in said else ""
        where = {
            "command": "the recorded control is the command",
            "applied": "the recorded control is applied" + " after the delay" * bool(self.delay),
            "current": "the recorded control is taken after the lag",
        }[self.logged]
        when = f"the force acts {' '.join(filter(None, (delay, lag)))}" if delay or lag else ""
        return "; ".join(filter(None, (path, when, where)))

    def gain_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """The gain with its unit: ``35.15 N/V``."""
        over = self.unit if self.unit.isalpha() else f"({self.unit})"
        return f"{self.gain:.{digits}g} {coordinate.force_unit}/{over}"

    def force_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """What the force is: ``35.15 N/V times the control``, else a formula and its constants."""
        if self.is_gain:
            return f"{self.gain_text(coordinate, digits)} times the control"
        constants = "".join(f", {s} = {x:.{digits}g}" for s, x in self.constants.items())
        formula = written(rounded(self.force.xreplace(self.along(coordinate))), coordinate)
        return f"{formula} in {coordinate.force_unit}, the control in {self.unit}{constants}"
