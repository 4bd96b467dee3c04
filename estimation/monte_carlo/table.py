"""The numbers of a study as a file: NumPy's npz, or Parquet, one row for each run."""

OUTPUT_SUFFIXES = (".npz", ".parquet")


def read_runs() -> None: ...
def write_runs() -> None: ...
