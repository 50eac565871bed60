"""A clip shows the motion: how many frames, how large, and what is red in them."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from random_motions import random_motion

from orbident.errors import InputError
from orbident.report.clip import check_clip, split, write_clip
from orbident.robot.robot_file import load_robot
from orbident.scene.replay import Replay, recorded_motion
from orbident.scene.scene import scene_of
from orbident.simulation.simulate import simulate

LEGEND = 80
"""Rows of pixels with words."""


@pytest.fixture(scope="module")
def replay() -> Replay:
    """A ghost that stays on the measured robot, and one that turns by 30 degrees."""
    robot = load_robot("paper-spatial")
    found = recorded_motion(robot, simulate(robot, random_motion(robot, duration=6.0)))
    measured = found.measured
    half = np.radians(30) / 2 * (measured.t - measured.t[0]) / measured.t[-1]
    x, y, z, w = measured.x_WB.T
    # The product with a turn about the base's z axis.
    s, c = np.sin(half), np.cos(half)
    turned = np.column_stack(
        [x * c + y * s, y * c - x * s, z * c + w * s, w * c - z * s]
    )
    return found._replace(predicted=measured, by_cad=measured._replace(x_WB=turned))


@pytest.fixture(scope="module")
def clip(replay: Replay, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clip") / "clip.gif"
    done: list[float] = []
    count = write_clip(scene_of(load_robot("paper-spatial")), replay, path, done.append)
    assert len(done) == count
    assert done[-1] == 1.0
    return path


def frames(path: Path) -> list[np.ndarray]:
    """Below the legend."""
    with Image.open(path) as clip:
        found = []
        for k in range(clip.n_frames):  # pyright: ignore[reportAttributeAccessIssue]
            clip.seek(k)
            found.append(np.array(clip.convert("RGB"), int)[LEGEND:])
    return found


@pytest.mark.slow
def test_it_is_small_and_short(clip: Path, replay: Replay):
    assert clip.stat().st_size < 5_000_000
    with Image.open(clip) as opened:
        assert opened.size == (640, 480)
        assert opened.info["loop"] == 0
        # At most 100 of 121 samples: every second one.
        assert replay.measured.t.size == 121
        assert opened.n_frames == 61  # pyright: ignore[reportAttributeAccessIssue]
        shown = 0
        for k in range(61):
            opened.seek(k)
            shown += opened.info["duration"]
    assert shown == 60 * 100 + 2000


@pytest.mark.slow
def test_the_ghost_of_cad_leaves(clip: Path):
    red = []
    for frame in frames(clip):
        r, g, b = np.moveaxis(frame, 2, 0)
        # Darker in the shade; the marks of wheels are paler.
        red.append(int(((r > 90) & (g < 0.3 * r) & (b < 0.35 * r)).sum()))
        # The other ghost is behind the measured robot all the time.
        assert not ((b > 100) & (r < 0.6 * b)).any()
        assert (r < 250).sum() > 10_000
    assert red[0] == 0
    assert 0 < red[10] < red[20] < red[30]
    # The base alone is 100 pixels high, and at the end the ghost is 30 degrees away.
    assert red[-1] > 500


@pytest.mark.slow
def test_without_a_model_only_the_measured_robot_is_there(
    replay: Replay, tmp_path: Path
):
    few = replay.measured.thinned(4)
    alone = replay._replace(measured=few, predicted=None, by_cad=None, model=None)
    write_clip(scene_of(load_robot("paper-spatial")), alone, tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as opened:
        words = np.array(opened.convert("RGB"), int)[:LEGEND, :320]
    # Of three rows of the legend there is one.
    assert (words[:30] < 200).any()
    assert (words[30:] == 255).all()


def test_halved_triangles_cover_the_same():
    triangles = np.random.default_rng(5).normal(size=(50, 3, 3))
    longest = 0.3
    parts = split(triangles, longest)
    lengths = np.linalg.norm(np.roll(parts, -1, axis=1) - parts, axis=2)
    assert lengths.max() <= longest

    def vector_area(each: np.ndarray) -> np.ndarray:
        return np.cross(each[:, 1] - each[:, 0], each[:, 2] - each[:, 0]) / 2

    whole = np.linalg.norm(vector_area(triangles), axis=1).sum()
    assert np.linalg.norm(vector_area(parts), axis=1).sum() == pytest.approx(whole)
    # None is turned round.
    total = vector_area(triangles).sum(axis=0)
    np.testing.assert_allclose(vector_area(parts).sum(axis=0), total, atol=1e-12)


@pytest.mark.parametrize("name", ["clip.mp4", "clip", "clip.gif.txt"])
def test_other_names_are_refused(name: str):
    with pytest.raises(InputError, match=r"the name of a clip ends in \.gif"):
        check_clip(Path(name))


def test_a_place_that_is_none(replay: Replay, tmp_path: Path):
    with pytest.raises(InputError, match="does not exist; create it"):
        write_clip(
            scene_of(load_robot("paper-spatial")),
            replay._replace(
                measured=replay.measured.thinned(4), predicted=None, by_cad=None
            ),
            tmp_path / "gone" / "a.gif",
        )
