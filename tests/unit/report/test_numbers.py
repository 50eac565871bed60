"""Digits follow the deviation."""

# True minus signs and dashes.
# ruff: noqa: RUF001

import pytest

from orbident.report.page import interval_text, short, signed, with_std

NAN = float("nan")


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (843.14596, 0.0353, "843.146"),
        (1110.444, 0.371, "1110.44"),
        (-111.7537, 2.3, "−111.8"),
        (123456.0, 2100.0, "123500"),
        # Noise-free: six digits are enough for anybody.
        (843.1459688173641, 1e-13, "843.146"),
        (0.0450450450, 5e-18, "0.0450450"),
        (3.2e-8, 1e-9, "3.20·10⁻⁸"),
        (25_700_000.0, NAN, "2.57000·10⁷"),
        (-1e-9, 0.5, "0.00"),
        (0.0, 0.0, "0.00000"),
        (NAN, 1.0, "–"),
    ],
)
def test_value(value: float, std: float, text: str):
    assert with_std(value, std) == text


def test_interval():
    assert interval_text(10.0, 0.5) == "9.02 to 10.98"
    assert interval_text(NAN, 0.5) == interval_text(1.0, NAN) == "–"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.36129591, "0.361"),
        (80.0, "80.0"),
        (1601.4, "1600"),
        (1.8e-7, "1.80·10⁻⁷"),
        (None, "–"),
    ],
)
def test_short(value: float | None, text: str):
    assert short(value) == text


def test_differences():
    assert signed(0.039) == "+0.039"
    assert signed(-50.0) == "−50"
    assert signed(NAN) == "–"
