"""The drive, which converts a control signal to force."""

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

#: Symbol of the gain in the force of a drive. The number would be rounded in its reciprocal.
DRIVE_GAIN = sympy.Symbol("drive_gain", real=True)
#: Force towards which the force of a drive with a lag moves, in generated code.
FORCE_TARGET = "force_target"
_WHOLE = 1e-6  # samples: difference of a delay from whole samples that counts as rounding


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
        Remaining fraction of a sample of the delay, from 0 to below 1.
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
        """Return the number of samples after which a command acts for a whole sample.

        It is the delay in samples, rounded up. A lag is ignored.
        """
        return self.whole + (self.share > 0)

    @property
    def remembered(self) -> tuple[str, ...]:
        """Return the names of the values that the drive stores from one sample to the next.

        These are the control that acted last, if its rate is limited, and `forces`.
        """
        if math.isfinite(self.steepest):
            return ("control_before", *self.forces)
        return self.forces

    @property
    def forces(self) -> tuple[str, ...]:
        """Return the names of the forces in the drive's state from sample to sample.

        First come the forces of the last commands that do not act yet or still act, the newest
        first. If the control is held while the force depends on the motion, these are the commands
        themselves. Last comes the force that acts now, if it is stored (see `keeps_force`).
        """
        count = self.whole + (not self.is_held)
        what = "command" if self.holds_control else "force_of_command"
        pending = tuple(f"{what}{i + 1}" for i in range(count))
        return (*pending, "force_now") if self.keeps_force else pending


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A drive: ``tau = gain * control``, with the control clipped at `limit`.

    A drive with another force is a subclass that overrides `force` and `inverse`, and also
    `force_by_gain` if its gain is another symbol than `DRIVE_GAIN`.

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
        The force at a position divided by its nominal value `tau`, a function of the coordinate and
        constants, for a motor whose force constant depends on the position. `tau`, and a force
        column of a record, are nominal. The force balance is divided by the profile; the inertia
        relative to `tau` then depends on the position, and there is no direct regressor.
    scaled_by : expression
        Factor of the gain, a function of recorded signals and constants: ``supply / 24`` for an
        amplifier without a regulated supply. With a sampled law, the factor is held from sample to
        sample.
    lag : float or Parameter
        Time constant of the first-order lag between the command and the force, s, such as of a
        current loop: ``lag * dtau/dt = force of the command - tau``. 0 for none. A parameter, in s,
        without bounds and known value, is estimated from the record; until then its nominal value
        is used.
    delay : float or Parameter
        Dead time from the command until it acts, before the lag, s, such as of a bus or of the
        drive's cycle; not necessarily whole samples. 0 for none. Either the lag or the delay can be
        estimated.
    logged : str
        Point at which the control was recorded: ``command``, the output of the law; ``applied``,
        the control after the delay; or ``current``, the control after the lag. The last two are
        also after rate limit, quantisation and dead band.
    rate_limit : float
        Largest rate of change of the acting control, in `unit` per second: at each sample the
        acting control moves towards the command by at most this rate times the law's period.
        Infinite for none.
    quantisation : float
        Step of the control, in `unit`, such as of a converter or a pulse width: the control is
        rounded to the nearest multiple, halves up. 0 for none.
    deadband : float
        Half width of the dead band, in `unit`: a control up to this size produces no force. A
        larger control is reduced by the dead band, as in a valve with overlap. 0 for none.
    estimated : (str, Parameter) or None
        Name of the time to be estimated, ``lag`` or ``delay``, and its parameter; None if neither
        is estimated. It follows from the values of `lag` and `delay`: do not give it.

    Notes
    -----
    A command passes the limit, the rate limit, the quantisation, the dead band, the delay, the gain
    and the lag, in this order. All except the lag act sample by sample, so the position of the
    delay among them does not matter. All apply to the held commands of a sampled law: the force
    between two samples is then known exactly, from exponentials.

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
    # Given as numbers or parameters, stored as numbers.
    lag: float | Any = 0.0
    delay: float | Any = 0.0
    logged: str = LOGGED[0]
    rate_limit: float = math.inf
    quantisation: float = 0.0
    deadband: float = 0.0
    estimated: tuple[str, Parameter] | None = None

    def __post_init__(self) -> None:
        # Store a time to be estimated, and its nominal value in place of a parameter.
        given = {name: getattr(self, name) for name in HIDDEN_FROM}
        found = estimated_time(given, self.estimated, self.logged)
        if found is not None:
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
        too_large = "quantisation" if self.quantisation > self.limit else "deadband"
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
                f"the drive's {too_large} is {getattr(path, too_large):g} and its limit is "
                f"{self.limit:g}, so no command produces a force. Give a {too_large} below the "
                "limit, both in the control's unit",
            ),
            (
                self.logged not in LOGGED,
                f"logged is {quoted(self.logged)}. Give the point at which the control was "
                f"recorded: {', '.join(LOGGED[:-1])} or {LOGGED[-1]}",
            ),
            (
                self.logged == "applied" and not self.delay and path.is_plain,
                "logged='applied' is the control after the drive's delay, rate limit, quantisation "
                "and dead band, but the drive declares none of these. Declare delay=..., "
                "rate_limit=..., quantisation=... or deadband=..., or declare logged='command'",
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
        """Force as a function of the control: ``gain * control * scaled_by``.

        `scaled_by` is the declared factor of the gain, a function of recorded signals. The gain is
        the symbol `DRIVE_GAIN`, and the control the symbol `CONTROL`. A subclass may have further
        symbols of known constants. `constants` has the values of `DRIVE_GAIN` and of these symbols.
        """
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
        """Return whether the force is proportional to the gain.

        The force F is proportional to the gain g if it equals `force_by_gain`, which is
        ``g dF/dg``, the derivative of the force with respect to the logarithm of the gain.
        """
        difference = self.force_by_gain - self.force
        # SymPy's derivative of Abs(x) contains sign(x), but the force contains Abs(x). Equal terms
        # cancel only if both are written with sign(x).
        difference = difference.replace(sympy.Abs, lambda x: x * sympy.sign(x))
        return bool(multiplied_out(difference) == 0)

    @property
    def inverse(self) -> sympy.Expr:
        """Return the control as a function of the force, `FORCE`, ignoring the limit."""
        return FORCE / (DRIVE_GAIN * with_numbers(self.scaled_by))

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """Return the value of each symbol of `force` and `inverse` that is a known constant."""
        return {DRIVE_GAIN: self.gain}

    def with_time(self, name: str, value: float) -> "Drive":
        """Return the drive with a given lag or delay, in which no time is to be estimated.

        Parameters
        ----------
        name : str
            ``lag`` or ``delay``.
        value : float
            The time, s.
        """
        changed: dict[str, Any] = {name: value, "estimated": None}
        return replace(self, **changed)

    def estimating(self, name: str) -> "Drive":
        """Return the drive with its lag or delay as a parameter to be estimated.

        The nominal value, from which the search starts, is the declared value.

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
        if self.estimated is not None:  # a declared parameter takes precedence
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
        """Return whether the recorded control is not the command, but the acting control."""
        return self.logged != LOGGED[0]

    def behind_path(self) -> Self:
        """Return the part of the drive after the point at which the control was recorded.

        Rate limit, quantisation and dead band are omitted. A delay or a lag before this point is
        set to 0, so that it is not applied twice.
        """
        lag = 0.0 if self.logged == "current" else self.lag
        delay = 0.0 if self.logs_what_acts else self.delay
        unchanged: dict[str, Any] = asdict(CommandPath())
        return replace(self, lag=lag, delay=delay, logged=LOGGED[0], **unchanged)

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
        """Return the coordinate's symbols by the drive's symbols `POSITION` and `VELOCITY`."""
        return {POSITION: coordinate.symbol, VELOCITY: coordinate.velocity}

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse an axis that the drive does not fit.

        A plain gain fits every axis. A subclass checks its figures or formulas.

        Parameters
        ----------
        coordinate : Coordinate
            Coordinate of the axis.
        signals : iterable of Signal
            Recorded signals of the axis.
        """

    @property
    def remark(self) -> str:
        """Return a note for results on a property of the motor that the force does not contain.

        The note is empty, unless a subclass has such a property.
        """
        return ""

    @property
    def timing_text(self) -> str:
        """Return clauses on the changes to a command, on its timing, and on the recorded control.

        The text is empty if a command acts at once and unchanged.
        """
        if not self.of_held_commands:
            return ""
        path = self.path.text(self.unit)
        times = {name: f"{getattr(self, name):g} s" for name in HIDDEN_FROM if getattr(self, name)}
        if self.estimated is not None:
            name, parameter = self.estimated
            times[name] = f"{parameter.nominal:g} s (start of the search for {parameter.name})"
        timing = []
        if "delay" in times:
            timing.append(f"{times['delay']} after its command")
        if "lag" in times:
            timing.append(f"with a lag of {times['lag']}")
        when = f"the force acts {' '.join(timing)}" if timing else ""
        where = {
            "command": "the recorded control is the command",
            "applied": "the control was recorded as applied",
            "current": "the control was recorded after the lag",
        }[self.logged]
        if self.logged == "applied" and self.delay:
            where = "the control was recorded after the delay"
        return "; ".join(filter(None, (path, when, where)))

    def gain_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """Return the gain with its unit as text: ``35.15 N/V``."""
        divisor = self.unit if self.unit.isalpha() else f"({self.unit})"
        return f"{self.gain:.{digits}g} {coordinate.force_unit}/{divisor}"

    def force_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """Return the force as text: ``35.15 N/V times the control``, or a formula with units."""
        if self.is_gain:
            return f"{self.gain_text(coordinate, digits)} times the control"
        constants = "".join(f", {s} = {x:.{digits}g}" for s, x in self.constants.items())
        formula = written(rounded(self.force.xreplace(self.along(coordinate))), coordinate)
        return f"{formula} in {coordinate.force_unit}, the control in {self.unit}{constants}"
