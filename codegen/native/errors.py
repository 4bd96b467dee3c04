"""Why there is no native code."""


class NativeUnavailableError(Exception):
    """Native code cannot be had; the message says why, and the virtual machine serves instead."""
