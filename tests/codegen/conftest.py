"""A fixture shared by tests of compiled code."""

import pytest

from axisid.codegen.native.compiler import Compiler, find_compiler
from axisid.codegen.native.errors import NativeUnavailableError


@pytest.fixture(scope="session")
def c_compiler() -> Compiler:
    """What needs a C compiler is skipped where there is none."""
    try:
        return find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
