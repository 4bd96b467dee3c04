"""A prefilter is settings: which make sense, and what they are at another period."""

import pytest

from axisid import Prefilter, UsageError


@pytest.mark.parametrize(
    "settings",
    [
        {"cutoff": 0.0},
        {"cutoff": float("nan")},
        {"order": 0},
        {"order": 99},
        {"decimate": 0},
        {"decimation": "octave"},
        {"hold": "foh"},
        {"drop": (-1, 0)},
    ],
)
def test_senseless_settings_are_refused(settings: dict[str, object]) -> None:
    with pytest.raises(UsageError, match=r"give|choose from"):
        Prefilter(**settings)  # type: ignore[arg-type]


def test_prefilter_for_another_period_has_the_same_edges() -> None:
    f = Prefilter(cutoff=30.0, decimate=10, drop=(50, 20))
    assert f.at_period(1e-3, 1.001e-3) is f
    faster = f.at_period(1e-3, 5e-4)
    assert (faster.cutoff, faster.decimate, faster.drop) == (30.0, 20, (100, 40))
    assert Prefilter(decimate=3).at_period(1e-3, 1e-2).decimate == 1
