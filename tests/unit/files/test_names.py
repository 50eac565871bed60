from orbident.files.names import closest, first_duplicate, suggestion


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
