import struct

from orbident.errors import QUOTED, InputError
from orbident.files.names import (
    LISTED,
    closest,
    first_duplicate,
    listed,
    one_line,
    suggestion,
)


def test_a_close_name_is_suggested():
    found = suggestion("joint9", ["joint1", "wrist"], "joints")
    assert found == "did you mean 'joint1'? known joints: 'joint1', 'wrist'"


def test_no_name_is_close():
    assert suggestion("a", iter(["xyz"]), "keys") == "known keys: 'xyz'"
    assert suggestion("a", [], "keys") == "known keys: none"
    assert closest("a", ["xyz"]) is None


def test_the_first_duplicate():
    assert first_duplicate("abcba") == "b"
    assert first_duplicate([("int", "1"), ("str", "1")]) is None


def test_a_list_of_names_is_cut():
    assert listed([]) == "none"
    assert listed(["a", "b"]) == "'a', 'b'"
    names = [f"joint{k}" for k in range(1000)]
    found = listed(names)
    shown = found.count("joint")
    assert found == ", ".join(map(repr, names[:shown])) + f" and {1000 - shown} more"
    assert len(found) < LISTED + len(" and 1000 more")
    assert len(listed(["one two " * 1000] * 1000)) < LISTED + len(" and 1000 more")


def test_a_long_name_in_a_message_is_cut_also_with_blanks():
    message = str(InputError(f"column '{'a b/c ' * 50}' is missing; add 'arm (m)'"))
    assert len(message) == len("column '' is missing; add 'arm (m)'") + QUOTED
    assert message.startswith("column 'a b/c a b/c ")
    assert message.endswith("...' is missing; add 'arm (m)'")


def test_words_between_quoted_names_are_not_cut():
    words = "the wheels' speeds and the joints' positions " * 3
    message = f"'a (m)' {words} '(b)' {words} 'c'"
    assert str(InputError(message)) == message


def test_what_python_says_of_itself_is_not_repeated():
    for error in (KeyError("S"), TypeError("'NoneType' object is not iterable")):
        assert one_line(error) == "its parts do not fit together"
    assert one_line(struct.error("unpack requires a buffer")) == "it ends too early"
    assert one_line(OSError("no space")) == "no space"
