"""Assignment of columns to the roles of a record, in SI.

In: the columns of a `Table`, and names and units given by a user or declared by an axis. Out:
columns by role, in SI. Knows nothing of clocks and of faulty values.
"""

from .log_writer import log_content as log_content
from .roles import (
    Mask as Mask,
    RoleColumns as RoleColumns,
    motion_role as motion_role,
    role_columns as role_columns,
)
from .units import (
    Scale as Scale,
    expected_units as expected_units,
    likely_unit as likely_unit,
    to_si as to_si,
)
