"""What may be wrong with the values of a column: spikes, cut-off samples, turns, jumps.

In: samples of one role. Out: where they are faulty, and repairs on request.
Knows nothing of names, clocks and filters.
"""

from .clipping import Mask as Mask
from .clipping import clipped as clipped
from .clipping import clipping_notes as clipping_notes
from .clipping import quantum_of as quantum_of
from .jumps import remaining_jumps_note as remaining_jumps_note
from .spikes import spike_notes as spike_notes
from .wrapping import Modulus as Modulus
from .wrapping import signed as signed
from .wrapping import unsigned_notes as unsigned_notes
from .wrapping import unwrapped as unwrapped
