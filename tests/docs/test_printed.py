"""Pages are compared with what is printed, neither too strictly nor too loosely."""

import pytest
from printed import is_printed

PRINTED = "mass 13.544 +- 0.03 kg\n pi_1   843.15     2e-12\n pi_2  -111.75    -7e-12\n"


@pytest.mark.parametrize(
    "shown",
    [
        "",
        PRINTED,
        "mass 13.543 +- 0.03 kg",
        "mass 13.54 +- 0.03 kg",
        "pi_1 843.15 4e-13 pi_2 -111.75 1e-12",
        "mass 13.544 ... pi_2 -111.75",
    ],
)
def test_what_is_printed(shown: str):
    assert is_printed(shown, PRINTED)


@pytest.mark.parametrize(
    "shown",
    [
        "mass 13.54 kg",
        "mass 13.542 +- 0.03 kg",
        "pi_2 843.15",
        "pi_1 843.15 pi_2 -111.75",
        "pi_2 ... pi_1",
        "pi_2 111.75",
    ],
)
def test_what_is_not(shown: str):
    assert not is_printed(shown, PRINTED)
