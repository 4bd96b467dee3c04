"""A model in words.

In: `AxisModel`. Out: sections of formulas and sentences.
Knows nothing of a record's numbers.
"""

from .base_parameters import describe_determined as describe_determined
from .base_parameters import describe_undetermined as describe_undetermined
from .base_parameters import describe_unidentifiable as describe_unidentifiable
from .base_parameters import undetermined_names as undetermined_names
from .identifiability import describe_combinations as describe_combinations
from .identifiability import describe_loss as describe_loss
from .sections import Section as Section
from .sections import derived_sections as derived_sections
