"""One description of a table, as plain text and as a report shows it."""

# True minus signs and dashes.
# ruff: noqa: RUF001

import pytest

from orbident.data_table import Numeric, table_of
from orbident.report.page import typeset

NAN = float("nan")


@pytest.mark.parametrize(
    ("cell", "plain", "shown"),
    [
        ("a name - kept", "a name - kept", "a name - kept"),
        (Numeric(-0.0123, ".2g"), "-0.012", "−0.012"),
        (Numeric(1.8e-12, ".2g"), "1.8e-12", "1.8·10⁻¹²"),
        (Numeric(3.21, "+.1f"), "+3.2", "+3.2"),
        (Numeric(-1.5, ".2f"), "-1.50", "−1.50"),
        (Numeric(7, "d"), "7", "7"),
        (Numeric(-111.7537, ".6g", 2.3), "-111.8", "−111.8"),
        (Numeric(NAN, ".2g"), "-", "–"),
        (Numeric(None, ".6g", 1.0), "-", "–"),
    ],
)
def test_a_cell(cell, plain: str, shown: str):
    assert str(cell) == plain
    assert typeset(cell) == shown


def test_columns_in_which_nothing_is_known():
    rows = [("a", Numeric(NAN), Numeric(1.0)), ("b", Numeric(None), Numeric(NAN))]
    table = table_of("t", ("name", "paper", "ours"), rows).without_empty_columns()
    assert table.head == ("name", "ours")
    assert [len(row.cells) for row in table.rows] == [2, 2]


def test_a_table_without_rows():
    table = table_of("", ("name", "ours"), [])
    assert table.without_empty_columns().head == ()
