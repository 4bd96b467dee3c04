"""The declared axis: the user's declaration, checked once."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import UnionType
from typing import Any

import sympy

from axisid.modeling.quantities import (
    DIRECTION,
    FORCE,
    NUMBER,
    ConstantSymbol,
    Coordinate,
    Formula,
    Parameter,
    Signal,
    SignalSymbol,
    State,
    StateSymbol,
    check_distinct,
    check_name,
    check_size,
    listed,
    settle,
    signals_in,
    states_in,
    with_numbers,
)
from axisid.support.checks import refuse
from axisid.support.errors import ModelError, UsageError
from axisid.support.mappings import FrozenMapping
from axisid.support.presentable import view_of
from axisid.support.wording import quoted

from .column import column_texts
from .control import LONGEST_DELAY, ControlLaw
from .drive import FORCE_TARGET, Drive, Response
from .experiment import Experiment
from .unit_check import check_states, check_unit, checked_terms, unit_table

#: Roles of the columns of a record: the quantities that a column can contain.
ROLES = (
    "time",
    "position",
    "velocity",
    "acceleration",
    "reference",
    "control",
    "force",
    "injected",
)
#: Signals to which a recorded test signal, the role ``injected``, can be added.
INJECTION_POINTS = ("control", "reference")


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Axis:
    """A one-degree-of-freedom axis as declared; made by `newton` or `lagrange`.

    Attributes
    ----------
    name : str
        Name in messages, and of the folder of the generated code.
    coordinate : Coordinate
        The degree of freedom.
    parameters : tuple of Parameter
        Parameters to identify, in the order of every vector and table.
    force : sympy.Expr
        Inverse dynamics: the force that the motion needs, from position, velocity, acceleration
        and the parameters, each term in newtons (or newton metres).
    drive : Drive
        Drive, from control to force.
    control : ControlLaw or None
        The control law that closes the loop; instrumental variables need it. None if it is unknown.
    columns : mapping of str to str or Column
        Columns of this axis's logs by role (see `ROLES`) or by signal name: a name, with a unit or
        a scaling if the column is not in SI, as ``--columns`` takes it. A `Column` is stored as
        text.
    injected_at : str
        Signal to which the test signal in the column ``injected`` is added: ``control``, before the
        drive's limit, or ``reference``. Empty if there is no test signal, or if each record states
        the point itself.
    signals : tuple of Signal
        Signals recorded in addition to the motion; the force, the drive and the control law may
        depend on them.
    experiment : Experiment or None
        Experiment of the axis's synthetic twin; None without one.
    title : str
        One line for tables.
    left_out : tuple of Parameter
        Parameters that are not identified, each with the `known` value that replaces it in the
        force; see `leave_out`.
    """

    name: str
    coordinate: Coordinate
    parameters: tuple[Parameter, ...]
    force: sympy.Expr
    drive: Drive
    control: ControlLaw | None = None
    columns: Mapping[str, Any] = field(default_factory=dict)
    experiment: Experiment | None = None
    title: str = ""
    left_out: tuple[Parameter, ...] = ()
    injected_at: str = ""
    signals: tuple[Signal, ...] = ()

    def __post_init__(self) -> None:
        check_name(self.name, "the axis")
        self._check_types()
        self._check_response()  # first: it bounds the number of commands that the drive stores
        settle(self, columns=FrozenMapping(column_texts(self.columns)))
        check_distinct(self._names)
        self._check_signals()
        self._check_symbols()
        self._check_columns()
        self._check_truth()
        self._check_units()
        self.drive.check_on(self.coordinate, self.signals)

    def __repr__(self) -> str:
        """Return name and parameters in one line."""
        return f"axis {self.name}: {', '.join(p.name for p in self.parameters)}"

    def __str__(self) -> str:
        """Return name, title and equation of motion."""
        title = f": {self.title}" if self.title else ""
        return f"{self.name}{title}\n{equation_of_motion(self).text(self.coordinate)}"

    def _repr_html_(self) -> str:
        """Return HTML for notebooks: the equation of motion and the derived models."""
        return str(view_of("axis_html", self))

    @property
    def roles(self) -> tuple[str, ...]:
        """Return the roles of the columns of its records, including the names of its signals."""
        return (*ROLES, *(signal.name for signal in self.signals))

    @property
    def signal_symbols(self) -> tuple[sympy.Symbol, ...]:
        """Return the symbols of the recorded signals, as expressions use them."""
        return tuple(signal.symbol for signal in self.signals)

    @property
    def taken_names(self) -> set[str]:
        """Return the names in use, in lower case; a further parameter must have another name."""
        return {name.lower() for name, _ in self._names}

    @property
    def _names(self) -> list[tuple[str, str]]:
        """Return each name in use on the axis, with a description of its owner for messages."""
        q, law, response = self.coordinate, self.control, self.response
        estimated = () if self.drive.estimated is None else (self.drive.estimated,)
        owned: dict[str, Iterable[str]] = {
            "the coordinate": map(str, (q.symbol, q.velocity, q.acceleration)),
            "parameter": (p.name for p in self.parameters),
            **{f"the drive's {time}": (parameter.name,) for time, parameter in estimated},
            "the control law's symbol": law.names if law else (),
            "signal": (signal.name for signal in self.signals),
            "the rate of a signal": (signal.rate_name for signal in self.signals),
            "the program's name for the signals": ("signals",) if self.signals else (),
            "state": (state.name for state in self.states),
            "the program's name for a force of the drive": (*response.remembered, FORCE_TARGET)
            if response
            else (),
        }
        return [(name, what) for what, names in owned.items() for name in names]

    @property
    def states(self) -> tuple[State, ...]:
        """Return the internal states of its friction, sorted by name."""
        return states_in(self.force)

    @property
    def unchecked_terms(self) -> tuple[str, ...]:
        """Return the terms of the equation of motion whose unit could not be checked, as text.

        The unit of such a term is correct only if a plain number in the term stands for a quantity
        with a unit.
        """
        return checked_terms(
            self.force, self.coordinate, self.parameters, (*self.signals, *self.states)
        )

    @property
    def response(self) -> Response | None:
        """Return the response of the drive to the held commands of a sampled law.

        It is None without a sampled law, and if the force follows each command at once.
        """
        law = self.control
        if law is None or law.continuous:
            return None
        response = self.drive.response(law.period, by_motion=self.drives_by_motion)
        return response if response.remembered else None

    @property
    def of_law_samples(self) -> tuple[str, ...]:
        """Return the names of the drive's properties that apply only with a sampled law.

        These are the lag, the delay, the rate limit, the quantisation, the dead band, and a force
        that depends on the motion.
        """
        by_motion = ("force by the motion",) if self.drives_by_motion else ()
        return (*self.drive.of_held_commands, *by_motion)

    @property
    def drives_by_motion(self) -> bool:
        """Return whether the force of the drive at a given control depends on the motion."""
        motion = self.drive.along(self.coordinate)
        return not self.drive.force.free_symbols.isdisjoint((*motion, *motion.values(), DIRECTION))

    @property
    def has_stribeck(self) -> bool:
        """Return whether the equation of motion has an exponential of the velocity.

        Such a term is Stribeck friction, which decreases as the speed rises.
        """
        return any(each.has(self.coordinate.velocity) for each in self.force.atoms(sympy.exp))

    @property
    def jumps(self) -> bool:
        """Return whether the drive's force jumps at the samples of the law.

        True for a sampled law whose drive has neither a lag nor a delay of a fraction of a sample.
        """
        sampled = self.control is not None and not self.control.continuous
        return sampled and not (self.response and (self.response.lag or self.response.share))

    @property
    def holds_force(self) -> bool:
        """Return whether the drive's force is constant between the samples of the law.

        False without a sampled law, or if the drive has a lag, a delay of a fraction of a sample,
        or a force that depends on the motion.
        """
        sampled = self.control is not None and not self.control.continuous
        return sampled and (self.response is None or self.response.is_held)

    def _check_response(self) -> None:
        """Refuse a lag, delay or similar property of the drive that contradicts the control law."""
        law, drive = self.control, self.drive
        declared = drive.of_held_commands
        if law is None or not declared:
            return
        named = " and the ".join(declared)
        refuse(
            ModelError,
            (
                law.continuous,
                f"the drive has a {' and '.join(declared)}, but the control law {law.name!r} is "
                f"continuous. The {named} can only act on commands that are held from sample to "
                f"sample. Declare a sampled law, or omit the {named}",
            ),
            (
                law.delay and drive.delay,
                f"the control law {law.name!r} has a delay of {law.delay} samples and the drive "
                f"has a delay of {drive.delay:g} s. Both declare the same delay. If the control "
                "was recorded after the delay, keep only the law's delay. Otherwise keep only the "
                "drive's delay, with logged='command' or 'applied'",
            ),
            (
                drive.delay > LONGEST_DELAY * law.period,
                f"the drive's delay is {drive.delay:g} s, more than {LONGEST_DELAY} samples of "
                f"{law.period:g} s. Check that the delay is in seconds",
            ),
            before=f"axis {self.name!r}: ",
            code="drive",
        )

    def _check_types(self) -> None:
        """Refuse attributes of a wrong type, and store parameters and signals as tuples."""
        wanted: dict[str, tuple[type | UnionType, str]] = {
            "coordinate": (Coordinate, "a Coordinate"),
            "force": (sympy.Expr, "an Expr"),
            "drive": (Drive, "a Drive"),
            "control": (ControlLaw | None, "a ControlLaw"),
            "experiment": (Experiment | None, "an Experiment"),
            "columns": (Mapping, "a Mapping"),
            "title": (str, "a text"),
        }
        for name, (kind, expected) in wanted.items():
            if not isinstance(getattr(self, name), kind):
                raise ModelError(
                    f"axis {self.name!r}: {name} is {quoted(getattr(self, name))}. "
                    f"Give {expected}.",
                    code="axis",
                )
        settle(
            self,
            parameters=listed(self.parameters, Parameter, "the parameters contain"),
            signals=listed(self.signals, Signal, "the signals contain"),
        )

    def _check_symbols(self) -> None:
        """Refuse an equation of motion that is not finite and real, or whose symbols are wrong.

        Each symbol must be declared. Each parameter and the acceleration must occur.
        """
        q = self.coordinate
        check_size(self.force, f"axis {self.name!r}: the equation of motion")
        profile = self.drive.profile
        for value in (self.force, with_numbers(self.force), with_numbers(1 / profile)):
            if value.has(sympy.nan, sympy.oo, -sympy.oo, sympy.zoo):
                raise ModelError(
                    f"axis {self.name!r}: the equation of motion is not finite: {value}. Correct "
                    "the infinite or undefined term.",
                    code="equation",
                )
            if value.has(sympy.I):
                raise ModelError(
                    f"axis {self.name!r}: the equation of motion is not real: {value}. Write a "
                    "real force, without the imaginary unit or a root of a negative number.",
                    code="equation",
                )
        declared = {p.symbol for p in self.parameters}
        # Collect the symbols that occur, except constants and internal states.
        values = [value for state in self.states for value in state.values]
        used = profile.free_symbols.union(*(v.free_symbols for v in (self.force, *values)))
        used -= {s for v in values for s in v.atoms(ConstantSymbol)}
        used -= {symbol for state in self.states for symbol in (state.own, StateSymbol(state))}
        used -= self.force.atoms(ConstantSymbol) | profile.atoms(ConstantSymbol)
        allowed = declared | {q.symbol, q.velocity, q.acceleration}
        allowed |= {signal.symbol for signal in self.signals}
        unknown, unused = (sorted(map(str, each)) for each in (used - allowed, declared - used))
        refuse(
            ModelError,
            (
                unknown,
                f": the equation of motion has the unknown symbols {', '.join(unknown)}. It may "
                f"use {', '.join(sorted(map(str, allowed)))}. Declare each unknown as a Parameter, "
                "and write the expression with the Parameter and Coordinate objects, not with "
                "symbols of the same name",
                "axis",
            ),
            (
                unused,
                f": the parameters {', '.join(unused)} are declared but do not appear in the "
                "equation of motion. Use or remove these parameters",
                "axis",
            ),
            (not declared, " has no parameter to identify. Declare a Parameter", ""),
            (
                q.acceleration not in used,
                f": the acceleration {q.acceleration} does not appear in the equation of motion. "
                "Add an inertia times the acceleration",
                "axis",
            ),
            before=f"axis {self.name!r}",
        )

    def _check_signals(self) -> None:
        """Refuse signals that are used but not declared, or have the name of a role."""
        declared = {signal.symbol for signal in self.signals}
        unknown = {
            what: sorted(map(str, used - declared)) for what, used in self._used_signals.items()
        }
        refuse(
            ModelError,
            *(
                (
                    signal.name in ROLES,
                    f"the signal {signal.name!r} has the name of another column, that of the "
                    f"{signal.name}. Rename the signal",
                )
                for signal in self.signals
            ),
            *(
                (
                    names,
                    f"{what} has the signals {', '.join(names)}, which the axis does not declare. "
                    "Declare these signals with signals=(...)",
                )
                for what, names in unknown.items()
            ),
            before=f"axis {self.name!r}: ",
            code="axis",
        )

    @property
    def _used_signals(self) -> dict[str, frozenset[SignalSymbol]]:
        """Return the recorded signals in the equation of motion, the drive and the law.

        The keys describe these three parts for messages.
        """
        drive = self.drive
        return {
            "the equation of motion": signals_in(self.force),
            "the drive": signals_in(drive.force, drive.inverse, drive.profile),
            "the control law": frozenset() if self.control is None else self.control.signals,
        }

    @property
    def sampled_signals(self) -> frozenset[str]:
        """Return the names of the recorded signals that the law or the drive reads.

        If the law is sampled, each signal is read once per sample of the law.
        """
        used = self._used_signals
        law_and_drive = used["the control law"] | signals_in(self.drive.force, self.drive.inverse)
        return frozenset(map(str, law_and_drive))

    def check_signals_used(self) -> None:
        """Refuse a declared signal that is used nowhere.

        Raises
        ------
        ModelError
            There is such a signal.
        """
        used = frozenset().union(*self._used_signals.values())
        if unused := [signal.name for signal in self.signals if signal.symbol not in used]:
            raise ModelError(
                f"axis {self.name!r}: the signals {', '.join(unused)} are declared but appear "
                "neither in the equation of motion nor in the drive or the control law. Use or "
                "remove these signals.",
                code="unused-signals",
            )

    def _check_columns(self) -> None:
        """Refuse a title of several lines, a wrong column or role, or a wrong `injected_at`."""
        refuse(
            ModelError,
            (
                not self.title.isprintable(),
                f"the title {self.title!r} is not one line of text. Give one line of text",
                "axis",
            ),
            *(
                (
                    role not in self.roles or not isinstance(column, str),
                    f"columns has {column!r} for the role {role!r}. Give the name of a column for "
                    f"each role that the log contains, out of {', '.join(self.roles)}",
                    "axis",
                )
                for role, column in self.columns.items()
            ),
            (
                self.injected_at not in ("", *INJECTION_POINTS),
                f"injected_at is {self.injected_at!r}. Give the signal to which the test signal is "
                "added: 'control' or 'reference'",
                "test-signal",
            ),
            before=f"axis {self.name!r}: ",
        )

    def _check_truth(self) -> None:
        """Refuse true values or signals of an experiment that the axis does not declare."""
        if self.experiment is None:
            return
        names = {
            "parameters": [p.name for p in self.parameters],
            "signals": [signal.name for signal in self.signals],
        }
        refuse(
            ModelError,
            *(
                (
                    name not in names[kind],
                    f"{subject} {name!r}, which the axis does not declare. Use only the declared "
                    f"{kind}: {', '.join(names[kind]) or 'none'}",
                )
                for subject, used, kind in (
                    ("'s truth has the parameter", self.experiment.truth, "parameters"),
                    (" has the signal", self.experiment.signals, "signals"),
                )
                for name in used
            ),
            before=f"axis {self.name!r}: the experiment",
            code="twin",
        )

    def _check_units(self) -> None:
        """Refuse a term, state, profile or `scaled_by` with a wrong unit."""
        try:
            check_states(self.states, self.coordinate, self.parameters)
            checked_terms(
                self.force, self.coordinate, self.parameters, (*self.signals, *self.states)
            )
            units = unit_table(self.coordinate, (*self.parameters, *self.signals))
            for name, expected in (
                ("profile", "the force divided by its nominal value"),
                ("scaled_by", "the factor of the gain"),
            ):
                value = getattr(self.drive, name)
                check_unit(
                    value,
                    NUMBER,
                    units,
                    f"the drive's {name} {value}",
                    f". Give {expected}, which has no unit",
                )
        except ModelError as error:
            raise ModelError(f"axis {self.name!r}: {error}", code="units") from error


def check_axis(axis: object) -> None:
    """Refuse an object that is not a declared axis, such as its name."""
    if not isinstance(axis, Axis):
        raise UsageError(
            f"the axis is {quoted(axis)}. Give an Axis, such as load_axis('emps').",
            code="axis",
        )


def equation_of_motion(axis: Axis) -> Formula:
    """Return the equation of motion, ``tau profile = inverse dynamics``, as a formula.

    The left side is the drive's nominal force times its profile.
    """
    unit = str(axis.coordinate.force_unit)
    return Formula(name=FORCE * axis.drive.profile, value=axis.force, unit=unit)
