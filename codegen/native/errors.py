"""Why there is no native code."""


class NativeUnavailableError(Exception):
    """Native code cannot be had; the message says why, and the virtual machine serves instead."""


class CompilerHangsError(NativeUnavailableError):
    """The compiler did not finish in time; trying elsewhere would take as long again."""


class WrongLibraryError(NativeUnavailableError):
    """The library crashes, hangs or computes wrong values, and would wherever it is built."""
