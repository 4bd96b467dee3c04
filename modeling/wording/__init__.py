"""A model in words.

In: `AxisModel`. Out: sections of formulas and sentences.
Knows nothing of a record's numbers.
"""

from .base_parameters import describe_hidden as describe_hidden
from .base_parameters import describe_settled as describe_settled
from .base_parameters import describe_undetermined as describe_undetermined
from .base_parameters import undetermined_names as undetermined_names
from .identifiability import describe_combinations as describe_combinations
from .identifiability import describe_direction as describe_direction
from .identifiability import describe_loss as describe_loss
from .sections import Section as Section
from .sections import derived_sections as derived_sections
