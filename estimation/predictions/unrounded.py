"""An axis whose drive does not round its commands, as searches simulate it.

What a drive rounds is a staircase of the parameters: its slope is 0 or a jump, and no search moves
on it. The mean of a rounded control over a motion is that of one that is not, and what the steps
leave is an error of the output like a noise.
"""

from dataclasses import replace
from functools import lru_cache

from axisid.codegen.artefacts import GeneratedAxis, build


def unrounded(axis: GeneratedAxis) -> GeneratedAxis:
    """The same axis, its drive without steps; itself where that has none."""
    return _smooth(axis, native=axis.native.enabled) if axis.declared.drive.quantisation else axis


# The records of a fit have one axis, or few, and to build one may compile its loop. Of two that are
# equal one may be compiled and the other not.
@lru_cache(maxsize=16)
def _smooth(axis: GeneratedAxis, *, native: bool) -> GeneratedAxis:
    drive = axis.declared.drive
    others = drive.delay or not replace(drive.path, quantisation=0.0).is_plain
    # What acts of a command that nothing changes is the command.
    logged = drive.logged if others or drive.logged != "applied" else "command"
    smooth = replace(drive, quantisation=0.0, logged=logged)
    return build(replace(axis.declared, drive=smooth), native=native)
