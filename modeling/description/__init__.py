"""A model in words.

In: `AxisModel`. Out: sections of formulas and sentences.
Knows nothing of a record's numbers.
"""

from .identifiability import (
    describe_combinations as describe_combinations,
    describe_determined as describe_determined,
    describe_loss as describe_loss,
    describe_undetermined as describe_undetermined,
    describe_unidentifiable as describe_unidentifiable,
    undetermined_names as undetermined_names,
)
from .sections import Section as Section, derived_sections as derived_sections
