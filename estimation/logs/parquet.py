"""Reading of Parquet files with pyarrow."""

import io
from pathlib import Path

from axisid.estimation.raw_tables import Table, TableBuilder, split_labels
from axisid.support.libraries import library, refusing
from axisid.support.memory import Room


def read_parquet(file: Path, content: bytes, room: Room) -> Table:
    """Return the table of a Parquet file.

    The unit of a column is in the metadata of its field, or in its name.

    Raises
    ------
    DataError
        The file is damaged, needs more memory than is available, or pyarrow is not installed.
    """
    arrow, parquet = (library(name, "parquet", file) for name in ("pyarrow", "pyarrow.parquet"))
    batches = []
    with (
        refusing(f"{file} cannot be read as a Parquet file. Write the file again. The error is"),
        parquet.ParquetFile(io.BytesIO(content)) as opened,
    ):
        for batch in opened.iter_batches():
            room.take(2 * batch.nbytes)  # memory of the batch, and of the joined columns
            batches.append(batch)
        table = arrow.Table.from_batches(batches, opened.schema_arrow).flatten()
    builder = TableBuilder(room=room)
    split = split_labels(table.schema.names)
    for field, values, (name, unit) in zip(table.schema, table.columns, split, strict=True):
        metadata = {**(field.metadata or {})}
        unit_text = (
            metadata.get(b"unit")
            or metadata.get(b"units")
            or metadata.get(b"Unit")
            or unit.encode()
        )
        builder.add(
            name, values.to_numpy(), unit=unit_text.decode(errors="replace"), label=field.name
        )
    return builder.table(str(file))
