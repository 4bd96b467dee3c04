"""A fleet that was identified."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Checked
from axisid.presentation.blocks import Document, plain_text
from axisid.presentation.html import blocks_html
from axisid.support.errors import UsageError
from axisid.support.user_values import first_of, is_among, quoted

from .document import fleet_document
from .outliers import AxisGroup, Outlier, groups_of
from .row import FleetRow, counts_of
from .table import write_table


@dataclass(frozen=True, kw_only=True)
class Fleet(Checked):
    """What became of the logs of a fleet.

    Attributes
    ----------
    folder : str
        Of the results.
    rows : tuple of FleetRow
        In the order in which the logs were named.
    notes : tuple of str
        What is said of the folder: lines that cannot be read, results of other logs.
    """

    folder: str
    rows: tuple[FleetRow, ...]
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[FleetRow]:
        return iter(self.rows)

    def __getitem__(self, name: str) -> FleetRow:
        """A row by the name of its result."""
        found = {row.name: row for row in self.rows}
        if not is_among(name, found):
            raise UsageError(
                f"the fleet has no log {quoted(name)}; name one of {first_of(list(found))}, or "
                "take one of fleet.rows by its place.",
                code="not-in-fleet",
            )
        return found[name]

    def __str__(self) -> str:
        return self.summary()

    @property
    def counts(self) -> dict[str, int]:
        """How many logs there are of each status."""
        return counts_of(self.rows)

    @property
    def failed(self) -> tuple[FleetRow, ...]:
        """The rows without a result, each with its reason."""
        return tuple(row for row in self.rows if not row.has_result)

    @cached_property
    def groups(self) -> tuple[AxisGroup, ...]:
        """The logs with a result by axis, with what is usual among them."""
        return groups_of(self.rows)

    @property
    def outliers(self) -> tuple[Outlier, ...]:
        """The logs whose parameters are not those of the others, the furthest first."""
        found = (each for group in self.groups for each in group.outliers)
        return tuple(sorted(found, key=lambda each: each.p_value))

    @property
    def checks(self) -> tuple[Check, ...]:
        """What fails in any log, of how many, and whether any stands out; a row has its own."""
        found = dict.fromkeys(check.name for row in self.rows for check in row.checks)
        by_name = {n: [r.name for r in self.rows if n in (c.name for c in r.checks)] for n in found}
        out = first_of([each.name for each in self.outliers])
        return (
            *(
                Check.unless(name, f"fails in {len(logs)} of {len(self)}: {first_of(logs)}")
                for name, logs in by_name.items()
            ),
            Check.unless("outlying logs", out and f"stand out: {out}", "no log stands out"),
        )

    def summary(self) -> str:
        """Counts, what is usual, what stands out, and what failed, as text."""
        return plain_text(self.document())

    def _repr_html_(self) -> str:
        """For notebooks."""
        return blocks_html(self.document())

    def document(self) -> Document:
        """The same in blocks."""
        return fleet_document(self.folder, self.rows, self.groups, self.notes)

    def write(self, file: str | Path | None = None) -> Path:
        """Write the table of all logs, a row for each.

        Parameters
        ----------
        file : str or Path, optional
            Ends in ``.parquet``, ``.csv`` or ``.npz``; by default ``fleet.parquet`` in the folder
            of the results, or ``fleet.csv`` where pyarrow is not installed.

        Returns
        -------
        Path
            What was written.

        Raises
        ------
        UsageError
            The ending is another one, or the place cannot be written to.
        """
        place = None if file is None else Path(file)
        return write_table(self.rows, self.outliers, Path(self.folder), place)
