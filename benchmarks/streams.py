"""What a log that is larger than memory costs: samples a second, and memory, by its length.

A log of the EMPS axis is written to a Parquet file and identified from it in blocks, by least
squares and by instruments, each in a process of its own, whose greatest memory is taken. Loop and
noise repeat after twenty seconds, so that the file is small; reading it unfolds every sample.

    python benchmarks/streams.py                              a table of 10^5 to 10^7 samples
    python benchmarks/streams.py --samples 100000000          another length
    python benchmarks/streams.py --json -                     one JSON object, of the longest
"""

import json
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

from axisid import build, load_axis, simulate
from axisid.estimation import LogBlocks, identify_stream

PERIOD, TURN = 1e-3, 20_000  # s, and samples after which the log repeats
GROUP = 1_000_000  # rows of the file that are packed together
LENGTHS = (100_000, 1_000_000, 10_000_000)
METHODS = ("idm-ls", "idm-iv")


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


def identified(file: Path, method: str) -> dict[str, float]:
    """Identify a log, in this process."""
    axis = build(load_axis("emps2015"))
    columns = {"position": "q", "reference": "r", "control": "u"}
    blocks = LogBlocks(file=file, axis=axis, columns=columns)
    begin = time.process_time()
    found = identify_stream(axis, blocks, method=method, sample_period=PERIOD)
    seconds = time.process_time() - begin
    return {
        "samples": found.samples,
        "seconds": seconds,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "M": found.parameters["M"].value,
    }


def measured(lengths: Sequence[int] = LENGTHS, method: str = "idm-iv") -> list[dict[str, Any]]:
    """What logs of these lengths cost, each in a process of its own."""
    rows = []
    for samples in lengths:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "log.parquet"
            write_log(file, samples)
            command = [sys.executable, __file__, "--one", str(file), method]
            done = subprocess.run(command, check=True, capture_output=True, text=True)
            rows.append(json.loads(done.stdout) | {"file_mb": file.stat().st_size / 1e6})
    return rows


def figures(samples: int = LENGTHS[-1]) -> dict[str, float]:
    """`stream_msamples_per_s`, of CPU time and all passes, and `peak_mb_stream`."""
    (row,) = measured([samples])
    return {
        "stream_samples": row["samples"],
        "stream_msamples_per_s": row["samples"] / row["seconds"] / 1e6,
        "peak_mb_stream": row["peak_mb"],
    }


def lines(lengths: Sequence[int]) -> Iterator[str]:
    """A table of both methods."""
    names = ("samples", "method", "CPU s", "us/sample", "peak MB", "file MB")
    yield "{:>12} {:>8} {:>8} {:>10} {:>8} {:>8}".format(*names)
    for method in METHODS:
        for row in measured(lengths, method):
            each = 1e6 * row["seconds"] / row["samples"]
            yield (
                f"{row['samples']:>12} {method:>8} {row['seconds']:>8.2f} {each:>10.3f} "
                f"{row['peak_mb']:>8.0f} {row['file_mb']:>8.1f}"
            )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(identified(Path(sys.argv[2]), sys.argv[3])))
        raise SystemExit
    parser = parser_of(__doc__)
    parser.add_argument("--samples", type=int, nargs="+", default=list(LENGTHS))
    given = parser.parse_args()
    wanted = given.samples if not given.json else []
    give(figures(max(given.samples)) if given.json else {}, given.json, lines(wanted))
