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
#: End of a simulation, by the status that the C functions return.
STATUSES = ("done", "out of range", "not finite", "chatter", "unresolved")

#: Names of the values that are held between samples under a continuous law: its inputs.
HELD_REFERENCE = ("reference", "reference_rate", "measurement_error", "injected")

#: Number of lanes in a block of the C code in printers/loop.
BLOCK = 32

#: Rate times step at which a Runge-Kutta step is accurate where the rates vary with the motion.
RESOLVED = 0.025
#: The same product for motion and internal states, whose steps are implicit: a bristle's position
#: is then within 2e-8 of its range of what an independent integrator gives.
RESOLVED_STATES = 0.2
#: Largest distance times wave number of a step along a periodic force. Along a given motion a
#: Runge-Kutta step is Simpson's rule; the mean of the wave is then exact to 2e-6 of its amplitude.
PHASE_PER_STEP = 0.25
#: Change of position and velocity, SI, of the finite differences that give the plant's rates.
PROBE = 1e-6
#: Largest change of the position, relative to the distance over which the acceleration varies.
PROBED = 0.01
#: Largest number of steps of a whole simulation, or per sample in the mean if that allows more.
STEPS_IN_ALL, STEPS_OF_EACH = 2**23, 64
#: Largest number of steps of all simulations of one search together, for each loop of an iterate;
#: per sample as above.
STEPS_OF_SEARCH = 4 * STEPS_IN_ALL
#: Largest friction direction of an axis that sticks, just below 1.
STUCK = 1 - 2.0**-53


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopStart:
    """Start of a simulation; for a batch, each attribute has one entry for each lane.

    Attributes
    ----------
    position : float or (B,) array
    velocity : float or (B,) array
    memory : (m,) or (B, m) array or None
        State of law and drive, in the order of ``control_start``; None for the state at rest.
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
        Resolution of the encoder, in the coordinate's unit; 0 for none.
    allowed : float or (B,) array
        Distance from the reference at which a simulation ends as out of range; by lane for a batch.
    substeps : int
        Runge-Kutta steps in a sample.
    """

    period: float
    resolution: float
    allowed: Any
    substeps: int
