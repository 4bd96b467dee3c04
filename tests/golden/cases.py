"""What is held against golden results: command lines, each with what it needs to run."""

from dataclasses import dataclass
from pathlib import Path

from axisid.commands.main import cli
from axisid.modeling import LIBRARY

EMPS = "{data}/emps/DATA_EMPS.mat"
DFKI = "{root}/examples/dfki_pendulum.py {folder}/dfki_joined.csv"
_RECIPE = (
    "--cutoff 100 --drop 49 0 --hold raw --reversals keep --sample-period 1e-3 "
    "--decimate 10 --decimation matlab"
)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A command line whose output is kept.

    Attributes
    ----------
    name : str
        Of the file that keeps it.
    command : str
        ``{data}`` stands for the folder of real records, ``{root}`` for that of the project,
        ``{folder}`` for an empty one in which `before` was run.
    before : tuple of str
        Commands that it needs the output of, or a real record that it needs as a text.
    """

    name: str
    command: str
    before: tuple[str, ...] = ()

    @property
    def needs_data(self) -> bool:
        """Whether it reads a real record."""
        return "{data}" in " ".join((self.command, *self.before))

    @property
    def computes(self) -> bool:
        """Whether rounding is in the output, which falls otherwise on other machines."""
        return not self.command.startswith("show ") and not self.command.endswith("--help")

    @property
    def is_json(self) -> bool:
        """Whether the output is JSON, compared by its numbers, rather than text, compared whole."""
        return "--json -" in self.command or "--to json" in self.command


def _exported(target: str) -> Case:
    made = "identify emps2015 --json {folder}/result.json"
    command = f"export {{folder}}/result.json --axis emps2015 --to {target}"
    return Case(name=f"export-{target}", command=command, before=(made,))


CASES: tuple[Case, ...] = (
    *(Case(name=f"twin-{name}", command=f"identify {name} --json -") for name in LIBRARY),
    *(
        Case(name=f"text-{name}", command=f"identify {name} --full --draws 50")
        for name in ("emps2015", "crank", "linear_motor")
    ),
    Case(name="emps-recipe", command=f"identify emps {EMPS} {_RECIPE} --json -"),
    Case(name="emps-defaults", command=f"identify emps {EMPS} --sample-period 1e-3 --json -"),
    Case(name="emps-text", command=f"identify emps {EMPS} --sample-period 1e-3"),
    Case(
        name="emps-validate",
        command=f"identify emps {EMPS} --sample-period 1e-3 --validate {EMPS} --json -",
    ),
    Case(
        name="emps-validate-text",
        command=f"identify emps {EMPS} --sample-period 1e-3 --validate {EMPS}",
    ),
    Case(
        name="emps-compare", command=f"compare {EMPS} --ladder emps --sample-period 1e-3 --json -"
    ),
    Case(name="emps-compare-text", command=f"compare {EMPS} --ladder emps --sample-period 1e-3"),
    Case(
        name="emps-sweep",
        command=f"sweep emps {EMPS} --sample-period 1e-3 --points 3 --json -",
    ),
    Case(name="twin-sweep-text", command="sweep emps2015 --points 3"),
    Case(
        name="dfki",
        command=f"identify {DFKI} --cutoff 15 --decimate 8 --hold raw --reversals keep --json -",
        before=("{data}/dfki_pendulum",),
    ),
    Case(
        name="twin-compare-results",
        command="compare-results {folder}/a.json {folder}/b.json",
        before=(
            "identify emps2015 --json {folder}/a.json",
            "identify emps2015 --cutoff 40 --json {folder}/b.json",
        ),
    ),
    *(Case(name=f"show-{name}", command=f"show {name}") for name in ("crank", "belt_axis")),
    *(Case(name=f"help-{name}", command=f"{name} --help") for name in cli.commands),
    *map(_exported, ("c", "st", "python", "json", "toml", "csv", "latex")),
)

FOLDER = Path(__file__).parent / "outputs"
