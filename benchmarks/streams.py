"""What a log that is larger than memory costs: samples a second, and memory, by its length.

A log of the EMPS axis is written to a Parquet file and identified from it in blocks, by least
squares and by instruments, each in a process of its own, whose greatest memory is taken. Loop and
noise repeat after twenty seconds, so that the file is small; reading it unfolds every sample.
With ``--whole`` logs are read as a whole, identified by both methods and judged.

    python benchmarks/streams.py                              a table of 10^5 to 10^7 samples
    python benchmarks/streams.py --samples 100000000          another length
    python benchmarks/streams.py --whole                      2 x 10^3 to 2 x 10^6 samples
    python benchmarks/streams.py --json -                     one JSON object, of the longest
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
from axisid.codegen import GeneratedAxis
from axisid.estimation import LogBlocks, identify_stream

PERIOD, TURN = 1e-3, 20_000  # s, and samples after which the log repeats
GROUP = 1_000_000  # rows of the file that are packed together
LENGTHS = (100_000, 1_000_000, 10_000_000)
METHODS = ("idm-ls", "idm-iv")
WHOLE = "whole"  # in place of a method: both of them and the checks, of the log in memory
#: Threads that wait for one another take CPU time too, the more the busier the machine is.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
WHOLE_LENGTHS = (2_000, 20_000, 200_000, 2_000_000)
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


def identified(file: Path, method: str) -> dict[str, float]:
    """Identify a log, in this process."""
    axis = build(load_axis("emps2015"))
    if method == WHOLE:
        identify(axis, twin_record(axis)).to_dict()  # what is done once in a process
    begin = time.process_time()
    samples, mass = (_whole if method == WHOLE else _streamed)(file, axis, method)
    seconds = time.process_time() - begin
    return {
        "samples": samples,
        "seconds": seconds,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "M": mass,
    }


def _streamed(file: Path, axis: GeneratedAxis, method: str) -> tuple[int, float]:
    blocks = LogBlocks(file=file, axis=axis, columns=COLUMNS)
    found = identify_stream(axis, blocks, method=method, sample_period=PERIOD)
    return found.samples, found.parameters["M"].value


def _whole(file: Path, axis: GeneratedAxis, _: str) -> tuple[int, float]:
    record = read_record(file, axis, columns=COLUMNS, sample_period=PERIOD)
    found = identify(axis, record, methods=METHODS)
    found.to_dict()  # with its verdict
    return len(record), found.preferred.parameters["M"].value


def measured(lengths: Sequence[int] = LENGTHS, method: str = "idm-iv") -> list[dict[str, Any]]:
    """What logs of these lengths cost, each in a process of its own."""
    rows = []
    for samples in lengths:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "log.parquet"
            write_log(file, samples)
            command = [sys.executable, __file__, "--one", str(file), method]
            env = os.environ | ONE_THREAD
            done = subprocess.run(command, check=True, capture_output=True, text=True, env=env)
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


def lines(lengths: Sequence[int], methods: Sequence[str]) -> Iterator[str]:
    """A table of each method."""
    names = ("samples", "method", "CPU s", "us/sample", "peak MB", "file MB")
    yield "{:>12} {:>8} {:>8} {:>10} {:>8} {:>8}".format(*names)
    for method in methods:
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
    parser.add_argument("--samples", type=int, nargs="+", help="of the logs")
    parser.add_argument("--whole", action="store_true", help="read and judged as a whole")
    given = parser.parse_args()
    lengths = given.samples or list(WHOLE_LENGTHS if given.whole else LENGTHS)
    methods = (WHOLE,) if given.whole else METHODS
    found = figures(max(lengths)) if given.json else {}
    give(found, given.json, lines(lengths, methods))
