"""What many identifications cost: fleets of logs, and a cluster's share of it.

A fleet of short twins with three corrupt logs, of whose workers one is killed in the middle: what
each log costs with its diagnosis, what resuming costs, and how often right and wrong machines are
told. Then what Dask adds to a task, on a cluster of this machine, what an identification costs
alone and among lanes, and what a long log costs.

    python benchmarks/scale.py                  a table
    python benchmarks/scale.py --json -         one JSON object
    python benchmarks/scale.py --only fleet --logs 1000 --cycles 1 --jobs 2
"""

import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from figures import give, parser_of
from fleet_logs import AXIS, write_logs
from lanes import measure as lane_figures
from long_logs import figures as long_log_figures

from axisid import fleet
from axisid.fleets import Fleet
from axisid.support.jobs.run import run_jobs

CORRUPT = 3
KILLED_AFTER = 0.3  # share of the logs that are done
TASKS = 500
CLUSTER = {
    "n_workers": 2,
    "threads_per_worker": 1,
    "dashboard_address": None,
    "silence_logs": "ERROR",
}

Figures = dict[str, float]


def nothing(number: int) -> int:
    return number


def fleet_figures(
    logs: int, jobs: int, cycles: int = 2, methods: Sequence[str] | None = None
) -> Figures:
    """Cost of a log of so many cycles of 3 s, and what becomes of a fleet with a killed worker."""
    how: dict[str, Any] = {"jobs": jobs, **({"methods": methods} if methods else {})}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_logs(folder, logs, cycles=cycles)
        for number in range(CORRUPT):
            (folder / f"axis{number * logs // CORRUPT:05}.npz").write_bytes(b"no archive")
        begin, killed = time.perf_counter(), threading.Event()

        def progress(done: int, total: int, _: str) -> None:
            if done >= KILLED_AFTER * total and not killed.is_set():
                killed.set()
                _kill_a_worker()

        made = fleet(folder, AXIS, folder / "out", progress=progress, **how)
        wall = time.perf_counter() - begin
        begin = time.perf_counter()
        again = fleet(folder, AXIS, folder / "out", resume=True, **how)
        resumed = time.perf_counter() - begin
        assert again.counts["ok"] == 0, again.counts
        return {"fleet_wall_s": wall, "fleet_resume_s": resumed, **_cost(made, wall, jobs)}


def _cost(made: Fleet, wall: float, jobs: int) -> Figures:
    spent = [row.seconds for row in made if row.status == "ok"]
    return {
        "fleet_logs": float(len(made)),
        "fleet_results": float(made.counts["ok"]),
        "fleet_reasons": float(made.counts["failed"]),
        "fleet_outliers": float(len(made.outliers)),
        "fleet_cpu_s_per_log": float(np.mean(spent)),
        "fleet_logs_per_s_per_core": 1 / float(np.mean(spent)),
        "fleet_wall_logs_per_s_per_job": len(made) / wall / jobs,
    }


def _kill_a_worker() -> None:
    """As the kernel does when memory runs out."""
    import multiprocessing

    os.kill(multiprocessing.active_children()[0].pid or 0, signal.SIGKILL)


def dask_figures(tasks: int) -> Figures:
    """What a task that does nothing takes on a cluster of two workers, and in threads.

    The overhead is CPU time of the process that submits and of the scheduler, which are one here:
    what one core has to do for each task, however busy the machine is.
    """
    from distributed import Client, LocalCluster

    with (
        LocalCluster(**CLUSTER) as cluster,
        Client(cluster) as client,
    ):
        executor = client.get_executor(pure=False)
        list(run_jobs(nothing, range(100), total=100, executor=executor))
        begin, wall = time.process_time(), time.perf_counter()
        list(run_jobs(nothing, range(tasks), total=tasks, executor=executor))
        dask, wall = time.process_time() - begin, time.perf_counter() - wall
    with ThreadPoolExecutor(2) as threads:
        begin = time.process_time()
        list(run_jobs(nothing, range(tasks), total=tasks, executor=threads))
        own = time.process_time() - begin
    return {
        "dask_overhead_ms_per_task": 1e3 * dask / tasks,
        "dask_wall_ms_per_task": 1e3 * wall / tasks,
        "thread_overhead_ms_per_task": 1e3 * own / tasks,
    }


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("--logs", type=int, default=200, help="of the fleet")
    parser.add_argument("--cycles", type=int, default=2, help="of each log, 3 s each")
    parser.add_argument("--method", action="append", help="of each log, in place of the default")
    parser.add_argument("--jobs", type=int, default=2, help="processes of the fleet")
    parser.add_argument("--only", choices=["fleet", "dask", "lanes", "long"], help="one part")
    given = parser.parse_args()
    parts: Mapping[str, Callable[[], Figures]] = {
        "fleet": lambda: fleet_figures(given.logs, given.jobs, given.cycles, given.method),
        "dask": lambda: dask_figures(TASKS),
        "lanes": lane_figures,
        "long": long_log_figures,
    }
    figures: Figures = {}
    for name, measure in parts.items():
        if given.only in (None, name):
            figures |= measure()
    give(figures, given.json, (f"{name:32} {value:12.4g}" for name, value in figures.items()))


if __name__ == "__main__":
    main()
