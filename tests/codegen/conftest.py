"""A fixture shared by tests of compiled code."""

import pytest

from axisid.codegen.runtime.library_cache import Compiler, NativeUnavailableError, find_compiler


@pytest.fixture(scope="session")
def c_compiler() -> Compiler:
    """What needs a C compiler is skipped where there is none."""
    try:
        return find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
