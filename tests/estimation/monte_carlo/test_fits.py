"""Fits of the output error in a study, beside methods of rows."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from axisid import EstimationError, UsageError, fit, fix, monte_carlo
from axisid.estimation import MonteCarlo
from axisid.estimation.monte_carlo import COLOURED, runs
from axisid.estimation.monte_carlo.plan import twins
from axisid.estimation.records.record import Record
from axisid.modeling.declaration import back_and_forth
from tests.estimation.monte_carlo.short import axis, study

FITS = ("fit:control", "fit:position")
#: Long enough to tell three parameters.
MOVES = back_and_forth(speeds=(0.1, 0.3), acceleration=1.5, seconds=0.3)


@pytest.fixture(scope="module")
def made() -> MonteCarlo:
    return study(3, ("idm-ls", *FITS), moves=MOVES, checks=1)


@pytest.mark.slow
def test_a_run_is_what_fit_makes_of_its_twin(made: MonteCarlo) -> None:
    (_, record), *_ = twins(made.plan, [2])
    assert isinstance(record, Record)
    alone = fit(axis(), record, "position")
    places = [i for i, each in enumerate(made.estimands) if each.method == "fit:position"]
    assert made.values[2, places].tolist() == alone.physical.tolist()
    wanted = [value.interval for value in alone.values.values()]
    np.testing.assert_array_equal(made.intervals(COLOURED)[2, places], wanted)
    iid = made.deviations("iid")[2, places]
    np.testing.assert_allclose(iid, np.sqrt(np.diag(alone.covariances["iid"])))


@pytest.mark.slow
def test_numbers_of_fits_are_the_same_in_any_blocks_threads_and_processes(made: MonteCarlo) -> None:
    how = {"moves": MOVES, "checks": 1}
    with ThreadPoolExecutor(2) as executor:
        assert study(3, ("idm-ls", *FITS), block=1, executor=executor, **how) == made
    assert study(3, ("idm-ls", *FITS), block=2, jobs=2, **how) == made


@pytest.mark.slow
def test_a_value_that_is_known_with_an_error_has_no_coverage_in_fits() -> None:
    known = fix(axis().declared, M=(100.2, 0.5))
    (run,) = {each.runs for each in study(1, "fit:control", moves=MOVES)}
    assert run == 1
    found = monte_carlo(known, 1, "fit:control", moves=MOVES)
    assert all(not each.coverage for each in found)


def test_what_a_fit_refuses_is_a_failure_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise EstimationError("no end.")

    monkeypatch.setattr(runs, "fit", refused)
    found = study(2, ("idm-ls", "fit:control"), moves=MOVES)
    assert found.lost == {"fit:control": {"no end.": 2}}
    assert {found.status(run) for run in range(2)} == {"partly"}
    assert {each.method for each in found} == {"idm-ls"}


def test_fits_of_no_such_output_are_refused() -> None:
    with pytest.raises(UsageError, match="choose from fit:control, fit:position"):
        study(1, "fit:speed")
    with pytest.raises(UsageError, match="there is no fit 'fit:force'"):
        study(1, "fit:force")  # twins log none
