"""What is known of each record, as a command line says it."""

import pytest

from axisid.commands.options.estimation_options import read_known
from axisid.estimation.unknowns import known_of
from tests.refusals import refuses


def test_a_text_lists_a_value_for_each_record_some_with_deviations() -> None:
    found = read_known(["m_add=0,20+-0.01", "kp= 160 , 2.4e2"])
    assert found == {"m_add": ((0.0, 0.0), (20.0, 0.01)), "kp": ((160.0, 0.0), (240.0, 0.0))}
    assert known_of(found, 2) == found


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (["m_add"], "Write NAME=V1,V2"),
        (["m_add="], "number 1 is not a number"),
        (["m_add=0,1+-"], "number 2 is not a number"),
    ],
)
def test_what_lists_no_values_is_refused_with_their_place(told: list[str], said: str) -> None:
    with refuses("parameters", said):
        read_known(told)
