"""The results that are kept: command lines, each with what it needs to run."""

from dataclasses import dataclass

EMPS = "{data}/emps/DATA_EMPS.mat"
DFKI = "{data}/dfki_pendulum"
_RECIPE = (
    "--cutoff 100 --drop 49 0 --hold raw --reversals keep --sample-period 1e-3 "
    "--decimate 10 --decimation matlab"
)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A command line whose result is kept.

    Attributes
    ----------
    name : str
        Of the file that keeps it.
    command : str
        ``{data}`` stands for the folder of real records, ``{root}`` for that of the project,
        ``{folder}`` for an empty one.
    before : str
        A command that makes what this one reads, or a real record that it needs as a text.
    """

    name: str
    command: str
    before: str = ""

    @property
    def record(self) -> str | None:
        """The real record that it reads, if it does."""
        return next((each for each in (EMPS, DFKI) if each in self.before + self.command), None)


CASES: tuple[Case, ...] = (
    *(
        Case(name=f"identify-{name}", command=f"identify {name}")
        for name in ("emps2015", "pendulum", "vertical_screw", "valve", "crank", "servo_joint")
    ),
    Case(
        name="identify-otherwise",
        command="identify rotary_table --loss huber --covariance robust --start nominal",
    ),
    Case(
        name="several-records",
        before="twin belt_axis --output {folder}/twins --count 2 --scatter Fcp=5%",
        command="identify belt_axis {folder}/twins/belt_axis-0001.csv "
        "{folder}/twins/belt_axis-0002.csv --local Fcp",
    ),
    Case(name="fit-control", command="fit pendulum"),
    Case(name="fit-position", command="fit belt_axis --output position"),
    Case(name="fit-both", command="fit emps2015 --output control,position"),
    Case(name="fit-open-loop", command="fit balanced_slide --output open-loop"),
    Case(name="sweep", command="sweep linear_motor --points 2"),
    Case(name="compare", command="compare --ladder emps2015"),
    Case(
        name="study",
        command="study emps --runs 3 --checks 1 --method idm-ls --method fit:control",
    ),
    Case(name="emps-recipe", command=f"identify emps {EMPS} {_RECIPE}"),
    Case(
        name="emps-halves",
        command=f"identify emps {EMPS} --sample-period 1e-3 --window 0..13 "
        f"--validate {EMPS} --validate-window 12..24",
    ),
    Case(name="emps-fit", command=f"fit emps {EMPS} --sample-period 1e-3"),
    Case(
        name="dfki",
        before=DFKI,
        command="identify {root}/examples/dfki_pendulum.py {folder}/dfki_joined.csv --cutoff 15 "
        "--decimate 8 --hold raw --reversals keep",
    ),
)
