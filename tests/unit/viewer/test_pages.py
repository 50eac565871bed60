"""Pages follow their controls; no browser is needed for that."""

import dataclasses
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording
from orbident.robot.robot_file import load_robot
from orbident.scene.replay import (
    BasePose,
    Replay,
    centroidal_momentum,
    inertia_ellipsoids,
    placed,
    reaction,
    recorded_motion,
)
from orbident.scene.scene import scene_of
from orbident.simulation.simulate import simulate
from orbident.viewer.pages import ReplayPage, SlidersPage, prepared, slow_motion
from orbident.viewer.stage import Plot, heading

ROBOT = "cepheus-like"


def at(server: Any, node: str) -> np.ndarray:
    return np.array(server.scene.get_handle_by_name(node).position)


def control(server: Any, label: str) -> Any:
    handles = server.gui._gui_input_handle_from_uuid.values()
    (found,) = (h for h in handles if getattr(h, "label", None) == label)
    return found


@pytest.fixture(scope="module")
def replay():
    robot = load_robot(ROBOT)
    motion = random_motion(robot, duration=5.0)
    return recorded_motion(robot, simulate(robot, motion))


def test_playing_moves_the_robot_and_stops_at_the_end(server: Any, replay):
    page = ReplayPage(server, scene_of(load_robot(ROBOT)), replay, "title")
    time = control(server, "Time, s")
    before = at(server, "/robot/2")
    page.advance(1.0)
    assert time.value == 0.0
    page._pressed = True
    page.advance(1.5)
    assert time.value == 1.5
    moved = at(server, "/robot/2")
    # The arm is 0.5 m long.
    assert np.linalg.norm(moved - before) > 0.01
    # As computed; the page follows the CM.
    found = placed(scene_of(load_robot(ROBOT)), replay.measured, np.zeros((501, 1)))
    r_cm = centroidal_momentum(load_robot(ROBOT), replay.measured).r_cm
    assert np.allclose(moved, found.p[150, 2] - r_cm[150], atol=1e-12)
    control(server, "Speed").value = "10"
    page.advance(1.0)
    assert time.value == 5.0
    page.advance(1.0)
    assert np.allclose(at(server, "/robot/2"), found.p[500, 2] - r_cm[500], atol=1e-12)
    page._pressed = True
    page.advance(0.01)
    assert time.value == pytest.approx(0.1)


def test_a_loop_begins_again(server: Any, replay):
    page = ReplayPage(server, scene_of(load_robot(ROBOT)), replay, "title")
    control(server, "Loop").value = True
    page._pressed = True
    page.advance(6.0)
    assert control(server, "Time, s").value == 0.0
    page.advance(0.5)
    assert control(server, "Time, s").value == 0.5


def test_names_are_at_the_frames_where_they_are_wanted(server: Any, replay):
    robot = load_robot(ROBOT)
    page = ReplayPage(server, scene_of(robot), replay, "title")
    names = [
        server.scene.get_handle_by_name(f"/robot/{k}/name")
        for k in range(len(robot.bodies) + len(robot.wheels))
    ]
    assert not any(name.visible for name in names)
    control(server, "Names").value = True
    page.advance(0.03)
    assert all(name.visible for name in names)
    wheels = [wheel.name for wheel in robot.wheels]
    assert [name.text for name in names] == [*robot.bodies, *wheels]


def test_scrubbing_and_hiding(server: Any, replay):
    page = ReplayPage(server, scene_of(load_robot(ROBOT)), replay, "title")
    control(server, "Time, s").value = 3.0
    control(server, "Momentum").value = False
    page.advance(0.03)
    assert not server.scene.get_handle_by_name("/momentum").visible
    follow = control(server, "Follow")
    there = at(server, "/robot/0")
    follow.value = False
    page.advance(0.03)
    r_cm = centroidal_momentum(load_robot(ROBOT), replay.measured).r_cm
    moved = at(server, "/robot/0") - there
    assert np.allclose(moved, r_cm[300] - r_cm[0], atol=1e-12)


def test_ghosts_are_where_they_were_predicted_and_can_be_hidden(server: Any, replay):
    up = np.array([0.0, 0.0, 0.2])
    moved = replay.measured._replace(r_S=replay.measured.r_S + up)
    ghosts = replay._replace(predicted=replay.measured, by_cad=moved)
    page = ReplayPage(server, scene_of(load_robot(ROBOT)), ghosts, "title")
    off = at(server, "/cad/1") - at(server, "/robot/1")
    assert np.allclose(off, up, atol=1e-12)
    assert np.allclose(at(server, "/predicted/1"), at(server, "/robot/1"), atol=1e-12)
    control(server, "CAD").value = False
    page.advance(0.03)
    assert not server.scene.get_handle_by_name("/cad").visible
    assert server.scene.get_handle_by_name("/predicted").visible


def test_inertia_is_shown_where_it_is_wanted(server: Any):
    robot = load_robot("paper-spatial")
    found = recorded_motion(robot, simulate(robot, random_motion(robot, duration=2.0)))
    heavier = dataclasses.replace(robot, theta=1.5 * robot.theta)
    # As if it were identified: lengths do not know of mass, but of how it is spread.
    identified = found._replace(predicted=found.measured, model=heavier)
    page = ReplayPage(server, scene_of(robot), identified, "title")
    balls = [
        server.scene.get_handle_by_name(f"/inertia/{name}")
        for name in ("cad", "identified")
    ]
    assert not any(ball.visible for ball in balls)
    control(server, "Inertia").value = True
    control(server, "Time, s").value = 1.0
    page.advance(0.03)
    assert all(ball.visible for ball in balls)
    assert np.allclose(balls[0].scale, balls[1].scale, rtol=1e-9)
    assert np.allclose(balls[0].position, 0.0, atol=1e-9)
    lengths = inertia_ellipsoids(robot, found.measured).lengths
    (k,) = np.flatnonzero(found.measured.t == 1.0)
    assert np.allclose(balls[0].scale, lengths[k])


def test_inertia_has_ends_where_deviations_are_known(server: Any):
    robot = load_robot("paper-spatial")
    found = recorded_motion(robot, simulate(robot, random_motion(robot, duration=2.0)))
    size = minimal_sets(robot).base.T.shape[0]
    # Of M alone: all squares of half axes are as uncertain as `D / M` makes them.
    root = np.zeros((size, size))
    root[0, 0] = 0.01
    identified = found._replace(predicted=found.measured, root=root)
    ReplayPage(server, scene_of(robot), identified, "title")
    low, middle, high = (
        np.array(server.scene.get_handle_by_name(f"/inertia/{name}").scale)
        for name in ("low", "identified", "high")
    )
    assert np.all(low < middle)
    assert np.all(middle < high)


def test_trails_end_where_the_robot_is(server: Any, replay):
    robot = load_robot(ROBOT)
    page = ReplayPage(server, scene_of(robot), replay, "title")
    trail = server.scene.get_handle_by_name("/trails/0")
    assert not trail.visible
    control(server, "Trails").value = True
    control(server, "Time, s").value = 3.0
    page.advance(0.03)
    assert trail.visible
    assert len(trail.points) > 100
    # As the browser has them, in single precision.
    assert np.allclose(trail.points[-1, 1], at(server, "/robot/0"), atol=1e-6)
    moved = replay.measured.r_S[300] - replay.measured.r_S[0]
    assert np.allclose(trail.points[-1, 1] - trail.points[0, 0], moved, atol=1e-6)
    control(server, "Time, s").value = 0.0
    page.advance(0.03)
    assert len(trail.points) == 0


def test_residuals_have_plots(server: Any, replay):
    def titles(replay: Replay) -> list[str]:
        server.gui.reset()
        page = ReplayPage(server, scene_of(load_robot(ROBOT)), replay, "title")
        return [plot.title for plot in page._plots]

    assert not any(each.startswith("Residual") for each in titles(replay))
    ghost = replay._replace(predicted=replay.measured)
    names = ["base rate, rad/s", "attitude, rad", "position of S, m"]
    assert titles(ghost)[-3:] == [f"Residual {name}" for name in names]
    blind = titles(ghost._replace(velocity_known=False))
    assert blind[-2:] == [f"Residual {name}" for name in names[:2]]


def test_inertia_of_a_robot_on_a_table_is_no_ellipsoid(server: Any, replay):
    ReplayPage(server, scene_of(load_robot(ROBOT)), replay, "title")
    assert not control(server, "Inertia").visible


def test_the_arrows_are_the_momentum(server: Any, replay):
    robot = load_robot(ROBOT)
    page = ReplayPage(server, scene_of(robot), replay, "title")
    control(server, "Time, s").value = 2.0
    page.advance(0.03)
    found = centroidal_momentum(robot, replay.measured)
    points = server.scene.get_handle_by_name("/momentum").points
    lengths = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    h, h_rs, h_rw = (
        np.linalg.norm(x[200])
        for x in (found.h_rs + found.h_rw, found.h_rs, found.h_rw)
    )
    # All three on one scale.
    assert lengths[0] / lengths[1] == pytest.approx(h / h_rs)
    assert lengths[2] / lengths[1] == pytest.approx(h_rw / h_rs)


def test_wheels_turn_so_that_an_eye_can_follow(replay):
    # The wheel spins at 200 rad/s.
    assert slow_motion(replay.measured) == 100.0
    slower = replay.measured._replace(qd_rw=replay.measured.qd_rw / 100)
    assert slow_motion(slower) == 1.0


def test_sliders_move_the_base(server: Any):
    robot = load_robot(ROBOT)
    page = SlidersPage(server, scene_of(robot), robot, "title")
    start = at(server, "/robot/0")
    slider = control(server, "joint1, rad")
    assert (slider.min, slider.max) == (-1.05, 2.5)
    slider.value = 1.0
    page.advance(0.03)
    base = BasePose(np.array([0.0, 0.0, 0.0, 1.0]), start)
    expected = reaction(robot, base, np.zeros(2), np.array([1.0, 0.0]))
    assert np.allclose(at(server, "/robot/0"), expected.r_S, atol=1e-12)
    page._again = True
    page.advance(0.03)
    assert slider.value == 0.0
    assert np.allclose(at(server, "/robot/0"), start, atol=1e-12)


def test_values_that_no_control_offers_change_nothing_else(server: Any, replay):
    robot = load_robot(ROBOT)
    page = SlidersPage(server, scene_of(robot), robot, "title")
    for value, shown in ((1e300, 2.5), (float("nan"), 2.5), (-1e300, -1.05)):
        control(server, "joint1, rad").value = value
        page.advance(0.03)
        assert page._q[0] == shown
    replayed = ReplayPage(server, scene_of(robot), replay, "title")
    control(server, "Speed").value = "fast"
    replayed._pressed = True
    replayed.advance(0.5)
    assert control(server, "Time, s").value == 0.5


def test_hostile_names_are_text():
    contents: list[str] = []
    server: Any = SimpleNamespace(gui=SimpleNamespace(add_html=contents.append))
    heading(server, "<script>alert(1)</script>", '"><img src=x onerror=alert(1)>')
    assert "<script" not in contents[0]
    assert "<img" not in contents[0]


def test_plots_have_few_points_and_a_line(server: Any):
    t = np.linspace(0.0, 10.0, 100_001)
    curves = np.column_stack([np.sin(t), np.cos(t)])
    plot = Plot(server, "title", t, curves, ("a", "<b>"), curves)
    plot.move_to(4.0)
    t_shown, *_, now = plot._handle.data
    assert t_shown.size <= 400
    shown = t_shown[np.isfinite(now)]
    assert np.all(np.abs(shown - 4.0) < 0.06)
    plot.move_to(10.0)
    assert np.isfinite(plot._handle.data[-1]).sum() == 2


def test_what_cannot_be_shown_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="neither a file nor a bundled robot"):
        prepared("cepheus", None)
    with pytest.raises(InputError, match=r"result\.json: cannot be read"):
        prepared(str(tmp_path), None)
    other = Recording(np.arange(2.0), {"joint.joint3.position": np.zeros(2)})
    write_recording(other, tmp_path / "r.csv")
    with pytest.raises(InputError, match="no joint 'joint3'"):
        prepared(ROBOT, tmp_path / "r.csv")


def test_meshes_without_their_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    urdf = tmp_path / "servicer.urdf"
    urdf.write_text(
        '<robot name="r"><link name="a"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
        '<visual><geometry><mesh filename="a.stl"/></geometry></visual></link></robot>'
    )
    _, (warning,) = prepared(str(urdf), None)
    assert warning.startswith("1 meshes are not there")
    (tmp_path / "a.stl").touch()
    monkeypatch.setitem(sys.modules, "trimesh", None)
    _, (warning,) = prepared(str(urdf), None)
    assert warning == (
        'drawing a mesh needs trimesh: pip install "orbident[view]"; collision shapes '
        "or boxes stand for all meshes"
    )
