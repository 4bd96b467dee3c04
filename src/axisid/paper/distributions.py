"""How the estimates of the paper's tables are distributed: many twins under both filters.

The published tables have one record and one noise; here bias, scatter and coverage stand with their
Monte-Carlo errors.
"""

from collections.abc import Mapping
from pathlib import Path

from axisid.codegen.artefacts import build
from axisid.estimation.monte_carlo import MonteCarlo, monte_carlo
from axisid.modeling.text import load_axis
from axisid.presentation.blocks import Document, plain_text
from axisid.presentation.monte_carlo import estimand_tables, findings, legend, study_facts
from axisid.support.files.json_text import json_text
from axisid.support.progress import Progress

from .study import APPROPRIATE, INAPPROPRIATE, METHODS, written_into

#: The filters by name, as files are named for them.
FILTERS = {"appropriate": APPROPRIATE, "inappropriate": INAPPROPRIATE}
#: What `write_distributions` writes, and of which kind it is.
DISTRIBUTION_FILES = {
    "distributions.txt": "paper-distributions",
    **{f"distributions_{name}.json": "study" for name in FILTERS},
}


def run_distributions(
    runs: int, *, seed: int = 1, jobs: int = 1, progress: Progress | None = None
) -> dict[str, MonteCarlo]:
    """Identify many twins of `emps2015` by all methods of the tables, by filter.

    Parameters
    ----------
    runs : int
        Twins; under both filters the same ones.
    seed, jobs
        As in `monte_carlo`.
    progress : callable, optional

    Raises
    ------
    UsageError
        As `monte_carlo`.
    """
    axis = build(load_axis("emps2015"))
    return {
        name: monte_carlo(
            axis,
            runs,
            METHODS,
            prefilter=prefilter,
            start="nominal",
            seed=seed,
            jobs=jobs,
            progress=progress,
        )
        for name, prefilter in FILTERS.items()
    }


def distributions_document(found: Mapping[str, MonteCarlo]) -> Document:
    """The estimates of every method and filter, and what stands out."""
    blocks: Document = ()
    studies = {name: study_facts(result) for name, result in found.items()}
    for name, result in studies.items():
        title = f"{len(result)} twins, {name} filter, {FILTERS[name].cutoff:g} Hz"
        blocks = *blocks, *estimand_tables(result, title), findings(result)
    return *blocks, *(legend(result) for result in [*studies.values()][:1])


def write_distributions(found: Mapping[str, MonteCarlo], folder: Path) -> list[Path]:
    """Write the tables and the figures of both filters into a folder.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    texts = {
        "distributions.txt": plain_text(distributions_document(found)),
        **{
            f"distributions_{name}.json": json_text(result.to_dict())
            for name, result in found.items()
        },
    }
    return written_into(folder, texts, list)
