"""The generated axis, which estimation uses: numerical functions in place of SymPy expressions."""

from __future__ import annotations  # so that help() prints them as written

import pickle
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from numpy.typing import ArrayLike

from axisid.codegen.lowering import (
    Program,
    drive_force,
    evaluate,
    over_time,
)
from axisid.codegen.runtime import (
    FunctionShape,
    Native,
    by_sample,
    checked_arguments,
    execute,
    slices,
)
from axisid.modeling.declaration import Axis, ControlLaw, Drive, Response, check_axis
from axisid.modeling.derivation import (
    AxisModel,
    BaseModel,
    ParameterMap,
    derive,
    describe_loss,
)
from axisid.modeling.quantities import (
    CONTROL,
    DIRECTION,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    TIME,
    Coordinate,
    Parameter,
    Signal,
)
from axisid.support.arrays import Array
from axisid.support.checks import real_array
from axisid.support.errors import ModelError, UsageError
from axisid.support.missing import Missing, unless_missing
from axisid.support.wording import quoted

from .loop_by_gains import LoopByGains
from .texts import FUNCTIONS, NATIVE, axis_artefacts, signature, single_result


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """Name and unit of a number, such as ``M`` in ``kg``.

    Attributes
    ----------
    name, unit : str
    expression : str
        Formula of the quantity; empty if it has none.
    """

    name: str
    unit: str
    expression: str = ""

    @property
    def label(self) -> str:
        """Formula of the quantity if it has one, otherwise its name."""
        return self.expression or self.name


#: Properties of an axis that are computed once from its expressions, because this is slow.
_AXIS_PROPERTIES = (
    "drives_by_motion",
    "jumps",
    "holds_force",
    "has_stribeck",
    "response",
    "of_law_samples",
)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class GeneratedAxis:
    """An axis as named CasADi functions, with the labels its results need.

    Attributes
    ----------
    axis : Axis
        The declaration (names, units, nominal values, drive, law, columns) in base parameters.
    base : BaseModel
        Map from the declared parameters to the base parameters.
    signature : str
        SHA-256 of the content from which the functions were generated.
    parameters : tuple of Quantity
        The physical parameters, length p: the declared parameters. If these are not linear or not
        distinguishable, they are the base parameters, which then have an `expression`.
    ddm_parameters : tuple of Quantity or Missing
        Parameters of the direct model, length m; Missing if there is no direct regressor, or if the
        map from the physical parameters has no inverse.
    uniform : bool
        True if the plant, and a continuous law, have the same damping and stiffness everywhere.
    evenly_damped : bool
        True if the plant has the same damping at every velocity.
    has_direction : bool
        True if the force depends on the direction of motion, as friction does.
    nonlinear : tuple of bool
        True for each parameter that enters nonlinearly, length p. The inverse regressor is
        linearised in such a parameter.
    unidentifiable : tuple of str
        Sentences on parameters that no motion distinguishes; empty if there are none.
    functions : mapping of str to casadi.Function
        See `axisid.codegen.lowering.axis_functions`.
    native : Native
        The same functions and the closed loop, compiled; without a library if there is no compiler.
    states : tuple of Quantity
        Internal states of the friction.
    loop : LoopByGains or None
        The closed loop with the gains of the law as arguments, so that gains can change without a
        new compilation; None for an axis without a sampled law with gains.
    drives_by_motion, jumps, holds_force, has_stribeck : bool
        Properties of `axis`, computed once, because a verdict uses them hundreds of times.
    response : Response or None
        Response of the drive to a sampled law, see `Axis`; None if the drive follows at once.
    of_law_samples : tuple of str
        `Axis.of_law_samples` of `axis`.
    """

    axis: Axis
    base: BaseModel
    signature: str
    parameters: tuple[Quantity, ...]
    ddm_parameters: tuple[Quantity, ...] | Missing
    uniform: bool
    evenly_damped: bool
    has_direction: bool
    nonlinear: tuple[bool, ...]
    unidentifiable: tuple[str, ...]
    functions: Mapping[str, Any]
    native: Native
    loop: LoopByGains | None = None
    states: tuple[Quantity, ...] = ()
    drives_by_motion: bool = field(init=False)
    jumps: bool = field(init=False)
    holds_force: bool = field(init=False)
    has_stribeck: bool = field(init=False)
    response: Response | None = field(init=False)
    of_law_samples: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        for name in _AXIS_PROPERTIES:
            object.__setattr__(self, name, getattr(self.axis, name))

    def __repr__(self) -> str:
        return f"generated axis {self.axis.name}: {', '.join(self.names)} ({self.signature[:12]})"

    def __reduce__(self) -> tuple[Any, tuple[bytes, bool]]:
        """Return the declaration for pickling, from which another process builds the same axis."""
        return _rebuilt, (pickle.dumps(self.declared), self.native.enabled)

    def __eq__(self, other: object) -> bool:
        """Return True if the other axis was built from the same declaration, compiled or not."""
        return isinstance(other, GeneratedAxis) and self.declared == other.declared

    def __hash__(self) -> int:
        return hash(self.signature)

    def __deepcopy__(self, _: dict[int, Any]) -> GeneratedAxis:
        return self  # the object never changes

    @property
    def declared(self) -> Axis:
        """The axis as declared."""
        return self.base.declared

    @property
    def name(self) -> str:
        """Name of the axis."""
        return self.axis.name

    @property
    def coordinate(self) -> Coordinate:
        """Coordinate of the axis."""
        return self.axis.coordinate

    @property
    def drive(self) -> Drive:
        """Drive, from control to force."""
        return self.axis.drive

    @property
    def control(self) -> ControlLaw | None:
        """Control law; None if none is declared."""
        return self.axis.control

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Recorded signals that the force, the drive or the law depends on."""
        return self.axis.signals

    @property
    def signal_symbols(self) -> tuple[sympy.Symbol, ...]:
        """Symbols of the recorded signals."""
        return self.axis.signal_symbols

    @property
    def sampled_signals(self) -> frozenset[str]:
        """Names of the signals that a sampled law or the drive reads once a sample."""
        return self.axis.sampled_signals

    @property
    def axis_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of `axis`, with bounds and nominal values, length p."""
        return self.axis.parameters

    @property
    def nominal(self) -> Array:
        """A-priori parameters, (p,)."""
        return np.array([p.nominal for p in self.axis.parameters])

    @property
    def has_sides(self) -> bool:
        """True if the acceleration has kinks or jumps in the position, as at an end stop."""
        return "switching" in self.functions

    @property
    def is_linear(self) -> bool:
        """True if the force is linear in all parameters."""
        return not any(self.nonlinear)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the physical parameters."""
        return tuple(p.name for p in self.parameters)

    def with_gains(self, gains: Mapping[str, float]) -> GeneratedAxis:
        """Return the axis with other gains of its control law, without compiling again.

        Parameters
        ----------
        gains : mapping of str to float
            Gains, SI, by name; the others are unchanged.

        Raises
        ------
        ModelError
            The axis has no sampled law with gains, or a gain is unknown or not a finite number.
        """
        loop, law = self.loop_with(gains)
        law, base = replace(law, gains={**law.gains, **gains}), self.base
        axis = replace(loop.model.axis, control=law)
        # The text of the loop does not contain the numbers.
        loop = replace(loop, law=law, model=replace(loop.model, axis=axis))
        return replace(
            self,
            axis=axis,
            base=replace(base, declared=replace(base.declared, control=law)),
            signature=signature(loop.model),
            functions={**self.functions, **loop.functions_at(law.gains)},
            native=loop.native_at(law.gains),
            loop=loop,
        )

    def loop_with(self, gains: Iterable[str]) -> tuple[LoopByGains, ControlLaw]:
        """Return the closed loop whose gains can change, and its law.

        Raises
        ------
        ModelError
            The axis has no sampled law with gains, or a gain in `gains` is unknown.
        """
        if self.loop is None:
            law = self.axis.control
            lacking = "has no control law"
            if law:
                kind = "continuous law" if law.continuous else "control law without gains"
                lacking = f"has a {kind}"
            raise ModelError(
                f"axis {self.axis.name!r} {lacking}, so that no gain of its loop can change. "
                "Declare an axis with a sampled control law that has gains.",
                code="law",
            )
        law = self.loop.law
        if unknown := [name for name in gains if name not in law.gains]:
            raise ModelError(
                f"control law {law.name!r} has no gain {quoted(unknown[0])}. Its gains are "
                f"{', '.join(law.gains)}.",
                code="law",
            )
        return self.loop, law

    def describe(self, parameters: Array) -> str:
        """Return the physical parameters as text, such as ``M = 95.1 kg, Fv = 203.5 N/(m/s)``."""
        pairs = zip(self.parameters, parameters, strict=True)
        return ", ".join(f"{p.name} = {value:.6g} {p.unit}" for p, value in pairs)

    def evaluate(self, function: str, *arguments: ArrayLike) -> tuple[Array, ...]:
        """Return the results of a function at N samples.

        Parameters
        ----------
        function : str
            Name of the function.
        *arguments : array_like, (N,)
            Values of each argument of the function, all of the same length. A vector argument, such
            as the parameters, is the same for all samples, (p,), or has one row per sample, (N, p).
            Recorded signals, in the axis's order, come before a vector and after all other scalars.

        Returns
        -------
        tuple of (N, columns) arrays
            One array for each output.
        """
        library = self.native.evaluator(function)
        if library is not None:
            return library.evaluate(function, arguments)
        # Without native code, CasADi evaluates the function for many samples in one call.
        compiled = self._function(function)
        shape = FunctionShape.of(compiled)
        checked, samples = checked_arguments(shape, arguments)
        outputs = tuple(np.empty((samples, elements)) for elements in shape.results)
        for part in slices(samples):
            columns = [
                a[:, None] if vector and a.ndim == 1 else np.atleast_2d(a[part].T)
                for vector, a in zip(shape.vectors, checked, strict=True)
            ]
            for output, out in zip(outputs, compiled.call(columns), strict=True):
                output[part] = by_sample(out.full(), part.stop - part.start)
        return outputs

    def force_by_gain(
        self, control: Array, position: Array, velocity: Array, recorded: Sequence[Array] = ()
    ) -> Array:
        """Return the derivative of the drive's force by the logarithm of its gain, (N,).

        The arguments are control, position and velocity at N samples, and the recorded signals in
        the axis's order.
        """
        motion = (control, position, velocity)
        return self._driven(drive_force(self.axis, by_gain=True), motion, recorded)

    def force_in_mode(
        self,
        control: Array,
        position: Array,
        velocity: Array,
        direction: Array,
        recorded: Sequence[Array] = (),
    ) -> Array:
        """Return the drive's force at N samples with given friction directions, (N,).

        The directions are arguments, because the velocity does not give the direction at rest.
        """
        motion = (control, position, velocity, direction)
        return self._driven(drive_force(self.axis, directed=True), motion, recorded)

    def _driven(
        self, program: Program, motion: Sequence[Array], recorded: Sequence[Array]
    ) -> Array:
        """Return the single result, (N,), of a program of the drive at N samples.

        `motion` and `recorded` are the values of its arguments in their order.
        """
        names = (port.name for port in program.inputs)
        return single_result(program, dict(zip(names, (*motion, *recorded), strict=True)))

    def experiment_signals(self, time: Array) -> dict[str, Array]:
        """Return the signals that the axis's experiment declares, at N times in s, (N,) each.

        They are given by name. The mapping is empty without an experiment or signals.
        """
        experiment = self.axis.experiment
        if experiment is None or not experiment.signals:
            return {}
        found = evaluate(over_time(experiment.signals), {str(TIME): time})
        return {name: np.array(np.broadcast_to(v[:, 0], time.shape)) for name, v in found.items()}

    def mapped(self, function: str, values: ArrayLike) -> tuple[Array, Array]:
        """Return parameters mapped between inverse and direct model, and the Jacobian of the map.

        Parameters
        ----------
        function : str
            ``ddm_from_physical`` or ``physical_from_ddm``.
        values : array_like
            Length p or m.
        """
        compiled = self._function(function)
        vector = np.ravel(real_array(values, f"{function}: {compiled.name_in(0)}"))
        if compiled.n_in() != 1 or len(vector) != compiled.size1_in(0):
            raise UsageError(
                f"{function} cannot map {len(vector)} values. Give one value per parameter."
            )
        result, jacobian = compiled(vector)
        return result.full().ravel(), jacobian.full()

    def _function(self, name: str) -> Any:
        """Return a CasADi function by its name; an unknown name is refused."""
        if name not in self.functions:
            raise UsageError(
                f"axis {self.axis.name!r} has no function {name!r}. Its functions are "
                f"{', '.join(self.functions)}."
            )
        return self.functions[name]


def build(axis: Axis, *, native: bool = True) -> GeneratedAxis:
    """Return the generated axis of a declared axis: its models are derived, its functions built.

    The functions are built from the same text that `axisid generate` writes.

    Parameters
    ----------
    axis : Axis
    native : bool
        True if simulations may compile and run native code; False for the virtual machine of
        CasADi.

    Raises
    ------
    ModelError
        The axis cannot be derived or lowered.
    """
    model = derive(axis)
    axis = model.axis
    combined = {p.name: p.description for p, _ in model.base.combined}
    texts = axis_artefacts(model)
    functions = execute(texts[FUNCTIONS], axis.name)
    loop = LoopByGains.of(model, enabled=native)
    if not native or loop is None:
        run = Native(texts[NATIVE], functions, enabled=native)
    else:
        run = loop.native_at(loop.law.gains)
    return GeneratedAxis(
        axis=axis,
        base=model.base,
        signature=signature(model),
        parameters=tuple(
            Quantity(name=p.name, unit=p.unit, expression=combined.get(p.name, ""))
            for p in axis.parameters
        ),
        ddm_parameters=_ddm_parameters(model.parameter_map),
        uniform=_is_uniform(model),
        evenly_damped=not model.acceleration.diff(axis.coordinate.velocity).has(
            axis.coordinate.velocity
        ),
        has_direction=any(
            c.has(DIRECTION)
            for c in (*model.idm.columns, model.idm.intercept, model.axis.drive.force)
        ),
        nonlinear=tuple(p.symbol in model.idm.nonlinear for p in axis.parameters),
        unidentifiable=tuple(map(describe_loss, model.unidentifiable)),
        functions=functions,
        native=run,
        loop=loop,
        states=tuple(Quantity(name=s.name, unit=s.unit) for s in axis.states),
    )


@lru_cache(maxsize=32)
def _rebuilt(declared: bytes, native: bool) -> GeneratedAxis:
    """Return the axis of a pickled declaration, built once per process.

    Every task of a worker process carries the declaration.
    """
    return build(pickle.loads(declared), native=native)  # noqa: S301


def _is_uniform(model: AxisModel) -> bool:
    """Return True if the plant's acceleration, and a continuous law, are affine in the motion.

    Each derivative by position, velocity and control must be independent of all of these, of the
    direction of motion, and of recorded signals.
    """
    if model.states:
        return False
    q, law, recorded = model.axis.coordinate, model.axis.control, model.axis.signal_symbols
    expressions: list[tuple[sympy.Expr, tuple[sympy.Symbol, ...]]] = [
        (model.acceleration, (q.symbol, q.velocity))
    ]
    drive = model.axis.drive
    if law is not None and (law.continuous or model.axis.drives_by_motion):
        expressions.append((drive.force.xreplace(drive.along(q)), (CONTROL, q.symbol, q.velocity)))
    if law is not None and law.continuous:
        expressions.append((law.output, (MEASURED_POSITION, MEASURED_VELOCITY)))
    return all(
        not expression.diff(variable).free_symbols & {*variables, DIRECTION, *recorded}
        for expression, variables in expressions
        for variable in variables
    )


def as_generated(axis: Axis | GeneratedAxis) -> GeneratedAxis:
    """Return the generated axis of an axis; a generated axis is returned unchanged.

    Raises
    ------
    UsageError
        The object is neither a declared nor a generated axis.
    """
    return axis if isinstance(axis, GeneratedAxis) else build(axis)


def as_declared(axis: Axis | GeneratedAxis | None) -> Axis | None:
    """Return the declaration of a generated axis; a declared axis and None are returned unchanged.

    Raises
    ------
    UsageError
        The object is neither a declared axis, nor a generated axis, nor None.
    """
    declared = axis.axis if isinstance(axis, GeneratedAxis) else axis
    if declared is not None:
        check_axis(declared)
    return declared


@unless_missing
def _ddm_parameters(mapping: ParameterMap) -> tuple[Quantity, ...]:
    """Return name, unit and formula of each parameter of the direct model.

    Missing if there is no map from the physical parameters to those of the direct model.
    """
    return tuple(
        Quantity(name=str(symbol), unit=str(unit), expression=str(value))
        for symbol, unit, value in zip(mapping.symbols, mapping.units, mapping.forward, strict=True)
    )
