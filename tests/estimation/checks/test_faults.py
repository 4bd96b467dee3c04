"""A check that faults says so in its place, and raises where tracebacks are asked for."""

import pytest

from axisid.estimation.checks import unless_faulty
from axisid.support.errors import EstimationError, Missing


def _raising(error: Exception) -> float:
    raise error


@pytest.fixture
def quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)


@pytest.mark.usefixtures("quiet")
def test_fault_is_said_with_what_it_was() -> None:
    found = unless_faulty(lambda: _raising(ZeroDivisionError("by nothing")))
    assert isinstance(found, Missing)
    assert "could not be made, by a fault" in found.reason
    assert "ZeroDivisionError: by nothing" in found.reason
    assert "please report" in found.reason


@pytest.mark.usefixtures("quiet")
def test_refusal_keeps_its_reason() -> None:
    found = unless_faulty(lambda: _raising(EstimationError("too few rows are left.")))
    assert found == Missing("too few rows are left.")


def test_fault_is_raised_where_tracebacks_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AXISID_DEBUG", "1")
    with pytest.raises(KeyError):
        unless_faulty(lambda: _raising(KeyError("x")))


@pytest.mark.usefixtures("quiet")
def test_want_of_memory_is_no_fault_of_a_check() -> None:
    with pytest.raises(MemoryError):
        unless_faulty(lambda: _raising(MemoryError()))
