"""The results that are kept: command lines, each with what it needs to run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from axisid import Identification, Prefilter, build, identify, load_axis, read_record, twin_record

EMPS = "{data}/emps/DATA_EMPS.mat"
DFKI = "{data}/dfki_pendulum"
_PERIOD = "sample_period = 1e-3"


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
    runs : mapping of str to str
        Files of what is said of EMPS's record, and what they say, in the folder.
    made : callable, optional
        Makes the result in place of the command, where Python alone has what it asks for.
    rounding : float
        By how much more than others its figures may move: twins that hunt over an encoder's steps
        answer to the last digit of the record.
    is_quick : bool
        Whether ``make test`` has it; the others are marked slow.
    """

    name: str
    command: str = ""
    before: str = ""
    runs: Mapping[str, str] = field(default_factory=dict)
    made: Callable[[Mapping[str, Path]], Identification] | None = None
    rounding: float = 1.0
    is_quick: bool = False


def _recipe(places: Mapping[str, Path]) -> Identification:
    """By the published recipe."""
    filtered = Prefilter(cutoff=100.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")
    axis = build(load_axis("emps"))
    return identify(axis, read_record(EMPS.format(**places), axis, sample_period=1e-3), filtered)


def _otherwise(_: Mapping[str, Path]) -> Identification:
    axis = build(load_axis("rotary_table"))
    how = {"loss": "huber", "covariance": "robust", "start": "nominal"}
    return identify(axis, twin_record(axis), **how)


CASES: tuple[Case, ...] = (
    *(
        Case(
            name=f"identify-{name}",
            command=f"identify {name}",
            is_quick=name == "emps2015",
        )
        for name in ("emps2015", "pendulum", "vertical_screw", "valve", "crank", "servo_joint")
    ),
    Case(
        name="identify-otherwise",
        made=_otherwise,
    ),
    Case(
        name="several-records",
        before="twin belt_axis --output {folder}/twins --count 2 --scatter Fcp=5%",
        command="identify belt_axis {folder}/twins/belt_axis-0001.csv "
        "{folder}/twins/belt_axis-0002.csv --local Fcp",
    ),
    Case(name="fit-control", command="fit pendulum"),
    Case(name="fit-position", command="fit belt_axis --output position"),
    Case(name="fit-both", command="fit emps2015 --output control,position", is_quick=True),
    Case(name="fit-open-loop", command="fit balanced_slide --output open-loop"),
    Case(name="sweep", command="sweep linear_motor --points 2"),
    Case(name="compare", command="compare --ladder emps2015"),
    Case(
        name="study",
        command="study emps --runs 3 --checks 1 --method idm-ls --method fit:control",
    ),
    Case(name="emps-recipe", before=EMPS, made=_recipe, is_quick=True),
    Case(
        name="emps-halves",
        before=EMPS,
        runs={"first": f'{_PERIOD}\nwindows = "0..13"', "last": f'{_PERIOD}\nwindows = "12..24"'},
        command="identify emps {folder}/first.toml --validate {folder}/last.toml",
    ),
    Case(
        name="emps-fit",
        before=EMPS,
        runs={"run": _PERIOD},
        command="fit emps {folder}/run.toml",
        rounding=50.0,  # a relative change of 1e-14 moves deviations by 3e-3, values by 1e-3 of one
    ),
    Case(
        name="dfki",
        before=DFKI,
        command="identify {root}/examples/dfki_pendulum.py {folder}/dfki_joined.csv --cutoff 15 "
        "--decimate 8 --hold raw --reversals keep",
    ),
)
