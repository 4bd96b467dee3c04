"""What a long log costs: processor time and greatest memory, by its length.

A log of the EMPS axis is written to a Parquet file, read, identified by least squares and by
instruments, and judged, in a process of its own. Loop and noise repeat after twenty seconds, so
that the file is small; reading it unfolds every sample.

    python benchmarks/long_logs.py                      2 x 10^3 to 2 x 10^6 samples
    python benchmarks/long_logs.py --samples 500000     another length
    python benchmarks/long_logs.py --json -             one JSON object, of the longest
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from figures import give, parser_of

from axisid import build, identify, load_axis, read_record, simulate, twin_record

PERIOD, TURN = 1e-3, 20_000  # s, and samples after which the log repeats
GROUP = 1_000_000  # rows of the file that are packed together
LENGTHS = (2_000, 20_000, 200_000, 2_000_000)
#: Threads that wait for one another take CPU time too, the more the busier the machine is.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
COLUMNS = {"position": "q", "reference": "r", "control": "u"}


def write_log(file: Path, samples: int) -> None:
    """Write a log of so many samples; nothing of it stays in memory."""
    import pyarrow as pa
    from pyarrow import parquet

    axis, rng = build(load_axis("emps2015")), np.random.default_rng(1)
    phase = 2 * np.pi * np.arange(2 * TURN) / TURN
    reference = 0.1 * np.sin(6 * phase) + 0.04 * np.sin(17 * phase + 1)
    noise = np.tile(1e-6 * rng.standard_normal(TURN), 2)
    loop = simulate(axis, axis.nominal, reference, PERIOD, position_noise=noise)
    columns = {
        "q": loop.measured_position,
        "r": reference,
        "u": loop.control,
    }
    with parquet.ParquetWriter(
        file, pa.schema([(name, pa.float64()) for name in columns]), compression="zstd"
    ) as writer:
        for first in range(0, samples, GROUP):
            rows = np.arange(first, min(first + GROUP, samples))
            rows = np.where(rows < TURN, rows, TURN + rows % TURN)  # settled after the first turn
            writer.write_table(pa.table({name: v[rows] for name, v in columns.items()}))


def identified(file: Path) -> dict[str, float]:
    """Identify a log, in this process."""
    axis = build(load_axis("emps2015"))
    identify(axis, twin_record(axis)).to_dict()  # what is done once in a process
    begin = time.process_time()
    record = read_record(file, axis, columns=COLUMNS, sample_period=PERIOD)
    found = identify(axis, record, methods=("idm-ls", "idm-iv"))
    found.to_dict()  # with its verdict
    return {
        "samples": len(record),
        "seconds": time.process_time() - begin,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "M": found.preferred.parameters["M"].value,
    }


def measured(lengths: Sequence[int] = LENGTHS) -> list[dict[str, Any]]:
    """What logs of these lengths cost, each in a process of its own."""
    rows = []
    for samples in lengths:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "log.parquet"
            write_log(file, samples)
            command = [sys.executable, __file__, "--one", str(file)]
            env = os.environ | ONE_THREAD
            done = subprocess.run(command, check=True, capture_output=True, text=True, env=env)
            rows.append(json.loads(done.stdout) | {"file_mb": file.stat().st_size / 1e6})
    return rows


def figures(samples: int = LENGTHS[-1]) -> dict[str, float]:
    """`long_log_msamples_per_s`, of CPU time, and `peak_mb_long_log`."""
    (row,) = measured([samples])
    return {
        "long_log_samples": row["samples"],
        "long_log_msamples_per_s": row["samples"] / row["seconds"] / 1e6,
        "peak_mb_long_log": row["peak_mb"],
    }


def lines(lengths: Sequence[int]) -> Iterator[str]:
    """A table of each length."""
    names = ("samples", "CPU s", "us/sample", "peak MB", "file MB")
    yield "{:>12} {:>8} {:>10} {:>8} {:>8}".format(*names)
    for row in measured(lengths):
        yield (
            f"{row['samples']:>12} {row['seconds']:>8.2f} "
            f"{1e6 * row['seconds'] / row['samples']:>10.3f} "
            f"{row['peak_mb']:>8.0f} {row['file_mb']:>8.1f}"
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(identified(Path(sys.argv[2]))))
        raise SystemExit
    parser = parser_of(__doc__)
    parser.add_argument("--samples", type=int, nargs="+", help="of the logs")
    given = parser.parse_args()
    lengths = given.samples or list(LENGTHS)
    found = figures(max(lengths)) if given.json else {}
    give(found, given.json, lines(lengths))
