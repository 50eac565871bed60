import math
from typing import Literal

import pytest
from pydantic import Field, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import (
    MappingSchema,
    Number,
    Positive,
    Vector3,
    Vector4,
    validated,
)


class Part(MappingSchema):
    label: str = "x"
    lower: Number = 0.0
    upper: Number = 1.0

    @model_validator(mode="after")
    def _ordered(self) -> "Part":
        if self.lower > self.upper:
            raise InputError("lower is above upper; swap them")
        return self


class Whole(MappingSchema):
    schema_: Literal["whole/1"] = Field("whole/1", alias="schema")
    number: Number = 0.0
    size: Positive = 1.0
    p: Vector3 = (0.0, 0.0, 0.0)
    Q: Vector4 = (0.0, 0.0, 0.0, 1.0)
    on: bool = False
    name: str = Field("a", min_length=1)
    parts: tuple[Part, ...] = ()
    table: dict[str, Part] = Field(default_factory=dict)


@pytest.mark.parametrize(
    ("value", "number"),
    [(1, 1.0), (0.5, 0.5), ("1e-3", 1e-3), ("-2", -2.0), (10**12, 1e12)],
)
def test_numbers(value, number):
    found = validated(Whole, {"number": value, "p": [0, value, 0]}, "a.yaml")
    assert found.number == number
    assert found.p == (0.0, number, 0.0)


@pytest.mark.parametrize(
    "value", [True, False, None, "x", "", "nan", math.inf, 10**400, [1]]
)
def test_what_is_no_number(value):
    with pytest.raises(InputError, match=r"number: found .*; give a finite number$"):
        validated(Whole, {"number": value}, "a.yaml")
    with pytest.raises(
        InputError, match=r"p: found .*; give a 3-vector of finite numb"
    ):
        validated(Whole, {"p": [0, value, 0]}, "a.yaml")


@pytest.mark.parametrize("value", [1.1e12, "-1e200", 10**30])
def test_what_no_spacecraft_has(value):
    words = r"number: found .*; give a number of at most 1e\+12, in SI units$"
    with pytest.raises(InputError, match=words):
        validated(Whole, {"number": value}, "a.yaml")
    words = r"p: found .*; give a 3-vector of numbers of at most 1e\+12"
    with pytest.raises(InputError, match=words):
        validated(Whole, {"p": [0, value, 0]}, "a.yaml")


REFUSED = {
    "tiny": (
        {"size": 1e-16},
        "size: found 1e-16; give a number of at least 1e-15, in SI units",
    ),
    "a mapping for a number": (
        {"number": {"a": 1}},
        "number: found {'a': 1}; give a finite number",
    ),
    "a mapping for a vector": (
        {"p": {"a": 1}},
        "p: found {'a': 1}; give a 3-vector",
    ),
    "nothing for a vector": ({"p": None}, "p: found nothing; give a 3-vector"),
    "a long key": (
        {"parts": [{"k" * 20_000: 1}]},
        f"parts[0]: unknown key '{'k' * 76}...; known keys: 'label', 'lower', 'upper'",
    ),
    "schema": ({"schema": "whole/2"}, "schema: found 'whole/2'; give 'whole/1'"),
    "zero": ({"size": 0}, "size: found 0; give a number above zero"),
    "boolean size": ({"size": True}, "size: found True; give a finite number"),
    "short": ({"p": [1, 2]}, "p: found [1, 2]; give a 3-vector"),
    "long": ({"Q": [0, 0, 0, 0, 1]}, "Q: found [0, 0, 0, 0, 1]; give a 4-vector"),
    "text vector": ({"p": "abc"}, "p: found 'abc'; give a 3-vector"),
    "truth": ({"on": "maybe"}, "on: found 'maybe'; give true or false"),
    "no text": (
        {"name": 5},
        "name: found 5; give text, in quotes if it looks like a number",
    ),
    "no name": ({"name": ""}, "name: found ''; give a name"),
    "nothing": ({"parts": None}, "parts: found nothing; give a list"),
    "no table": ({"table": []}, "table: found []; give names and their entries"),
    "number as a name": (
        {"table": {7: {}}},
        "table[7]: found 7; give text, in quotes if it looks like a number",
    ),
    "no section": (
        {"parts": [3]},
        "parts[0]: found 3; give keys and values: label, lower, upper",
    ),
    "unknown key": (
        {"table": {"t": {"uper": 1}}},
        "table.t: unknown key 'uper'; did you mean 'upper'? "
        "known keys: 'label', 'lower', 'upper'",
    ),
    "a whole section": (
        {"parts": [{}, {"lower": 2}]},
        "parts[1]: lower is above upper; swap them",
    ),
    "two": (
        {"number": "x", "size": 0},
        "number: found 'x'; give a finite number (and 1 more)",
    ),
    "much": (
        {"p": list(range(100))},
        "p: found [" + ", ".join(map(str, range(22))) + "...; give a 3-vector",
    ),
}


@pytest.mark.parametrize(("document", "message"), REFUSED.values(), ids=REFUSED)
def test_refused(document, message):
    with pytest.raises(InputError) as caught:
        validated(Whole, document, "a.yaml")
    assert str(caught.value) == f"a.yaml: {message}"


def test_an_unknown_key_of_the_whole():
    with pytest.raises(InputError, match=r"^a\.yaml: unknown key 1; known keys: 'sch"):
        validated(Whole, {1: 2}, "a.yaml")


def test_a_missing_key():
    class Needy(MappingSchema):
        part: Part

    with pytest.raises(InputError, match=r"^a\.yaml: part: this key is missing; add"):
        validated(Needy, {}, "a.yaml")
