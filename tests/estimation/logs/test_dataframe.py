"""Dataframes and mappings of a script are read, or explained."""

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation import Repairs
from tests.estimation.logs.samples import NAMED, STAMPS, Q, T, U
from tests.refusals import refuses


@pytest.mark.parametrize("kind", ["mapping", "pandas", "polars", "pyarrow"])
def test_any_dataframe_of_a_script(kind: str) -> None:
    makers = {"mapping": "dict", "pyarrow": "table"}
    pytest.importorskip("narwhals")
    library = pytest.importorskip("builtins" if kind == "mapping" else kind)
    frame = getattr(library, makers.get(kind, "DataFrame"))({"time": T, "q [mm]": Q, "u": U})
    record = read_record(frame, columns=NAMED)
    assert record.position == pytest.approx(1e-3 * Q, rel=1e-15)
    assert np.array_equal(record.control, U)


def test_dataframe_without_one_name_for_each_column_is_explained() -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("narwhals")
    twice = pandas.DataFrame(np.column_stack([T, Q, Q]), columns=["time", "q", "q"])
    with refuses("log-file", says="'q' 2 times"):
        read_record(twice)
    levels = pandas.MultiIndex.from_tuples([("axis", "time"), ("axis", "position")])
    nested = pandas.DataFrame(np.column_stack([T, Q]), columns=levels)
    assert np.array_equal(read_record(nested).position, Q)
    indexed = pandas.DataFrame({"time": T, "position": Q}).set_index("time")
    with refuses("time", says=r"log\.reset_index"):
        read_record(indexed)


def test_time_stamp_that_is_missing_does_not_spoil_the_others() -> None:
    log = {"time": np.where(T > 0, STAMPS, np.datetime64("NaT")), "position": Q}
    with refuses("empty-cells", says=r"1 \(1 of 50 "):
        read_record(log)
    record = read_record(log, repairs=Repairs(resample="auto"))
    assert record.provenance.repairs[0].count == 1
    assert record.position == pytest.approx(Q[1:], abs=1e-9)
