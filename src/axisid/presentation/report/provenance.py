"""Where a result comes from: file, settings, versions and generated code."""

import platform
from datetime import datetime
from html import escape
from importlib.metadata import version

from axisid.estimation.identification import Identification
from axisid.modeling.declaration import left_out_text
from axisid.presentation.formulas import readable_unit
from axisid.presentation.html import unbroken
from axisid.presentation.text import record_facts
from axisid.support.remedy import Wording, as_arguments
from axisid.support.version import __version__

_PACKAGES = ("numpy", "scipy", "casadi", "sympy")


def provenance_html(
    result: Identification,
    command: str,
    made: datetime | None = None,
    *,
    wording: Wording = as_arguments,
) -> str:
    """A list of facts and the command that gives the same again.

    Parameters
    ----------
    result : Identification
    command : str
        As it was given; empty where the result was made in Python.
    made : datetime, optional
        When; not told where it is not given, so that the same result gives the same page.
    wording : callable
        How settings are told.
    """
    listed = "".join(
        f"<dt>{escape(name)}</dt><dd>{_value(name, text)}</dd>"
        for name, text in _facts(result, made, wording).items()
        if text
    )
    again = (
        f"<p>The command that reproduces it:</p><pre>{unbroken(command)}</pre>" if command else ""
    )
    return f"<dl>{listed}</dl>{again}"


def _facts(result: Identification, made: datetime | None, wording: Wording) -> dict[str, str]:
    source, f = result.record.provenance, result.prefilter
    start, end = result.data.sampling.filter.dropped
    facts = record_facts(result.record, wording)
    versions = [f"axisid {__version__}", f"Python {platform.python_version()}"]
    versions += [f"{package} {version(package)}" for package in _PACKAGES]
    record = result.record
    return {
        "made": "" if made is None else made.isoformat(" ", "seconds"),
        "axis": result.axis.axis.name,
        "left out": left_out_text(result.axis.declared),
        "record": f"SIMULATED: {source.source}" if source.truth else source.source,
        "truth": truth_text(result),
        "file as named": source.given,
        "file": source.path,
        "sha256 of the file": source.sha256,
        **{name: facts[name] for name in ("columns", "assumed", "repaired")},
        "samples": f"{len(record)} of {1e3 * record.period:.6g} ms, "
        f"{len(record) * record.period:.4g} s",
        "position filter": f"Butterworth {f.cutoff:g} Hz, order {f.order}, forward and backward",
        "decimation": "none"
        if f.decimate == 1
        else f"one row in {f.decimate}, {f.decimation} alignment",
        "without weight"
        if f.drop is None
        else "dropped": f"{start} samples at the start, {end} at "
        f"the end{' of each segment' if result.record.segments else ''}",
        "near reversals": "kept"
        if f.reversals == "keep"
        else f"{result.data.sampling.excluded_samples} samples without weight",
        "hold": str(f.hold),
        "deviations": _covariances(result),
        "generated code": result.axis.signature,
        "simulated by": "native code"
        if result.axis.native.library() is not None
        else "the CasADi virtual machine",
        "versions": ", ".join(versions),
        "platform": platform.platform(),
    }


def truth_text(result: Identification) -> str:
    """The parameters that a simulated record was made with; empty for a measured one."""
    axis, truth = result.axis, result.record.provenance.truth
    declared = {p.name: p for p in (*axis.declared.parameters, *axis.axis.parameters)}
    return ", ".join(
        f"{p.name} = {truth[p.name]:g} {readable_unit(p.unit)}"
        for p in declared.values()
        if p.name in truth
    )


def _covariances(result: Identification) -> str:
    """How each method's deviations were found, lags among it."""
    named: dict[str, list[str]] = {}
    for estimate in result.estimates.values():
        name = estimate.covariance_names[estimate.chosen]
        named.setdefault(name, []).append(estimate.method.upper())
    if len(named) == 1:
        return next(iter(named))
    return "; ".join(f"{', '.join(methods)}: {name}" for name, methods in named.items())


def _value(name: str, text: str) -> str:
    exact = name in ("file as named", "file", "sha256 of the file", "generated code")
    return f"<code>{escape(text)}</code>" if exact else unbroken(text)
