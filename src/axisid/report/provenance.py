"""Where a result comes from: file, settings, versions and generated code."""

import platform
from html import escape
from importlib.metadata import version

from axisid import __version__
from axisid.estimation import Identification

_PACKAGES = ("numpy", "scipy", "casadi", "sympy")


def provenance_html(result: Identification, command: str) -> str:
    """A list of facts and the command that gives the same again.

    Parameters
    ----------
    result : Identification
    command : str
        As it was given; empty where the result was made in Python.
    """
    source, f = result.record.provenance, result.prefilter
    start, end = f.dropped(result.record.period)
    columns = ", ".join(f"{role} = {name}" for role, name in source.columns.items())
    versions = [f"axisid {__version__}", f"Python {platform.python_version()}"]
    versions += [f"{package} {version(package)}" for package in _PACKAGES]
    facts = {
        "axis": result.axis.axis.name,
        "record": source.source,
        "sha256 of the file": source.sha256,
        "columns": columns,
        "assumed": "; ".join(source.assumed),
        "repaired": "; ".join(repair.text for repair in source.repairs),
        "samples": f"{len(result.record)} of {1e3 * result.record.period:.6g} ms",
        "position filter": f"Butterworth {f.cutoff:g} Hz, order {f.order}, forward and backward",
        "decimation": "none"
        if f.decimate == 1
        else f"one row in {f.decimate}, {f.decimation} alignment",
        "dropped": f"{start} samples at the start, {end} at the end",
        "near reversals": f"{f.silenced} samples left out" if f.silenced else "kept",
        "hold": str(f.hold),
        "generated code": result.axis.signature,
        "simulated by": "native code"
        if result.axis.native.library() is not None
        else "the CasADi virtual machine",
        "versions": ", ".join(versions),
    }
    listed = "".join(
        f"<dt>{escape(name)}</dt><dd>{_value(name, text)}</dd>"
        for name, text in facts.items()
        if text
    )
    made = f"<p>The command that reproduces it:</p><pre>{escape(command)}</pre>" if command else ""
    return f"<dl>{listed}</dl>{made}"


def _value(name: str, text: str) -> str:
    exact = name in ("sha256 of the file", "generated code")
    return f"<code>{escape(text)}</code>" if exact else escape(text)
