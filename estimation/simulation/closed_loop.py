"""Closed-loop simulation: the reference in, everything else simulated.

The control law is evaluated once a sample and held (or all the time, if it is continuous). In
between, the plant moves in one friction mode; where the velocity reaches zero the crossing is
located and the mode chosen anew. At rest the model itself decides: with the accelerations a(+) and
a(-) for both friction directions, the axis sticks if and only if ``a(+) <= 0 <= a(-)``
[Filippov1988]_. Native code runs where there is a compiler, the CasADi virtual machine elsewhere.
"""

from __future__ import annotations  # as they are written, in what help() prints

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.codegen.lowering import STATUSES, LoopSettings, LoopStart
from axisid.codegen.runtime import VirtualLoop
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError
from axisid.support.real_numbers import real_array

from .between import at_log_samples
from .lane_arguments import in_order
from .loop_start import single_start
from .recorded import at_law, checked_signals, first_values, lines
from .runaway import allowed_distance, widened_distance
from .simulated import Simulation, measured_positions
from .steps import (
    StepBudget,
    bounds_refusal,
    check_inertia,
    check_loop,
    failure,
    first_substeps,
    further_substeps,
    place_at,
    pushes,
)
from .two_clocks import TwoClocks, clocks_of


def simulate(
    axis: Axis | GeneratedAxis,
    parameters: ArrayLike | Mapping[str, float],
    reference: ArrayLike,
    period: float,
    *,
    start: float | None = None,
    start_velocity: float = 0.0,
    memory: ArrayLike | None = None,
    position_noise: ArrayLike | None = None,
    injected: ArrayLike | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
) -> Simulation:
    """Simulate the axis under its control law, starting at rest unless a velocity is given.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a control law.
    parameters : (p,) array_like or mapping of str to float
        Physical parameters, SI: in the axis's order, or all of them by name.
    reference : (N,) array_like
        Commanded position.
    period : float
        Sampling period of the reference and of what is given back, s. Where it is not the control
        law's, the loop runs at the law's own: the reference runs between its samples as the law
        declares (``reference_between``), or smoothly, and the loop is sampled as the reference is.
    start : float, optional
        First position; the first reference by default.
    start_velocity : float
        First velocity.
    memory : (m,) array_like, optional
        What the drive remembers at the first sample: the law's memory in its order, then the
        controls that it has computed but not applied, the newest first; of a
        drive with a lag or a delay the forces of commands that are to act, the newest first, and
        the force that is there. By default what the law
        declares for an axis at rest.
    position_noise : (N,) array_like, optional
        Added to the position that the law measures; with two clocks held between samples.
    injected : (N,) array_like, optional
        Test signal in the drive's unit, added to what the law gives before the drive's limit and
        the law's delay; held from a sample to the next. One that is added to the reference is
        added to `reference`.
    signals : mapping of str to (N,) array_like, optional
        The recorded signals that the axis declares, by name, SI, one value for each sample of the
        reference. Between samples each is held or runs straight, as it is declared; the law and the
        force of a sampled law read them at the samples.
    resolution : float
        Of the encoder, in the coordinate's unit; the law then measures whole counts. 0 for none.
    substeps : int, optional
        Runge-Kutta steps in a sample, at most 1024; the error falls with their fourth power. By
        default a power of 2, as many as the damping, the stiffness and the speed over the length of
        a wave of the position ask for wherever the motion goes: mostly 1. Where they vary the loop
        is simulated anew until it had enough. For an axis whose force has kinks or jumps over the
        position it is the least number: each piece of a sample, from one side to the next, takes
        the steps that its own rates ask for. Friction that remembers takes implicit steps, as many
        as its bristles ask for; its internal states begin where they are declared to.

    Raises
    ------
    ModelError
        The axis has no control law.
    UsageError
        An argument has the wrong shape or value, a parameter is beyond its declared bounds, or the
        period and the control law's are more than 400 times apart.
    EstimationError
        The inertia is not positive, friction drives the axis, or the loop diverges, chatters or is
        too fast to follow; the sample is named.
    """
    axis, commanded = as_generated(axis), _vector(reference, "the reference")
    theta = _vector(in_order(axis, parameters), "the parameters")
    check_loop(axis, theta.shape, commanded, period, resolution, substeps)
    loop = _loop(
        axis,
        theta,
        commanded,
        period,
        position_noise,
        injected,
        resolution,
        checked_signals(axis, signals, len(commanded)),
        start=start,
        start_velocity=start_velocity,
        memory=memory,
        clocks=clocks_of(axis.axis.control, len(commanded), period),
    )
    loop.check_friction()
    return loop.simulated(substeps)


def simulate_estimate(
    axis: GeneratedAxis,
    parameters: Array,
    reference: Array,
    period: float,
    *,
    start: LoopStart,
    injected: Array | None = None,
    clocks: TwoClocks | None = None,
    position_noise: Array | None = None,
    resolution: float = 0.0,
    signals: tuple[Array, ...] = (),
    budget: StepBudget | None = None,
) -> Simulation:
    """Simulate with parameters as they were estimated, which may be a little beyond their bounds.

    The period is the record's, and with two clocks the law's is its own; recorded signals come in
    the axis's order. What it takes is taken off a budget. Otherwise as `simulate`.
    """
    check_loop(axis, parameters.shape, reference, period, resolution, None)
    loop = _loop(
        axis,
        parameters,
        reference,
        period,
        position_noise,
        injected,
        resolution,
        signals,
        start=start.position,
        start_velocity=start.velocity,
        memory=start.memory,
        clocks=clocks,
    )
    return replace(loop, budget=budget or loop.budget).simulated(None)


def simulate_sampled(
    axis: GeneratedAxis,
    parameters: Array,
    reference: Array,
    clocks: TwoClocks,
    *,
    position_noise: Array,
    logged_noise: Array,
    injected: Array | None,
    signals: tuple[Array, ...],
    resolution: float,
) -> Simulation:
    """Simulate a loop that is given where its law is evaluated, and sample it as a log is.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    reference, position_noise : (M,) array
        At the evaluations.
    clocks : TwoClocks
    logged_noise, injected : (N,) array
        At the samples of the log: of the positions in it, and added to the control.
    signals : tuple of (N,) array
        Likewise, in the axis's order.
    resolution : float
        Of the encoder; 0 for none.
    """
    loop = _loop(
        axis,
        parameters,
        reference,
        clocks.law_period,
        position_noise,
        None if injected is None else clocks.held(injected),
        resolution,
        at_law(axis, signals, clocks),
        start=float(reference[0]),
        start_velocity=0.0,
        memory=None,
        clocks=None,
    )
    loop.check_friction()
    sampled = replace(loop, clocks=clocks, logged_noise=logged_noise, logged_signals=signals)
    return sampled.simulated(None)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Loop:
    """What one simulation is given, checked: where its law is evaluated, but for the last three.

    `held` is whether no friction drives the axis from where it starts.
    """

    axis: GeneratedAxis
    parameters: Array
    reference: Array
    noise: Array | None
    injected: Array | None
    start: LoopStart
    held: bool
    period: float
    resolution: float
    signals: tuple[Array, ...]
    recorded: Array | None
    clocks: TwoClocks | None
    logged_noise: Array | None
    logged_signals: tuple[Array, ...]
    budget: StepBudget = field(default_factory=StepBudget)

    def check_friction(self) -> None:
        """Refuse parameters beyond their bounds, and friction that drives the axis."""
        if refusal := bounds_refusal(self.axis, self.parameters):
            raise UsageError(refusal)
        if not self.held:
            raise EstimationError(pushes(self.axis, self.parameters))

    def simulated(self, substeps: int | None) -> Simulation:
        """Run it, with as many steps as it needs unless they are given."""
        if self.clocks is not None and self.axis.axis.response is not None:
            raise UsageError(
                f"the period is {self.clocks.log_period:g} s, the control law of axis "
                f"{self.axis.axis.name!r} is evaluated every {self.clocks.law_period:g} s, and its "
                f"drive has a {' and '.join(self.axis.axis.of_law_samples)}: between the "
                "law's samples such a loop is not known. Give the law's period.",
                code="clocks-and-response",
            )
        away = abs(self.start.position - self.reference[0])
        settings = LoopSettings(
            period=self.period,
            resolution=self.resolution,
            allowed=allowed_distance(self.reference.max() - self.reference.min(), away),
            substeps=self._steps_at_start() if substeps is None else substeps,
        )
        settings, status, stopped, out = self._settled(settings, fixed=substeps is not None)
        if STATUSES[status] == "out of range":
            (wider,) = widened_distance(
                self.axis,
                self.parameters[None, :],
                np.array([self.start.position]),
                self.noise,
                self.injected,
                self.resolution,
                first_values(self.recorded),
            )
            if wider > settings.allowed:
                settings = replace(settings, allowed=float(wider))
                _, status, stopped, out = self._settled(settings, fixed=substeps is not None)
        if status:
            at = place_at(out, stopped, self.signals)
            said = failure(self.axis, self.parameters, status, stopped, self.period, at)
            raise EstimationError(said, code="loop-diverges")
        period = self.period
        if self.clocks is not None:
            period = self.clocks.log_period
            out = at_log_samples(self.axis, self.parameters, out, self.clocks, self.recorded)
        return Simulation(
            time=period * _counted(len(out["position"])),
            direction_before=out.pop("before"),
            measured_position=measured_positions(
                out["position"], self.logged_noise, self.resolution
            ),
            recorded=self.logged_signals,
            **out,
        )

    def _steps_at_start(self) -> int:
        first = first_values(self.recorded)
        return first_substeps(
            self.axis,
            self.parameters,
            self.start.position,
            self.period,
            first,
            len(self.reference),
            self.budget.left,
        )

    def _settled(
        self, settings: LoopSettings, *, fixed: bool
    ) -> tuple[LoopSettings, int, int, dict[str, Array]]:
        """Run until the steps are enough for wherever it went, unless they are fixed."""
        while True:
            left = self.budget.left
            status, stopped, out = self._run(settings)
            if fixed:
                break
            visited = {name: values[:stopped] if status else values for name, values in out.items()}
            enough = further_substeps(
                self.axis,
                self.parameters,
                settings.substeps,
                visited,
                self.period,
                self.signals,
                len(self.reference),
                left,
            )
            if enough == settings.substeps:
                break
            settings = replace(settings, substeps=enough)
        return settings, status, stopped, out

    def _run(self, settings: LoopSettings) -> tuple[int, int, dict[str, Array]]:
        """As `run_loop`."""
        self.budget.left -= len(self.reference) * settings.substeps
        inputs = (self.reference, self.noise, self.injected, self.start)
        return run_loop(self.axis, self.parameters, settings, inputs, self.recorded)


def run_loop(
    axis: GeneratedAxis,
    parameters: Array,
    settings: LoopSettings,
    inputs: tuple[Array, Array | None, Array | None, LoopStart],
    recorded: Array | None,
) -> tuple[int, int, dict[str, Array]]:
    """Status, the sample it speaks of, and the signals: native, or in the virtual machine.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    settings : LoopSettings
    inputs : tuple
        Reference, noise or None and what is added to the control or None, (N,) each; the start.
    recorded : (N, 2 s) array or None
        Value and rate of each recorded signal.
    """
    library = axis.native.library()
    if library is None:
        axis.native.warn_once()
        return VirtualLoop(axis.functions, parameters, settings).run(*inputs, recorded)
    reference, noise, injected, start = inputs
    return library.simulate(reference, noise, injected, parameters, start, settings, recorded)


def _loop(
    axis: GeneratedAxis,
    theta: Array,
    reference: Array,
    period: float,
    position_noise: ArrayLike | None,
    injected: ArrayLike | None,
    resolution: float,
    signals: tuple[Array, ...],
    *,
    start: float | None,
    start_velocity: float,
    memory: ArrayLike | None,
    clocks: TwoClocks | None,
) -> _Loop:
    """Check what a loop is given at its samples, but for bounds; take it to the law's clock."""
    theta, ref = _vector(theta, "the parameters"), _vector(reference, "the reference")
    noise = checked_signal(position_noise, ref, "the noise")
    added = checked_signal(injected, ref, "the injected signal")
    logged_noise, logged_signals = noise, signals
    if clocks is not None:
        ref, period = clocks.reference(ref), clocks.law_period
        noise, added = (None if each is None else clocks.held(each) for each in (noise, added))
        signals = at_law(axis, signals, clocks)
        if start is not None and clocks.first:  # it is told of the first sample
            start += start_velocity * clocks.first
    off = 0.0 if noise is None else float(noise[0])
    recorded = lines(axis, signals, period)
    at_first = first_values(recorded)
    first = single_start(
        axis, theta, float(ref[0]), off, resolution, start, start_velocity, memory, at_first
    )
    held = check_inertia(axis, theta, first.position, at_first)
    return _Loop(
        axis=axis,
        parameters=theta,
        reference=ref,
        noise=noise,
        injected=added,
        start=first,
        held=held,
        period=period,
        resolution=resolution,
        signals=signals,
        recorded=recorded,
        clocks=clocks,
        logged_noise=logged_noise,
        logged_signals=logged_signals,
    )


@lru_cache(maxsize=8)
def _counted(samples: int) -> Array:
    """0, 1, 2 and so on; making them takes longer than what is made of them."""
    return np.arange(samples, dtype=np.float64)


def checked_signal(values: ArrayLike | None, reference: Array, what: str) -> Array | None:
    """A signal at the samples of a reference, if there is one."""
    if values is None:
        return None
    signal = _vector(values, what)
    if signal.shape != reference.shape or not np.all(np.isfinite(signal)):
        raise UsageError(
            f"{what} has {len(signal)} samples, the reference {len(reference)}; give as many, "
            "finite.",
            code="signal-length",
        )
    return signal


def _vector(values: ArrayLike, what: str) -> Array:
    vector = real_array(values, what)
    if not (vector.flags.c_contiguous and vector.flags.aligned):
        vector = np.require(vector, requirements=["C", "A"])
    if vector.ndim != 1 or not len(vector):
        raise UsageError(
            f"{what}: the shape is {vector.shape}; give one row of numbers.", code="not-one-row"
        )
    return vector
