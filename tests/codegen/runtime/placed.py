"""A library built before, in the cache of a test's own: compiling is not what it tests."""

import os
import shutil
from pathlib import Path

import pytest

from axisid.codegen.runtime.library_cache import compiled_library

#: The cache of the whole run, as tests replace the variable.
_SHARED = os.environ["AXISID_CACHE"]


def placed_library(text: str, cache: Path) -> Path:
    """Where the library of a C text is in this cache, with its digest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AXISID_CACHE", _SHARED)
        built = compiled_library(text)
    cache.mkdir(mode=0o700, exist_ok=True)
    for file in (built, built.with_suffix(".sha256")):
        shutil.copy2(file, cache)
    return cache / built.name
