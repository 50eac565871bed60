"""Joints that follow others: through others, in a circle, or what does not move."""

from pathlib import Path

import pytest
from urdf_texts import joint, link, robot

from orbident.errors import InputError
from orbident.robot.robot_file import load_robot

MIMIC = '<mimic joint="{}" multiplier="{}" offset="{}"/>'


def hand(*mimics: str, kinds: str = "revolute") -> str:
    """A base with fingers `f0`, `f1` and so on, and what each mimics."""
    fingers = range(len(mimics))
    return robot(
        link("base"),
        *(link(f"l{k}") for k in fingers),
        *(
            joint(f"f{k}", "base", f"l{k}", kind=kinds if k == 0 else "revolute",
                  inside=mimics[k])
            for k in fingers
        ),
    )  # fmt: skip


def load(folder: Path, text: str):
    (folder / "hand.urdf").write_text(text)
    return load_robot(folder / "hand.urdf")


def test_a_follower_of_a_follower(tmp_path: Path):
    text = hand("", MIMIC.format("f0", 2, 0.1), MIMIC.format("f1", -3, 1))
    # q_2 = -3 (2 q_0 + 0.1) + 1
    first, second = load(tmp_path, text).couplings
    assert first == ("f1", "f0", 2.0, 0.1)
    assert second == ("f2", "f0", -6.0, pytest.approx(0.7, rel=1e-15))


def test_what_does_not_move_is_not_followed(tmp_path: Path):
    found = load(tmp_path, hand("", MIMIC.format("f0", 2, 0), kinds="fixed"))
    assert found.couplings == ()
    (warning,) = found.warnings
    assert warning.startswith("joint 'f1' mimics 'f0', which is no joint that moves")


@pytest.mark.parametrize(
    ("mimics", "words"),
    [
        (("", MIMIC.format("f9", 1, 0)), "joint 'f1': <mimic>: no joint 'f9'; known"),
        (("", MIMIC.format("f1", 1, 0)), "joint 'f1' mimics itself by way of 'f1'"),
        (
            (MIMIC.format("f1", 1, 0), MIMIC.format("f0", 1, 0)),
            "joint 'f0' mimics itself by way of 'f0'",
        ),
        (("", MIMIC.format("f0", "two", 0)), "<mimic multiplier>: found 'two'"),
    ],
)
def test_what_is_refused(tmp_path: Path, mimics: tuple[str, ...], words: str):
    with pytest.raises(InputError, match=words):
        load(tmp_path, hand(*mimics))
