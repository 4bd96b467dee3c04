"""Blocks of a document: tables without an empty column."""

from axisid.presentation.documents import text_table, without_empty_last_column


def test_a_last_column_is_left_out_only_if_all_its_cells_are_empty() -> None:
    empty = text_table(["name", "value", "remark"], [("M", "1", ""), ("Fv", "2", "")])
    assert without_empty_last_column(empty).rows == (("M", "1"), ("Fv", "2"))
    assert [column.head for column in without_empty_last_column(empty).columns] == ["name", "value"]
    filled = text_table(["name", "value", "remark"], [("M", "1", ""), ("Fv", "2", "fixed")])
    assert without_empty_last_column(filled) == filled
