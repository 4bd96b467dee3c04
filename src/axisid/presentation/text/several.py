"""Several records in words: what each is, what is known of it, how it stands beside the rest."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from axisid.estimation.identification import Identification, OfRecord
from axisid.estimation.signals import Sampling
from axisid.modeling.declaration import Drive
from axisid.presentation.blocks import Table, text_columns
from axisid.support.remedy import Note, Wording

from .record import filter_text, kept_text, record_facts


def several_facts(result: Identification, wording: Wording) -> dict[str, str]:
    """What a heading says of several records; what is the same of all is told once."""
    units = _units(result)
    told = [record_facts(of_one.record, wording) for of_one in result.of_records]
    for of_one, own in zip(result.of_records, told, strict=True):
        known = [_known(n, v, units.get(n, "")) for n, v in of_one.known.items()]
        own["record"] = "; ".join([own["record"], *known])
    return {"records": f"{len(told)}, one set of parameters", **listed_facts(told)}


def listed_facts(told: Sequence[Mapping[str, str]]) -> dict[str, str]:
    """Facts of several records, numbered; what is the same of all is told once."""
    facts = {f"record {i}": own["record"] for i, own in enumerate(told, 1)}
    for name in ("columns", "assumed", "repaired"):
        each = [own[name] for own in told]
        if len(set(each)) == 1:
            facts[name] = each[0]
        else:
            facts |= {f"{name} {i}": text for i, text in enumerate(each, 1)}
    return facts


def set_aside_facts(set_aside: Mapping[str, str | Note], wording: Wording) -> dict[str, str]:
    """Records that could not be used, with the reason."""
    if not set_aside:
        return {}
    counted = f"{len(set_aside)} record{'s' * (len(set_aside) > 1)}"
    told = {n: why if isinstance(why, str) else why.worded(wording) for n, why in set_aside.items()}
    reasons = (
        f"{n} ({why.removeprefix(f'{Path(n).name}: ').removesuffix('.')})"
        for n, why in told.items()
    )
    return {"set aside": f"{counted}: {'; '.join(reasons)}"}


def records_table(result: Identification) -> Table:
    """Each record beside the others, by the estimate that is judged."""
    heads = (
        "record",
        "rows",
        "weight",
        "noise",
        "equation error",
        "simulation error",
        "apart",
        "chance",
    )
    return Table(
        columns=text_columns(heads),
        rows=tuple(_row(of_one, i) for i, of_one in enumerate(result.of_records, 1)),
    )


def several_notes(result: Identification) -> list[str]:
    """How several records became one estimate; nothing of one."""
    if not result.of_records:
        return []
    weights = ", ".join(f"{of_one.weight:.3g}" for of_one in result.of_records)
    notes = [
        "One regression of all records, none of whose rows is a neighbour of another record's. "
        f"Rows are weighted by the inverse of each record's noise, weights {weights}: what least "
        "squares of all leaves of each in a first pass (feasible generalised least squares).",
        f"Records one by one: errors by {result.preferred.method.upper()}, percent. Noise: "
        "residuals, root mean square, in the unit of the force. Apart: force that the parameters "
        "which the record has alone make otherwise, percent of its force; chance: that noise alone "
        "makes as much.",
    ]
    for name, own in result.local_names.items():
        listed = ", ".join(dict.fromkeys(filter(None, own)))
        notes.append(f"{listed}: {name} of each record, in their order.")
    if result.declared_gain is not None:
        unit = result.preferred.parameters["drive_gain"].unit
        notes.append(
            f"drive_gain: identified by the known force; {result.declared_gain:g} {unit} is "
            "declared. The deviations of the other parameters contain its own."
        )
    if any(sd for of_one in result.of_records for _, sd in of_one.known.values()):
        notes.append(
            "Deviations contain what those of the known values add; equal values with equal "
            "deviations are taken as one thing, weighed once."
        )
    return notes


def several_rows_text(
    samplings: Sequence[Sampling], used: int, drive: Drive, *, measured: bool
) -> str:
    """How several records became the rows of one regression."""
    kept = [*dict.fromkeys(map(kept_text, samplings))]
    which = (
        kept[0]
        if len(kept) == 1
        else "of the records in their order " + ", ".join(map(kept_text, samplings))
    )
    samples = sum(sampling.samples for sampling in samplings)
    quiet = sum(sampling.excluded_samples for sampling in samplings)
    masked = sum(sampling.masked_rows for sampling in samplings)
    lost = f", {masked} left out that masked samples reach" if masked else ""
    lost += f", {quiet} samples near reversals and rests left out before" if quiet else ""
    filters = [*dict.fromkeys(filter_text(s, drive, measured=measured) for s in samplings)]
    return (
        f"{used} rows of {samples} samples in {len(samplings)} records: the filter's transients "
        f"dropped at both ends of each, then {which}{lost}. {' '.join(filters)}"
    )


def _row(of_one: OfRecord, number: int) -> tuple[str, ...]:
    source = of_one.record.provenance.source
    return (
        f"{number}  {source}",
        str(of_one.rows),
        f"{of_one.weight:.3g}",
        f"{of_one.noise:.3g}",
        f"{of_one.equation_error_percent:.4f}",
        _or_dash(of_one.simulation_error_percent, ".4f"),
        _or_dash(of_one.share_percent, ".2g"),
        _or_dash(of_one.p_value, ".2g"),
    )


def _or_dash(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def _known(name: str, value: tuple[float, float], unit: str) -> str:
    number, deviation = value
    spread = f" +- {deviation:g}" if deviation else ""
    return f"{name} = {number:g}{spread} {unit}".rstrip()


def _units(result: Identification) -> dict[str, str]:
    return {p.name: p.unit for p in result.axis.declared.parameters}
