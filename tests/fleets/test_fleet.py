"""A fleet: a result for each log, a reason for each other, none takes another with it.

What a fleet remembers of what was done, and what a result depends on.
"""

import json
import math
import os
import signal
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from fleet_logs import AXIS, TRUTH, write_logs

from axisid import (
    DataError,
    FleetItem,
    Prefilter,
    UsageError,
    build,
    fleet,
    load_axis,
    load_result,
    read_record,
)
from axisid.estimation.monte_carlo import twin_of
from axisid.fleets import Fleet, gather_items, read_ledger
from axisid.fleets.ledger import LEDGER, FleetRow, write_rows
from axisid.fleets.one_log import Settings, log_digest, result_file, row_for
from axisid.fleets.result import columns_of
from axisid.fleets.trend import last_results
from axisid.modeling.declaration import back_and_forth
from axisid.twins import TwinMachines, write_twins
from tests.fleets.logs import CENTRE, identify_or_harm, row_of
from tests.refusals import refuses
from tests.unjudged import identify

FILTER = Prefilter(cutoff=60.0)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two good logs and a corrupt one."""
    folder = tmp_path_factory.mktemp("logs")
    write_logs(folder, 2, cycles=1)
    (folder / "corrupt.npz").write_bytes(b"no archive")
    return folder


@pytest.fixture(scope="module")
def made(logs: Path) -> Fleet:
    return fleet(logs, AXIS, logs / "out", jobs=0, prefilter=FILTER, methods=["idm-ls", "idm-iv"])


@pytest.mark.slow
def test_each_log_has_its_result_or_its_reason(made: Fleet) -> None:
    told = [("axis00000", "ok"), ("axis00001", "ok"), ("corrupt", "failed")]
    assert [(row.name, row.status) for row in made] == told
    assert "cannot be read as a NumPy archive" in made["corrupt"].reason
    assert made["axis00000"].parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.05)


@pytest.mark.slow
def test_a_result_is_that_of_identify_to_the_last_digit(made: Fleet, logs: Path) -> None:
    file = Path(made.folder, "axis00001.json")
    record = read_record(logs / "axis00001.npz", load_axis(AXIS))
    alone = identify(load_axis(AXIS), record, FILTER, ["idm-ls", "idm-iv"])
    assert load_result(file).to_dict() == json.loads(json.dumps(alone.to_dict()))
    assert load_result(file)["idm-iv"].parameters["M"].value == alone["idm-iv"].physical[0]


@pytest.mark.slow
def test_what_was_done_with_the_same_log_axis_and_options_is_left_alone(
    made: Fleet, logs: Path
) -> None:
    def again(**how: Any) -> Fleet:
        given = {"prefilter": FILTER, "methods": ["idm-ls", "idm-iv"], **how}
        return fleet(logs, AXIS, logs / "out", jobs=0, resume=True, **given)

    file = Path(made.folder, "axis00000.json")
    before = file.stat().st_mtime_ns
    assert again().counts == {"ok": 0, "skipped": 2, "failed": 1}
    assert file.stat().st_mtime_ns == before
    assert again()["axis00000"].parameters == made["axis00000"].parameters
    assert again(methods=["idm-ls"]).counts["ok"] == 2


@pytest.mark.parametrize("ending", ["parquet", "csv", "npz"])
def test_the_table_has_a_row_for_each_log(made: Fleet, tmp_path: Path, ending: str) -> None:
    import pandas as pd

    read = {"parquet": pd.read_parquet, "csv": pd.read_csv, "npz": np.load}[ending]
    columns = read(made.write(tmp_path / f"table.{ending}"))
    assert list(columns["name"]) == ["axis00000", "axis00001", "corrupt"]
    assert list(columns["status"]) == ["ok", "ok", "failed"]
    assert (
        float(columns["M [kg]" if ending == "csv" else "M"][1])
        == made["axis00001"].parameters["M"].value
    )


def test_columns_tell_their_units(made: Fleet, tmp_path: Path) -> None:
    from pyarrow import parquet

    schema = parquet.read_schema(made.write(tmp_path / "table.parquet"))
    told = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}
    assert (told["M"], told["Fv.sd"], told["Fc.low"]) == ("kg", "N/(m/s)", "N")
    heads = made.write(tmp_path / "table.csv").read_text().split("\n", 1)[0]
    assert "M [kg],M.sd [kg],M.low [kg],M.high [kg],Fv [N/(m/s)]" in heads
    with np.load(made.write(tmp_path / "table.npz")) as arrays:
        assert json.loads(str(arrays["axisid.units"]))["Fc.high"] == "N"


def test_what_is_no_file_is_told_beside_others_and_not_waited_for(
    logs: Path, tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "all.csv").write_text("log\npipe.csv\n/dev/zero\n", encoding="utf-8")
    given = [tmp_path / "pipe.csv", tmp_path / "all.csv", logs / "corrupt.npz"]
    for some in (given[:1], given[1:]):
        made = fleet(some, AXIS, tmp_path / "out", jobs=0)
        assert made.counts["failed"] == len(made)
        assert "not a regular file" in next(iter(made)).reason
    log = str(logs / "corrupt.npz")
    made = fleet([FleetItem(log=log), FleetItem(log=log, axis=AXIS)], out=tmp_path, jobs=0)
    assert [row.code for row in made] == ["fleet", "log-file"]


@pytest.mark.slow
def test_logs_of_several_axes_are_held_against_those_of_their_own(tmp_path: Path) -> None:
    moves = back_and_forth(speeds=(0.05, 0.1), acceleration=0.75, seconds=0.3)
    items = []
    for name in ("emps2015", "emps"):
        axis = twin_of(build(load_axis(name)), {}, moves)
        manifest = write_twins(TwinMachines(axis=axis), tmp_path / name, axis=name)
        items += gather_items(manifest, tmp_path / "out")
    made = fleet(items, out=tmp_path / "out", jobs=0, methods=["idm-ls"])
    groups = [(group.axis, len(group.names)) for group in made.groups]
    assert groups == [("emps2015", 3), ("emps", 4)]
    assert columns_of(made.rows, ())[0]["tau0"][0] is None


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"jobs": -1}, "jobs is -1"),
        ({"time_limit": 0.0}, "the time limit is 0.0"),
        ({"time_limit": float("inf")}, "the time limit is inf"),
        ({"time_limit": 1.0, "executor": ThreadPoolExecutor(1)}, "cannot be combined"),
        ({"known": {"m": [1.0]}}, "known applies to several records"),
    ],
)
def test_wrong_options_are_refused(logs: Path, how: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        fleet(logs, AXIS, logs / "refused", **how)


@pytest.mark.slow
def test_a_result_that_cannot_be_written_is_told_and_done_again_as_the_fleet_resumes(
    logs: Path, tmp_path: Path
) -> None:
    log, out = logs / "axis00000.npz", tmp_path / "out"
    taken = out / "axis00000.json"
    taken.mkdir(parents=True)
    arguments: dict[str, Any] = {"jobs": 0, "prefilter": FILTER, "methods": ["idm-ls"]}
    (row,) = fleet(log, AXIS, out, **arguments)
    assert (row.status, row.code) == ("failed", "file")
    assert "cannot be written" in row.reason
    taken.rmdir()
    assert fleet(log, AXIS, out, resume=True, **arguments).counts["ok"] == 1


@pytest.fixture(scope="module")
def many(tmp_path_factory: pytest.TempPathFactory) -> Path:
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


@pytest.mark.slow
def test_hanging_and_killing_logs_are_named_and_the_others_are_done(
    many: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[fleet.__module__], "identify_log", identify_or_harm)
    names = ("good", "hanging", "killing", "unlucky", "other")
    for name in names:
        (tmp_path / f"{name}.npz").write_bytes((many / "axis00000.npz").read_bytes())
    items = [FleetItem(log=str(tmp_path / f"{name}.npz"), serial=name) for name in names]
    made = fleet(items, AXIS, tmp_path / "out", jobs=2, time_limit=20.0, methods=["idm-ls"])
    assert {row.name: row.code for row in made.failed} == {"hanging": "time", "killing": "killed"}
    assert made["hanging"].reason == "it did not end within the time limit of 20 s."
    assert made["killing"].reason == "its process was killed 2 times (SIGKILL)."
    again = fleet(
        items[:1] + items[3:], AXIS, tmp_path / "out", jobs=2, resume=True, methods=["idm-ls"]
    )
    assert again.counts == {"ok": 0, "skipped": 3, "failed": 0}


@pytest.mark.filterwarnings("default")  # of Dask, as its worker is killed
@pytest.mark.slow
def test_dask_loses_nothing_when_a_worker_is_killed(many: Path, tmp_path: Path) -> None:
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
        made = fleet(many, AXIS, tmp_path, executor=executor, methods=["idm-ls"], progress=progress)
    assert made.counts == {"ok": 15, "skipped": 0, "failed": 1}
    assert len(list(tmp_path.glob("axis*.json"))) == 15


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Logs, of which those that are empty fail."""

    def identified(settings: Settings, item: FleetItem) -> FleetRow:
        log = Path(item.log)
        if not log.read_text():
            return row_for(item, status="failed", reason="empty.")
        result_file(settings.folder, item.name).write_text("{}")
        key = settings.key(item, log_digest(log))
        return row_for(item, axis="emps2015", status="ok", key=key)

    monkeypatch.setattr(sys.modules[fleet.__module__], "identify_log", identified)
    (tmp_path / "out").mkdir()
    for name in ("x", "y"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.csv").write_text(name)
    return tmp_path


def run(place: Path, *names: str, serial: str = "", resume: bool = True) -> Fleet:
    items = [FleetItem(log=str(place / name / "a.csv"), serial=serial) for name in names]
    return fleet(items, "emps2015", place / "out", jobs=0, native=False, resume=resume)


def test_what_is_put_right_of_a_log_that_is_done_goes_into_the_ledger(place: Path) -> None:
    run(place, "x")
    assert run(place, "x", serial="17")["a"].status == "skipped"
    row = read_ledger(place / "out").last["a"]
    assert (row.serial, row.status) == ("17", "ok")


@pytest.mark.parametrize("resume", [True, False])
def test_the_result_of_a_log_that_fails_now_is_kept_and_counts_again_later(
    place: Path, resume: bool
) -> None:
    run(place, "x")
    (place / "x" / "a.csv").rename(place / "x" / "away.csv")  # as a share that is not mounted
    again = run(place, "x", resume=resume)
    assert again["a"].status == "failed"
    assert len(again.notes) == 1
    assert (place / "out" / "a.json").read_text() == "{}"
    ledger = read_ledger(place / "out")
    assert (ledger.last["a"].status, ledger.results["a"].status) == ("failed", "ok")
    (place / "x" / "away.csv").rename(place / "x" / "a.csv")
    assert run(place, "x")["a"].status == "skipped"
    assert read_ledger(place / "out").last["a"].status == "ok"


def test_a_fleet_keeps_the_lines_of_logs_that_it_does_not_identify(place: Path) -> None:
    (place / "y" / "a.csv").rename(place / "y" / "b.csv")
    items = [FleetItem(log=str(place / "y" / "b.csv"))]
    run(place, "x")
    fleet(items, "emps2015", place / "out", jobs=0, native=False)
    assert [*read_ledger(place / "out").results] == ["a", "b"]


def test_a_result_never_replaces_its_log(place: Path) -> None:
    log = place / "out" / "a.json"
    log.write_text('{"t": [0, 1]}')
    with refuses("fleet"):
        fleet(log, "emps2015", place / "out", jobs=0, native=False)
    assert log.read_text() == '{"t": [0, 1]}'


def _append_rows(folder: Path, name: str) -> None:
    for number in range(40):
        write_rows(folder, [row_of(f"{name}{number}", CENTRE)])


def test_two_processes_that_write_a_ledger_lose_no_line(tmp_path: Path) -> None:
    context = get_context("fork")
    both = [context.Process(target=_append_rows, args=(tmp_path, name)) for name in ("a", "b")]
    for each in both:
        each.start()
    for each in both:
        each.join()
    ledger = read_ledger(tmp_path)
    assert (len(ledger.last), ledger.broken) == (80, "")


@pytest.mark.parametrize(
    "left", ['{"axis": "emps2015", "digest": "of other words"}', "", "{", "[]"]
)
def test_a_result_that_was_changed_or_is_broken_is_made_again(place: Path, left: str) -> None:
    run(place, "x")
    result = place / "out" / "a.json"
    result.write_text(left)
    assert [run(place, "x")["a"].status for _ in range(2)] == ["ok", "skipped"]
    assert result.read_text() == "{}"


def test_a_run_file_that_is_wrong_is_told_and_not_left_out(place: Path) -> None:
    run_file = place / "x" / "run.toml"
    run_file.write_text('log = "a.csv\n')
    assert str(run_file) in [item.log for item in gather_items(place / "x", place / "out")]


def test_a_trend_takes_the_last_row_of_each_log_and_machine() -> None:
    told = [("a", "x", "ok"), ("b", "y", "ok"), ("a-1", "x", "ok"), ("b", "y", "failed")]
    rows = [FleetRow(name=n, log=log, axis="s", status=s) for n, log, s in told]  # type: ignore[arg-type]
    two = [msgspec.structs.replace(rows[0], name=n, columns={"position": n}) for n in ("p", "q")]
    assert last_results([*rows, *two]) == {"a-1", "b", "p", "q"}


def test_lines_that_are_broken_are_told_and_their_logs_made_again(place: Path) -> None:
    run(place, "x", "y")
    ledger = place / "out" / "fleet.jsonl"
    first, second = ledger.read_text().splitlines()
    ledger.write_text(f"{first}\n{second[:40]}\n")
    again = run(place, "x", "y")
    assert sorted(row.status for row in again) == ["ok", "skipped"]
    assert "1 line of" in again.notes[0]
    assert again.notes[0] in " ".join(again.summary().split())


DECLARED = (
    "from dataclasses import replace\nfrom axisid import load_axis\naxis = load_axis('emps2015')\n"
)


def test_an_axis_file_that_changes_while_the_process_lives_is_read_anew(tmp_path: Path) -> None:
    file, item = tmp_path / "own.py", FleetItem(log="a.csv")
    settings = Settings(folder=str(tmp_path), axis=str(file), native=False)
    file.write_text(DECLARED)
    before = settings.key(item, "")
    file.write_text(f"{DECLARED}axis = replace(axis, name='other')\n")
    assert settings.built(item)[0].axis.name == "other"
    assert len({before, *(replace(settings, native=n).key(item, "") for n in (False, True))}) == 3


def test_rows_are_read_in_the_order_of_their_last_lines_finite_or_not(tmp_path: Path) -> None:
    odd = msgspec.structs.replace(
        row_of("odd", np.array([np.nan, 200.0, 20.0])), conditions={"room": math.nan}
    )
    write_rows(tmp_path, [row_of("a", CENTRE), odd, row_of("a", CENTRE + 1.0)])
    with (tmp_path / LEDGER).open("ab") as ledger:
        ledger.write(b'{"schema": "axisid.fle')  # cut off
    rows = read_ledger(tmp_path).last
    assert read_ledger(tmp_path).broken.endswith("(line 4)")
    assert list(rows) == ["odd", "a"]
    assert math.isnan(rows["odd"].parameters["M"].value)
    assert rows["odd"].conditions == {"room": None}
    assert rows["a"].parameters["M"].value == CENTRE[0] + 1.0
    (tmp_path / LEDGER).write_text('{"schema": "axisid.fleet/1", "name": null}\n')
    with pytest.raises(DataError, match="line 1 is not a row of a fleet"):
        read_ledger(tmp_path)


def test_a_ledger_goes_on_without_empty_lines_also_after_one_that_was_cut_off(
    tmp_path: Path,
) -> None:
    for content in (b"", b"{}\n", b'{"a'):
        (tmp_path / LEDGER).write_bytes(content)
        write_rows(tmp_path, [row_of("a", CENTRE)])
        lines = (tmp_path / LEDGER).read_bytes().splitlines()
        assert b"" not in lines
        assert lines[-1].startswith(b'{"schema"')


@pytest.mark.skipif(sys.platform == "win32", reason="a limit of files")
@pytest.mark.parametrize("before", [None, b"", b'{"a'])
def test_a_row_without_room_is_refused_by_the_ledgers_name_and_leaves_nothing(
    tmp_path: Path, before: bytes | None
) -> None:
    import resource

    place = tmp_path / LEDGER
    if before is not None:
        place.write_bytes(before)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        with pytest.raises(UsageError, match=LEDGER):
            write_rows(tmp_path, [row_of("a", CENTRE)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    left = [file for file in tmp_path.iterdir() if not file.name.startswith(".")]
    assert [file.read_bytes() for file in left] == [before][before is None :]
