"""Inputs and outputs of the time loop, native or in the virtual machine."""

from dataclasses import dataclass
from typing import Any

#: Signals of a simulation, in the order of the C functions' results.
SIGNALS = (
    "position",
    "velocity",
    "acceleration",
    "force",
    "control",
    "direction",
    "direction_before",
)
#: What a simulation ended with, by the status that the C functions return.
STATUSES = ("done", "out of range", "not finite", "chatter", "unresolved")

#: What is held between samples under a continuous law.
HELD_REFERENCE = ("reference", "reference_rate", "measurement_error", "injected")

#: Lanes of a block in printers/loop.
BLOCK = 32

#: Rate times step at which a Runge-Kutta step is accurate where the rates vary with the motion.
RESOLVED = 0.025
#: The same of motion and internal states together, whose steps are implicit: a bristle's position
#: is then within 2e-8 of its range of what an independent integrator gives.
RESOLVED_STATES = 0.2
#: Way times wave number of a step that passes a wave; with Simpson's rule, which a Runge-Kutta step
#: is along a given way, the wave's mean is then right within 2e-6 of its size.
PHASE_PER_STEP = 0.25
#: Of position and velocity, SI, over which the plant's rates are probed.
PROBE = 1e-6
#: At most, the part of the way on which the acceleration varies.
PROBED = 0.01
#: Steps of a whole simulation, at most, or of each of its samples in the mean where these are more.
STEPS_IN_ALL, STEPS_OF_EACH = 2**23, 64
#: Steps of all simulations of one search together for each loop of an iterate, at most; of each
#: sample as above.
STEPS_OF_SEARCH = 4 * STEPS_IN_ALL
#: The largest direction at rest.
STUCK = 1 - 2.0**-53


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopStart:
    """Start of a simulation.

    Attributes
    ----------
    position : float or (B,) array
        By lane for a batch, as all others.
    velocity : float or (B,) array
    memory : (m,) or (B, m) array or None
        What the drive remembers, in the order of ``control_start``; None for an axis at rest.
    """

    position: Any
    velocity: Any = 0.0
    memory: Any = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopSettings:
    """Settings of a simulation in addition to its signals.

    Attributes
    ----------
    period : float
        Sampling period, s.
    resolution : float
        Of the encoder, in the coordinate's unit; 0 for none.
    allowed : float or (B,) array
        Distance from the reference at which a simulation ends as out of range; by lane for a batch.
    substeps : int
        Runge-Kutta steps in a sample.
    """

    period: float
    resolution: float
    allowed: Any
    substeps: int
