"""Where a result comes from: file, settings, versions and generated code."""

import platform
from collections.abc import Mapping
from datetime import datetime
from html import escape
from importlib.metadata import version

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import left_out_text
from axisid.presentation.formulas import readable_unit
from axisid.presentation.html import unbroken
from axisid.presentation.text import listed_facts, record_facts
from axisid.support.mappings import grouped
from axisid.support.version import __version__

_PACKAGES = ("numpy", "scipy", "casadi", "sympy")


def provenance_html(result: Identification, command: str, made: datetime | None = None) -> str:
    """A list of facts and the command that gives the same again.

    Parameters
    ----------
    result : Identification
    command : str
        As it was given; empty where the result was made in Python.
    made : datetime, optional
        When; not told where it is not given, so that the same result gives the same page.
    """
    return facts_html(_facts(result, made), command)


def made_text(made: datetime | None) -> str:
    """When a page was made; not told where it is not given."""
    return "" if made is None else made.isoformat(" ", "seconds")


def facts_html(facts: Mapping[str, str], command: str) -> str:
    """Facts by name, those without a text left out, and the command that gives the same again."""
    listed = "".join(
        f"<dt>{escape(name)}</dt><dd>{_value(name, text)}</dd>"
        for name, text in facts.items()
        if text
    )
    again = (
        f"<p>The command that reproduces it:</p><pre>{unbroken(command)}</pre>" if command else ""
    )
    return f"<dl>{listed}</dl>{again}"


def _facts(result: Identification, made: datetime | None) -> dict[str, str]:
    source, f = result.record.provenance, result.prefilter
    start, end = result.data.sampling.filter.dropped
    facts = record_facts(result.record)
    record = result.record
    return {
        "made": made_text(made),
        "axis": result.axis.axis.name,
        "left out": left_out_text(result.axis.declared),
        **(
            _of_records(result)
            if result.of_records
            else {
                "record": f"SIMULATED: {source.source}" if source.truth else source.source,
                "truth": truth_text(result),
                "file as named": source.given,
                "file": source.path,
                "sha256 of the file": source.sha256,
                **{name: facts[name] for name in ("columns", "assumed", "repaired")},
                "samples": f"{len(record)} of {1e3 * record.period:.6g} ms, "
                f"{len(record) * record.period:.4g} s",
            }
        ),
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
        else f"{sum(each.sampling.excluded_samples for each in result.problem.data)} samples "
        "without weight",
        "hold": str(f.hold),
        "deviations": _covariances(result),
        **made_by(result.axis),
    }


def made_by(axis: GeneratedAxis) -> dict[str, str]:
    """The code and the versions that made a result."""
    versions = [f"axisid {__version__}", f"Python {platform.python_version()}"]
    versions += [f"{package} {version(package)}" for package in _PACKAGES]
    native = axis.native.library() is not None
    return {
        "generated code": axis.signature,
        "simulated by": "native code" if native else "the CasADi virtual machine",
        "versions": ", ".join(versions),
        "platform": platform.platform(),
    }


def _of_records(result: Identification) -> dict[str, str]:
    """Where each of several records comes from."""
    facts: dict[str, str] = {}
    for i, record in enumerate(result.records, 1):
        source = record.provenance
        facts |= {
            f"record {i}": f"SIMULATED: {source.source}" if source.truth else source.source,
            f"file of record {i}": source.path,
            f"sha256 of its file, {i}": source.sha256,
            f"samples of record {i}": f"{len(record)} of {1e3 * record.period:.6g} ms, "
            f"{len(record) * record.period:.4g} s",
        }
    told = listed_facts([record_facts(record) for record in result.records])
    own = {name: text for name, text in told.items() if not name.startswith("record")}
    return {**facts, "truth": truth_text(result), **own}


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
    named = grouped(
        (each.covariance_names[each.chosen], each.method.upper())
        for each in result.estimates.values()
    )
    if len(named) == 1:
        return next(iter(named))
    return "; ".join(f"{', '.join(methods)}: {name}" for name, methods in named.items())


def _value(name: str, text: str) -> str:
    exact = name in ("file as named", "file", "sha256 of the file", "generated code")
    return f"<code>{escape(text)}</code>" if exact else unbroken(text)
