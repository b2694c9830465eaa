"""Tables: how columns write values, heads and what is missing, in SI and in units wished for."""

import pytest

from crankbase.tables.output_units import SI, parse_output_units
from crankbase.tables.table import Column, Table

INCHES = parse_output_units("in, lbf")


@pytest.mark.parametrize(
    ("column", "cell", "units", "head", "text"),
    [
        (Column("force", "kN"), 12345.6, SI, "force [kN]", "12.35"),
        (Column("force", "kN"), 4448.2216, INCHES, "force [lbf]", "1000"),
        (Column("speed", "1/min", decimals=1), 52.36, SI, "speed [1/min]", "500.0"),
        (Column("", "mm"), 0.5, SI, "mm", "500"),
        (Column("lowest", "mm", bare=True), 0.0254, INCHES, "lowest", "1"),
        (Column("used", "%", 3), 12.345, SI, "used [%]", "1234"),
        (Column("margin", "%", decimals=1), -1e-9, SI, "margin [%]", "0.0"),
        (Column("order", digits=None), 4.5, SI, "order", "4.5"),
        (Column("terms"), 123456, SI, "terms", "123456"),
        (Column("rho", "mm", joint=" to "), (0.1, 0.2), SI, "rho [mm]", "100 to 200"),
        (Column("peak", missing="unbounded"), None, SI, "peak", "unbounded"),
        (Column("nodes at", decimals=2), [], SI, "nodes at", ""),
        (Column("kind", words=True), "12 m", INCHES, "kind", "12 m"),
    ],
)
def test_a_column_writes_heads_and_cells(column, cell, units, head, text):
    assert (column.head(units), column.text(cell, units)) == (head, text)


def test_numbers_written_elsewhere_get_their_digits_but_orders_stay():
    def write(value, digits):
        return f"{value:#.{digits}g}"

    table = Table("", [Column("order", digits=None), Column("load", "kN")], [[4.5, 1600.0]])
    assert table.texts(write=write) == [["4.5", "1.600"]]
    assert table.texts() == [["4.5", "1.6"]]


def test_numbers_written_with_fewer_digits_are_rounded_once():
    # 81.148 is 81.15 with two decimals; three digits of it are 81.1.
    table = Table("", [Column("frequency", "Hz", decimals=2)], [[81.148], [9.636], [0.0]])
    assert table.texts() == [["81.15"], ["9.64"], ["0.00"]]
    assert table.texts(write=lambda value, _: f"{value:#.3g}") == [["81.1"], ["9.64"], ["0.00"]]


def test_rows_that_read_alike_are_merged_only_where_wished():
    rows = [["1", 1.0], ["2", 1.0 + 1e-9], ["3", 2.0]]
    columns = [Column("cylinder", words=True), Column("p")]
    assert Table("", columns, rows, merged=True).texts() == [["1, 2", "1"], ["3", "2"]]
    assert len(Table("", columns, rows).texts()) == 3


def test_a_row_has_a_cell_for_each_column():
    with pytest.raises(ValueError, match="shorter"):
        Table("", [Column("a"), Column("b")], [[1.0]]).texts()


def test_columns_are_picked_by_name():
    table = Table("t", [Column("a"), Column("b")], [[1.0, 2.0]], marks=["over"])
    picked = table.select("b")
    assert [column.name for column in picked.columns] == ["b"]
    assert (picked.texts(), picked.marks) == ([["2"]], ["over"])
