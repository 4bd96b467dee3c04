"""Which column of a log is the motion's own: its clock is the record's."""

from collections.abc import Container

#: What an axis may be identified from, the first that is there.
MOTION_ROLES = ("position", "velocity")


def motion_role(roles: Container[str]) -> str:
    """The position, or the velocity of a log without one."""
    return next((role for role in MOTION_ROLES if role in roles), MOTION_ROLES[0])
