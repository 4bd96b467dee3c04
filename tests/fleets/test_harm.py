"""Logs that hang or kill their worker, and workers that are killed: none takes another with it."""

import os
import signal
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from fleet_logs import AXIS, write_logs

from axisid import FleetItem, fleet
from tests.fleets.logs import identify_or_harm

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs")
    write_logs(folder, 16, cycles=1)
    (folder / "axis00003.npz").write_bytes(b"no archive")
    return folder


def killing_at(done: int, kill: Callable[[], None]) -> Callable[[int, int, str], None]:
    """Progress that kills once."""
    left = [kill]

    def progress(so_far: int, _: int, __: str) -> None:
        if so_far >= done and left:
            left.pop()()

    return progress


def test_hanging_and_killing_logs_are_named_and_the_others_are_done(
    logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[fleet.__module__], "identify_log", identify_or_harm)
    names = ("good", "hanging", "killing", "unlucky", "other")
    for name in names:
        (tmp_path / f"{name}.npz").write_bytes((logs / "axis00000.npz").read_bytes())
    items = [FleetItem(log=str(tmp_path / f"{name}.npz"), serial=name) for name in names]
    made = fleet(items, AXIS, tmp_path / "out", jobs=2, time_limit=8.0, methods=["idm-ls"])
    assert {row.name: row.code for row in made.failed} == {"hanging": "time", "killing": "killed"}
    assert made["hanging"].reason == "it did not end within the time limit of 8 s."
    assert made["killing"].reason == "its worker was killed (SIGKILL), 2 times."
    again = fleet(
        items[:1] + items[3:], AXIS, tmp_path / "out", jobs=2, resume=True, methods=["idm-ls"]
    )
    assert again.counts == {"ok": 0, "skipped": 3, "failed": 0}


def test_a_killed_worker_costs_no_log(logs: Path, tmp_path: Path) -> None:
    import multiprocessing

    def kill() -> None:
        os.kill(multiprocessing.active_children()[0].pid or 0, signal.SIGKILL)

    made = fleet(logs, AXIS, tmp_path, jobs=2, methods=["idm-ls"], progress=killing_at(4, kill))
    assert made.counts == {"ok": 15, "skipped": 0, "failed": 1}
    assert made["axis00003"].code != "killed"
    again = fleet(logs, AXIS, tmp_path, jobs=2, methods=["idm-ls"], resume=True)
    assert again.counts == {"ok": 0, "skipped": 15, "failed": 1}


@pytest.mark.filterwarnings("default")  # of Dask, as its worker is killed
def test_dask_loses_nothing_when_a_worker_is_killed(logs: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        workers = list(client.run(os.getpid).values())
        progress = killing_at(4, partial(os.kill, workers[0], signal.SIGKILL))
        executor = client.get_executor(pure=False)
        made = fleet(logs, AXIS, tmp_path, executor=executor, methods=["idm-ls"], progress=progress)
    assert made.counts == {"ok": 15, "skipped": 0, "failed": 1}
    assert len(list(tmp_path.glob("axis*.json"))) == 15
