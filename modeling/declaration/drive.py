"""The drive, which turns a control signal into force."""

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
from axisid.support.checks import refuse
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

from .command_path import (
    HIDDEN_FROM,
    LOGGED,
    CommandPath,
    estimated_time,
)

#: Symbol of the gain in the force of a drive, in place of its number, whose reciprocal is rounded.
DRIVE_GAIN = sympy.Symbol("drive_gain", real=True)
#: Force towards which the force of a drive with a lag moves, in generated code.
FORCE_TARGET = "force_target"
_WHOLE = 1e-6  # of a sample: difference of a delay from whole samples that counts as rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """Response of a drive's force to commands that are held from sample to sample.

    Attributes
    ----------
    lag : float
        Time constant, s; 0 for none.
    whole : int
        Whole samples of the delay.
    share : float
        Remaining fraction of a sample in the delay: from 0 to below 1.
    period : float
        Time for which a command is held, s.
    steepest : float
        Largest change of the acting control from one sample to the next; infinite for none.
    by_motion : bool
        Whether the force depends on the motion. Without a lag the control is then held, and the
        force follows the motion between the samples.
    """

    lag: float
    whole: int
    share: float
    period: float
    steepest: float = math.inf
    by_motion: bool = False

    @property
    def is_held(self) -> bool:
        """Return whether the force is constant between samples."""
        return not (self.lag or self.share or self.by_motion)

    @property
    def holds_control(self) -> bool:
        """Return whether the control is held while the force changes with the motion."""
        return self.by_motion and not self.lag

    @property
    def keeps_force(self) -> bool:
        """Return whether the force that acts now is the last entry of `forces`.

        True with a lag, or if the force depends on the motion.
        """
        return bool(self.lag) or self.by_motion

    @property
    def late(self) -> int:
        """Return the number of samples after which a command acts throughout, ignoring a lag.

        A fraction of a sample counts as a whole one.
        """
        return self.whole + (self.share > 0)

    @property
    def remembered(self) -> tuple[str, ...]:
        """Return the names of the values that the drive stores from one sample to the next.

        These are the control that acted last, if its rate is limited, and `forces`.
        """
        return (*("control_before",) * math.isfinite(self.steepest), *self.forces)

    @property
    def forces(self) -> tuple[str, ...]:
        """Return the names of the forces in the drive's state from sample to sample.

        First come the forces of the last commands, those that wait or still act, the newest first.
        If the control is held while the force depends on the motion, these are the commands
        themselves. The force that acts now comes last, if it is stored (see `keeps_force`).
        """
        count = self.whole + (not self.is_held)
        what = "command" if self.holds_control else "force_of_command"
        pending = tuple(f"{what}{i + 1}" for i in range(count))
        return (*pending, "force_now") if self.keeps_force else pending


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A drive: ``tau = gain * control``, the control clipped at `limit`.

    A drive with another force is a separate class with its own `force` and `inverse`, and with its
    own `force_by_gain` if its gain is another symbol than `DRIVE_GAIN`.

    Attributes
    ----------
    gain : float
        Force per control, in the coordinate's force unit over `unit` (N/V).
    unit : str
        Unit of the control signal.
    limit : float
        Largest absolute control, in `unit`; infinite for none.
    relative_sd : float
        Standard deviation of the gain divided by the gain, 0.005 for 0.5 %. Its contribution to the
        estimates is shown separately from their statistical uncertainty.
    profile : expression
        The force at a position divided by its nominal value `tau`, from the coordinate and
        constants: a motor whose force constant depends on the position. It divides the force
        balance, so that `tau`, and a force column of a record, are nominal; the inertia that `tau`
        sees then depends on the position, and there is no direct regressor.
    scaled_by : expression
        Factor of the gain, from recorded signals and constants: ``supply / 24`` for an amplifier
        without its own regulated supply. The force of a sampled law keeps the factor of its last
        sample.
    lag : float or Parameter
        Time constant of the first-order lag between the command and the force, s, as a current loop
        has: ``lag * dtau/dt = force of the command - tau``. 0 for none. A parameter, in s, without
        bounds and known value, is estimated from the record; until then its nominal value is used.
    delay : float or Parameter
        Time from the command to when it acts, before the lag, s, such as that of a bus or of the
        drive's cycle. It need not be whole samples; 0 for none. It can be estimated like a lag, but
        only one of the two.
    logged : str
        Point at which the recorded control was taken: ``command``, the output of the law;
        ``applied``, the control after the delay, or ``current``, the control after the lag. The
        last two are after rate limit, quantisation and dead band, too.
    rate_limit : float
        Largest change of the acting control, in `unit` per second: at each sample it moves towards
        the command by at most this times the law's period. Infinite for none.
    quantisation : float
        Step of the control, in `unit`, as of a converter or a pulse width: the control is rounded
        to the nearest multiple, halves up. 0 for none.
    deadband : float
        Half width, in `unit`: a control that is not larger makes no force, and the force of a
        larger one is that of the control minus the dead band, as in a valve with overlap. 0 for
        none.
    estimated : (str, Parameter) or None
        Time that is estimated, ``lag`` or ``delay``, and its declared parameter; follows from the
        values of the two.

    Notes
    -----
    A command passes the limit, the rate limit, the quantisation, the dead band, the delay, the gain
    and the lag, in this order; all except the lag act sample by sample, so that the delay could
    also come before the others. The limit is that of the command. All apply to the held commands of
    a sampled law: the force between two samples is then known exactly, from exponentials.

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
    # When read they are numbers, whatever type they were given as.
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
        if found is not None:  # the nominal value of a parameter is used for it
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
        """Return the derivative of `force` with respect to the logarithm of the gain."""
        return DRIVE_GAIN * self.force.diff(DRIVE_GAIN)

    @property
    def is_gain(self) -> bool:
        """Return whether the force is exactly the gain times the control."""
        return bool(self.force == DRIVE_GAIN * CONTROL)

    @property
    def is_times_gain(self) -> bool:
        """Return whether the force is proportional to the gain."""
        off = (self.force_by_gain - self.force).replace(sympy.Abs, lambda x: x * sympy.sign(x))
        return bool(multiplied_out(off) == 0)

    @property
    def inverse(self) -> sympy.Expr:
        """Return the control as a function of the force, `FORCE`, ignoring the limit."""
        return FORCE / (DRIVE_GAIN * with_numbers(self.scaled_by))

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """Return the value of each symbol of `force` and `inverse` that is a known constant."""
        return {DRIVE_GAIN: self.gain}

    def with_time(self, name: str, value: float) -> "Drive":
        """Return the drive with a given lag or delay, s, which is then no longer estimated.

        Parameters
        ----------
        name : str
            ``lag`` or ``delay``.
        value : float
        """
        changed: dict[str, Any] = {name: value, "estimated": None}
        return replace(self, **changed)

    def estimating(self, name: str) -> "Drive":
        """Return the drive with its lag or delay as a parameter to be estimated.

        The search starts at the declared value.

        Parameters
        ----------
        name : str
            ``lag`` or ``delay``.

        Raises
        ------
        ModelError
            The other time is estimated already.
        """
        changed: dict[str, Any] = {
            name: Parameter(name, "s", nominal=float(getattr(self, name)), lower=0.0)
        }
        if self.estimated is not None:  # as declared; a second one is refused
            changed |= dict([self.estimated])
        return replace(self, **changed)

    @property
    def path(self) -> CommandPath:
        """Return the path from a command within the limit to the acting control."""
        return CommandPath(
            rate_limit=self.rate_limit, quantisation=self.quantisation, deadband=self.deadband
        )

    @property
    def of_held_commands(self) -> tuple[str, ...]:
        """Return the names of declared properties that apply only to held commands.

        These are the lag, the delay, the rate limit, the quantisation and the dead band.
        """
        estimated = "" if self.estimated is None else self.estimated[0]
        timing = (n for n in ("lag", "delay") if getattr(self, n) or n == estimated)
        return (*timing, *self.path.declared)

    @property
    def logs_what_acts(self) -> bool:
        """Return whether the control was recorded after rate limit, quantisation and dead band."""
        return self.logged != LOGGED[0]

    def behind_path(self) -> Self:
        """Return the part of the drive behind the recorded control.

        Rate limit, quantisation and dead band are left out. A delay or a lag that lies before the
        point at which the control was recorded is set to 0, so that it is not applied twice.
        """
        lag = 0.0 if self.logged == "current" else self.lag
        delay = 0.0 if self.logs_what_acts else self.delay
        plain: dict[str, Any] = asdict(CommandPath())
        return replace(self, lag=lag, delay=delay, logged=LOGGED[0], **plain)

    def response(self, period: float, *, by_motion: bool = False) -> Response:
        """Return the response of the force to held commands.

        Parameters
        ----------
        period : float
            Time for which a command is held, s.
        by_motion : bool
            Whether the force depends on the motion.
        """
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
        """Return the coordinate's symbols for `POSITION` and `VELOCITY` in the drive's formulas."""
        return {POSITION: coordinate.symbol, VELOCITY: coordinate.velocity}

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse an axis that the drive does not fit. A plain gain fits every axis.

        A subclass checks its figures or formulas here.
        """

    @property
    def remark(self) -> str:
        """Return a note for results on a motor property that the force omits.

        Empty, unless a subclass has such a property.
        """
        return ""

    @property
    def timing_text(self) -> str:
        """Return text on what happens to a command before it acts, and on the recorded control.

        Empty if a command acts at once and unchanged.
        """
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
        """Return the gain with its unit as text: ``35.15 N/V``."""
        over = self.unit if self.unit.isalpha() else f"({self.unit})"
        return f"{self.gain:.{digits}g} {coordinate.force_unit}/{over}"

    def force_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """Return the force as text: ``35.15 N/V times the control``, or a formula."""
        if self.is_gain:
            return f"{self.gain_text(coordinate, digits)} times the control"
        constants = "".join(f", {s} = {x:.{digits}g}" for s, x in self.constants.items())
        formula = written(rounded(self.force.xreplace(self.along(coordinate))), coordinate)
        return f"{formula} in {coordinate.force_unit}, the control in {self.unit}{constants}"
