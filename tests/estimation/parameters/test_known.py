"""What is known of each record, from Python and from texts."""

import pytest

from axisid import UsageError
from axisid.estimation.parameters.known import known_of, read_known
from tests.refusals import refuses


def test_a_text_lists_a_value_for_each_record_some_with_deviations() -> None:
    found = read_known(["m_add=0,20+-0.01", "kp= 160 , 2.4e2"])
    assert found == {"m_add": ((0.0, 0.0), (20.0, 0.01)), "kp": ((160.0, 0.0), (240.0, 0.0))}
    (payload, _) = known_of(found, 2)
    assert payload.values == (0.0, 20.0)
    assert payload.deviations == (0.0, 0.01)
    assert payload.differs
    assert payload.doubtful == ((20.0, 0.01),)
    assert payload.text(1) == "20 +- 0.01"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("m_add", "write NAME=V1,V2"),
        ("m_add=", "number 1 is no value"),
        ("m_add=0,x", "number 2 is no value"),
        ("m_add=0,1+-", "number 2 is no value"),
    ],
)
def test_a_text_that_lists_no_values_is_refused_with_its_place(text: str, said: str) -> None:
    with refuses("known-text", said):
        read_known([text])


def test_a_name_is_known_once() -> None:
    with refuses("known-twice"):
        read_known(["m=1,2", "m=3,4"])


@pytest.mark.parametrize("told", [[0.0], [0.0, 1.0, 2.0], [0.0, (1.0, -1.0)], [0.0, (1, 2, 3)]])
def test_values_that_are_not_one_for_each_record_are_refused(told: object) -> None:
    with pytest.raises(UsageError, match="give"):
        known_of({"m": told}, 2)  # type: ignore[dict-item]


def test_equal_values_with_equal_deviations_are_one_thing() -> None:
    (found,) = known_of({"m": [0.0, (20.0, 0.1), (20.0, 0.1), (20.0, 0.2)]}, 4)
    assert found.doubtful == ((20.0, 0.1), (20.0, 0.2))


def test_what_is_not_given_by_name_is_refused() -> None:
    with refuses("known-not-by-name", "give values by name"):
        known_of([1.0, 2.0], 2)  # type: ignore[arg-type]
