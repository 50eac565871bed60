import pytest
import yaml

from orbident.errors import InputError
from orbident.files.schema_parts import read_yaml_mapping


def read(text):
    return read_yaml_mapping(text, "a.yaml", "orbident/any/1")


ACCEPTED = {
    "nested": ("a: {b: [1, {c: x}]}", {"a": {"b": [1, {"c": "x"}]}}),
    "windows": ("a: 1\r\nb: 2\r\n", {"a": 1, "b": 2}),
    "same key elsewhere": ("a: {k: 1}\nb: {k: 2}", {"a": {"k": 1}, "b": {"k": 2}}),
    "a number and its text": ("1: a\n'1': b", {1: "a", "1": "b"}),
    "alias": ("a: &x {k: 1}\nb: *x", {"a": {"k": 1}, "b": {"k": 1}}),
    # Merged keys may be overridden, also by an alias of what overrides them.
    "merge": (
        "p: {q: &b {<<: &a {k: 1}, k: 2}}\nc: {<<: *b, k: 3}",
        {"p": {"q": {"k": 2}}, "c": {"k": 3}},
    ),
}


@pytest.mark.parametrize(("text", "document"), ACCEPTED.values(), ids=ACCEPTED)
def test_accepted(text, document):
    assert read(text) == document


def test_an_alias_may_contain_itself():
    document = read("a: &x [1, *x]")
    assert document["a"][1] is document["a"]


REFUSED = {
    "empty": ("", "a.yaml: found an empty file; give keys and values, first 'schema: "),
    "comment": ("# a: 1", "found an empty file"),
    "list": ("[1, 2]", "found a list; .* first 'schema: orbident/any/1'"),
    "text": ("duration", "found text; give keys"),
    "number": ("5", "found a single value; give keys"),
    "open bracket": ("a: 1\nb: [1\n", r"a\.yaml:3:1: no valid YAML: .*; correct it"),
    "tab": ("a:\n\tb: 1\n", r"a\.yaml:2:1: no valid YAML: .*"),
    "undefined alias": ("a: *x", r"a\.yaml:1:4: no valid YAML"),
    "two documents": ("a: 1\n---\nb: 2\n", r"a\.yaml:2:1: no valid YAML"),
    "control character": ("a: \x00", r"a\.yaml: no valid YAML: .*; correct it"),
    "tag": ("a: !!python/name:os.x", r"a\.yaml:1:4: .*constructor"),
    "unhashable key": ("? {a: 1}\n: 2", r"a\.yaml:1:3: .*unhashable key"),
    "key twice": ("a: 1\nb: 2\na: 3", r"a\.yaml:3:1: the key 'a' is given twice; keep"),
    "quoted twice": ("a: 1\n'a': 3", "the key 'a' is given twice; keep one$"),
    "inside": ("a: [{b: 1, b: 2}]", r"a\.yaml:1:12: the key 'b' is given twice"),
}


@pytest.mark.parametrize(("text", "message"), REFUSED.values(), ids=REFUSED)
def test_refused(text, message):
    with pytest.raises(InputError, match=message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


PLAIN = {
    "sexagesimal": ("1:30", "1:30"),
    "sexagesimal fraction": ("1:30.5", "1:30.5"),
    "octal": ("010", "010"),
    "underscores": ("1_000", "1_000"),
    "on": ("on", "on"),
    "no": ("no", "no"),
    "true": ("true", True),
    "negative": ("-7", -7),
    "fraction": ("-.5", -0.5),
    "exponent": ("1.0e+3", 1000.0),
    "nothing": ("~", None),
    "date": ("2026-03-01", "2026-03-01"),
}


@pytest.mark.parametrize(("text", "value"), PLAIN.values(), ids=PLAIN)
def test_plain_values_are_those_of_yaml_1_2(text, value):
    found = read(f"a: [{text}]")["a"][0]
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    "value", ["1:30", "010", "on", "no", "true", "1e5", "1_000", "09", "~", "1.", "0x1"]
)
def test_what_is_written_as_text_is_read_as_text(value):
    """PyYAML's writer quotes at least what is no text here."""
    assert read(yaml.safe_dump({"a": value})) == {"a": value}


DEEP = {
    "lists": "[" * 100_000,
    "mappings": "{a: " * 100_000,
    "blocks": "- " * 100_000,
    "just too deep": "a: " + "[" * 50 + "]" * 50,
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_deep_nesting_is_refused(text):
    """libyaml's stack would overflow, and the process crash."""
    with pytest.raises(InputError, match=r"^a\.yaml:1:\d+: .* more than 50 deep; "):
        read(text)


def test_less_deep_nesting_is_read():
    assert read("a: " + "[" * 49 + "]" * 49)


@pytest.mark.parametrize("text", ["!!bool maybe", "!!int ''", "!!timestamp noon"])
def test_a_value_that_does_not_fit_its_tag(text):
    with pytest.raises(InputError, match=r"^a\.yaml:1:4: found .* tagged '!!\w+', "):
        read(f"a: {text}")
