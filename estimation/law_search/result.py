"""Which ready laws explain a recorded control."""

from collections.abc import Mapping
from dataclasses import dataclass

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Checked
from axisid.estimation.records import Record
from axisid.estimation.thresholds import MAX_LAW_RESIDUAL
from axisid.modeling.declaration import ControlLaw
from axisid.support.presentable import Presentable


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplainedLaw:
    """A ready law with the gains that explain a control best.

    Attributes
    ----------
    law : ControlLaw
        With these gains and the delay.
    function : str
        Its name in `axisid.control`.
    words : mapping of str to str
        The arguments of that function that are no numbers.
    deviations : mapping of str to float
        Standard deviation of each gain, for autocorrelated residuals; of those that the record
        tells apart from the others.
    held_out_percent : float
        What it leaves of the control on rows that the gains were not found from, percent of it.
    fitted_percent : float
        The same on the rows that they were found from.
    same : str
        What else gives the same control, in words.
    """

    law: ControlLaw
    function: str
    words: Mapping[str, str]
    deviations: Mapping[str, float]
    held_out_percent: float
    fitted_percent: float
    same: str

    @property
    def title(self) -> str:
        """The law and its words: ``cascade_p_pi, velocity averaged``."""
        return ", ".join([self.function, *(f"{k} {v}" for k, v in self.words.items())])

    @property
    def toml(self) -> str:
        """How a TOML declaration has it."""
        return f"control = {{ law = {_quoted(self.function)}, {self._arguments(' = ')} }}"

    @property
    def python(self) -> str:
        """How a Python declaration has it."""
        law = f"{self.function}({self._arguments('=')})"
        late = self.law.delay
        return f"control=replace({law}, delay={late})" if late else f"control={law}"

    def _arguments(self, between: str) -> str:
        given = {name: f"{value:.6g}" for name, value in self.law.gains.items()}
        given |= {name: _quoted(word) for name, word in self.words.items()}
        given["period"] = f"{self.law.period:.10g}"
        if self.law.delay and between != "=":
            given["delay"] = str(self.law.delay)
        return ", ".join(f"{name}{between}{text}" for name, text in given.items())


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class LawSearch(Checked, Presentable):
    """Ready laws by how well they explain the recorded control, the best first.

    Attributes
    ----------
    axis : str
        Its name.
    unit : str
        Of the control.
    record : Record
    laws : tuple of ExplainedLaw
        By what they leave of rows that are held out; of those that leave as little, the one with
        the fewest gains first.
    explained : bool
        Whether the first leaves as little as the law check allows.
    as_well : int
        How many of the first leave as little as the best.
    """

    axis: str
    unit: str
    record: Record
    laws: tuple[ExplainedLaw, ...]
    explained: bool
    as_well: int

    def __repr__(self) -> str:
        return f"laws of {self.axis}: {self.best.title}, {self.best.held_out_percent:.3g} % left"

    @property
    def best(self) -> ExplainedLaw:
        """The first of them."""
        return self.laws[0]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Whether a law explains the control."""
        best, left = self.best.title, self.best.held_out_percent
        lost = (
            f"No ready law explains the control: the best, {best}, leaves {left:.3g} % of it. The "
            "drive runs another law, reads other columns (a feed-forward, a sensor of its own), or "
            "runs faster than the log"
        )
        held = f"{best} leaves {left:.3g} % of the control"
        fault = None if self.explained else lost
        return (Check.unless("control law", fault, held, left, MAX_LAW_RESIDUAL.value),)


def _quoted(word: str) -> str:
    return f'"{word}"'
