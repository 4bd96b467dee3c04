"""A law along many evaluations is run in pieces, each from where the one before it ended."""

import numpy as np
import pytest

from axisid import Record
from axisid.codegen import GeneratedAxis
from axisid.estimation.loops import law_run, law_ticks, state_at_rest


def test_law_in_pieces_gives_the_terms_of_the_whole(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    ticks = law_ticks(emps2015, twin, (0, len(twin)))
    start = state_at_rest(emps2015, ticks)
    whole = law_run.terms_along(emps2015, ticks, start)
    monkeypatch.setattr(law_run, "_EVALUATIONS", 3000)
    assert np.array_equal(law_run.terms_along(emps2015, ticks, start), whole)
