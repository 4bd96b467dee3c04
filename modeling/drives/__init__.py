"""Ready drives: motors on a voltage or a current behind a gear, and drives of two formulas.

In: figures of a motor's data sheet, or expressions. Out: `Drive`.
Knows nothing of axes and of text.
"""

from .ready import (
    DRIVES as DRIVES,
    current_drive as current_drive,
    formula_drive as formula_drive,
    voltage_drive as voltage_drive,
)
