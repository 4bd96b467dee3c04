"""The result object: estimates with what they were made from."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from axisid.codegen import GeneratedAxis
from axisid.modeling import UsageError

from .check import Check
from .details_text import details_text
from .diagnosis import Diagnosis, diagnose, judged_method
from .estimate import Estimate
from .physical import Physical, physical_parameters
from .prefilter import Prefilter
from .record import Record
from .serialised import (
    SCHEMA,
    diagnosis_dict,
    drawn_dict,
    estimate_dict,
    left_out_dict,
    physical_dict,
    prefilter_dict,
    record_dict,
)
from .summary import drawn_text, summary_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Identification:
    """The estimates of one axis from one record.

    Attributes
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
    estimates : mapping of str to Estimate
        By method.
    skipped : mapping of str to str
        Methods that were not asked for by name and that axis or record do not allow, with the
        reason.
    failed : mapping of str to str
        Methods that were not asked for by name and came to nothing, with the reason.
    asked : Prefilter or None
        The prefilter before what it left open was chosen for the record.
    """

    axis: GeneratedAxis
    record: Record
    prefilter: Prefilter
    estimates: Mapping[str, Estimate]
    skipped: Mapping[str, str]
    failed: Mapping[str, str]
    asked: Prefilter | None = None

    def __getitem__(self, method: str) -> Estimate:
        return self._of(method)

    def __iter__(self) -> Iterator[str]:
        return iter(self.estimates)

    def __contains__(self, method: object) -> bool:
        return isinstance(method, str) and method.lower() in self.estimates

    def __len__(self) -> int:
        return len(self.estimates)

    def __repr__(self) -> str:
        source = self.record.provenance.source
        return f"identification of {self.axis.axis.name} from {source}: {', '.join(self.estimates)}"

    @property
    def physical(self) -> dict[str, Physical]:
        """Declared parameters by method; empty where the estimates are of them already.

        From the base parameters and what is declared as known; see `axisid.fix`.
        """
        found = {name: physical_parameters(e) for name, e in self.estimates.items()}
        return {name: each for name, each in found.items() if each is not None}

    @property
    def judged(self) -> Estimate:
        """The estimate that is judged, by instruments where there are, inverse model first."""
        return self.estimates[judged_method(self.estimates)]

    @property
    def diagnosis(self) -> Diagnosis:
        """What the tests of the result measured; made anew each time."""
        return diagnose(self.axis, self.record, self.prefilter, self.estimates)

    @property
    def verdict(self) -> tuple[Check, ...]:
        """What was checked, against what, and what it means."""
        return self.diagnosis.verdict

    def summary(self, draws: int = 0, *, full: bool = False) -> str:
        """The estimates side by side as text, with numbered notes.

        Parameters
        ----------
        draws : int
            How many to draw from each estimate's distribution, for a table of intervals that do
            without the delta method; 0 for none.
        full : bool
            Add intervals, correlations and every diagnostic with its figures.
        """
        drawn = f"\n{drawn_text(self.estimates, draws)}" if draws else ""
        diagnosis = self.diagnosis
        details = f"\n{details_text(self.estimates, diagnosis)}" if full else ""
        text = summary_text(
            self.axis,
            self.record,
            self.prefilter,
            tuple(self.estimates.values()),
            {**self.skipped, **self.failed},
            diagnosis.verdict,
            self.physical,
        )
        return text + drawn + details

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """For notebooks: a compact table and the verdict."""
        from .notebook import result_html

        return result_html(self)

    def plot_force(self, method: str | None = None) -> "Figure":
        """Draw measured and reconstructed force of a method, by default the judged one."""
        return self._of(method).plot_force()

    def plot_autocorrelation(self, method: str | None = None) -> "Figure":
        """Draw the residuals' autocorrelation."""
        return self._of(method).plot_autocorrelation()

    def plot_spectrum(self, method: str | None = None) -> "Figure":
        """Draw the residuals' power density."""
        return self._of(method).plot_spectrum()

    def plot_convergence(self, method: str | None = None) -> "Figure":
        """Draw the iterates of instruments; a `UsageError` for least squares."""
        return self._of(method).plot_convergence()

    def plot_friction(self, method: str | None = None) -> "Figure":
        """Draw the fitted friction law over the binned measurement.

        Raises
        ------
        UsageError
            The velocity's part of the force cannot be told from the rest.
        """
        from .drawing import drawn
        from .friction import friction_plot
        from .plot import drawable

        return drawn(drawable(friction_plot(self, self._of(method))))

    def plot_tracking(self, method: str | None = None) -> "Figure":
        """Draw recorded and simulated position; a `UsageError` if there is no loop."""
        from .drawing import drawn
        from .plot import drawable
        from .result_plots import tracking_plot

        return drawn(drawable(tracking_plot(self, self._of(method))))

    def plot_record(self) -> "Figure":
        """Draw the record, with what was dropped."""
        from .drawing import drawn
        from .result_plots import record_plot

        return drawn(record_plot(self))

    def _of(self, method: str | None) -> Estimate:
        if method is None:
            return self.judged
        if method.lower() not in self.estimates:
            raise UsageError(
                f"the result has no {method!r}; choose from {', '.join(self.estimates)}."
            )
        return self.estimates[method.lower()]

    def to_dict(self, draws: int = 0) -> dict[str, Any]:
        """What ``--json`` writes: plain numbers, texts and lists; `draws` as in `summary`."""
        diagnosis, physical = self.diagnosis, self.physical
        return {
            "schema": SCHEMA,
            "axis": self.axis.axis.name,
            "signature": self.axis.signature,
            "left_out": left_out_dict(self.axis),
            "record": record_dict(self.record),
            "prefilter": prefilter_dict(self.prefilter, self.record.period),
            "estimates": [
                {
                    **estimate_dict(e),
                    "drawn": drawn_dict(e, draws) if draws else None,
                    **physical_dict(physical.get(name)),
                }
                for name, e in self.estimates.items()
            ],
            **diagnosis_dict(diagnosis, self.axis.names),
            "skipped": dict(self.skipped),
            "failed": dict(self.failed),
        }
