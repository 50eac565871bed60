"""Each preset on a file as its laboratory or tool writes it."""

from pathlib import Path

import numpy as np
import pytest
from bag_writers import START, float64, imu, joint_state, pose, write_bag
from log_writers import write_log, write_ulog
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import ConversionReport, convert_file
from orbident.recordings.topics.presets import preset_path, presets
from orbident.recordings.topics.survey import survey_file
from orbident.recordings.topics.topic_map import load_topic_map, proposed_map

N = 20
T = np.arange(N) * 0.01
NS = START + np.round(T * 1e9).astype(int)
RNG = np.random.default_rng(5)
X_WB = Rotation.random(N, RNG)
W, P, V = RNG.normal(size=(3, N, 3))


def near(found: np.ndarray, expected: np.ndarray, atol: float = 1e-12) -> None:
    """Whole nanoseconds, and some products and sums of float64."""
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=atol)


def by_preset(path: Path, name: str) -> tuple[Recording, ConversionReport]:
    out = path.parent / "r.parquet"
    report = convert_file(path, name, out)
    return read_recording(out), report


def check_attitude(recording: Recording, expected: Rotation) -> None:
    x = Rotation.from_quat(recording.vector("attitude", "xyzw"))
    np.testing.assert_allclose((x * expected.inv()).magnitude(), 0, atol=1e-7)


def test_all_are_tried_here():
    assert presets() == (
        "astrobee",
        "basilisk",
        "cepheus",
        "kentucky",
        "nasa-42",
        "optitrack",
        "phasespace",
        "px4-spacecraft",
        "spot",
        "xact",
    )
    for name in presets():
        assert load_topic_map(preset_path(name))


def test_cepheus(tmp_path: Path):
    """Numbers without stamps, written together; of its three joints, two are there."""
    angles = {"q1": T, "q2": 2 * T, "theta0": 3 * T}
    rates = {"q1dot": 0 * T + 1, "theta0dot": 0 * T + 3, "torquerw": 0 * T}
    sent = [
        float64(f"/cepheus/{name}", int(NS[k]), values[k])
        for k in range(N)
        for name, values in {**angles, **rates}.items()
    ]
    recording, report = by_preset(write_bag("ros1", tmp_path, sent), "cepheus")
    np.testing.assert_array_equal(recording.column("joint.joint2.position"), 2 * T)
    np.testing.assert_array_equal(recording.vector("gyro")[0], [0, 0, 3])
    check_attitude(recording, Rotation.from_rotvec(np.outer(3 * T, [0, 0, 1])))
    (warning,) = report.warnings
    assert warning == (
        "preset 'cepheus': the file has no topic '/cepheus/q3', '/cepheus/q2dot', "
        "'/cepheus/q3dot': left out"
    )


def test_astrobee(tmp_path: Path):
    """The IMU's x is the body's y: it is turned by a quarter of a turn about z."""
    names = ["top_aft_arm_proximal_joint", "top_aft_arm_distal_joint"]
    sent = []
    for k, ns in enumerate(map(int, NS)):
        sent += [
            joint_state("/joint_states", ns, ns, [*names, "gripper"], [T[k], -T[k], 0]),
            pose("/loc/pose", ns, ns, X_WB[k].as_quat(), P[k]),
            imu("/hw/imu", ns, ns, [1, 2, 3]),
        ]
    recording, report = by_preset(write_bag("ros1", tmp_path, sent), "astrobee")
    assert report.warnings == ()
    np.testing.assert_array_equal(recording.column(f"joint.{names[1]}.position"), -T)
    near(recording.vector("gyro")[0], np.array([-2, 1, 3]), atol=1e-7)
    near(recording.vector("position"), P)
    check_attitude(recording, X_WB)


FLU = Rotation.from_euler("x", 180, degrees=True)
"""Forward, left, up in PX4's forward, right, down."""


def test_px4(tmp_path: Path):
    stamps = {"timestamp": np.round(T * 1e6)}
    q = (X_WB * FLU.inv()).as_quat()[:, [3, 0, 1, 2]]
    named = zip(("x", "y", "z", "vx", "vy", "vz"), [*P.T, *V.T], strict=True)
    path = write_ulog(
        tmp_path / "log.ulg",
        {
            "vehicle_angular_velocity": {**stamps, "xyz": FLU.inv().apply(W)},
            "vehicle_attitude": {**stamps, "q": q},
            "vehicle_local_position": {**stamps, **dict(named)},
        },
    )
    proposal = proposed_map(survey_file(path))
    assert "# '--preset px4-spacecraft' maps topics of this file" in proposal
    recording, report = by_preset(path, "px4-spacecraft")
    assert report.warnings == ()
    near(recording.vector("gyro"), W)
    near(recording.vector("velocity"), V)
    check_attitude(recording, X_WB)


def test_basilisk(tmp_path: Path):
    """`sigma_BN` as Basilisk defines it: [BN] turns from inertial to body axes."""
    times = {"times": (T * 1e9).round().astype(np.uint64)}
    spacecraft = {"sigma_BN": X_WB.as_mrp(), "omega_BN_B": W, "r_BN_N": P, "v_BN_N": V}
    path = write_log(
        "npz",
        tmp_path,
        {
            "scStateOutMsg": {**times, **spacecraft},
            "spinningBodyOutMsgs.0": {**times, "theta": T, "thetaDot": 0 * T + 1},
            "rwSpeedOutMsg": {**times, "wheelSpeeds": np.ones((N, 36)) * range(36)},
        },
    )
    recording, report = by_preset(path, "basilisk")
    np.testing.assert_array_equal(recording.column("joint.joint1.position"), T)
    np.testing.assert_array_equal(recording.column("wheel.rw3.speed"), 0 * T + 2)
    np.testing.assert_array_equal(recording.vector("gyro"), W)
    check_attitude(recording, X_WB)
    # The definition of [BN] by the parameters (Schaub and Junkins, Eq. 3.152).
    s = spacecraft["sigma_BN"][4]
    cross = np.cross(s, np.eye(3)).T
    BN = np.eye(3) + (8 * cross @ cross - 4 * (1 - s @ s) * cross) / (1 + s @ s) ** 2
    x_4 = recording.vector("attitude", "xyzw")[4]
    np.testing.assert_allclose(Rotation.from_quat(x_4).as_matrix().T, BN, atol=1e-12)
    (warning,) = report.warnings
    assert "no topic '/spinningBodyOutMsgs/1'" in warning


def proposed(path: Path, name: str) -> bool:
    return f"'--preset {name}' maps" in proposed_map(survey_file(path))


def test_xact(tmp_path: Path):
    """Counts of int16 and int32, time in 0.2 s; three of four wheels are there."""
    q, rpm = np.round(X_WB.as_quat() / 5e-10), np.arange(3 * N).reshape(N, 3) * 40
    names = [f"Q_BODY_WRT_ECI{k}" for k in "1234"] + [f"BODY_RATE{k}" for k in "123"]
    names += [f"FILTERED_SPEED_RPM{k}" for k in "123"]
    seconds = 4_100_000_000 + np.arange(N)
    values = np.c_[seconds, q, np.round(W / 5e-9), rpm / 0.4].astype(np.int64)
    path = tmp_path / "adcs.csv"
    head = ",".join(["TAI_SECONDS", *names])
    np.savetxt(path, values, "%d", ",", header=head, comments="")
    assert proposed(path, "xact")
    assert not proposed(path, "optitrack")
    recording, report = by_preset(path, "xact")
    np.testing.assert_allclose(recording.t, 0.2 * np.arange(N), atol=1e-9)
    check_attitude(recording, X_WB)
    near(recording.vector("gyro"), W, atol=2.5e-9)
    near(recording.column("wheel.rw3.speed"), rpm[:, 2] * np.pi / 30)
    assert report.warnings == (
        "preset 'xact': the file has no field 'FILTERED_SPEED_RPM4': left out",
    )


def test_nasa_42(tmp_path: Path):
    """`C[0][1] = 2 (q1 q2 + q3 q4)` of 42's Q2C is of the matrix from N to B."""
    folder = tmp_path / "InOut"
    folder.mkdir()
    tables = {"time": T, "qbn": X_WB.as_quat(), "wbn": W, "PosN": np.c_[P, P, P]}
    for name, values in tables.items():
        np.savetxt(folder / f"{name}.42", values, "%le")
    assert proposed(folder, "nasa-42")
    recording, report = by_preset(folder, "nasa-42")
    assert report.warnings == ()
    q = X_WB.as_quat()
    of_42 = 2 * (q[:, 0] * q[:, 1] + q[:, 2] * q[:, 3])
    near(of_42, X_WB.inv().as_matrix()[:, 0, 1])
    check = Rotation.from_quat(recording.vector("attitude", "xyzw")) * X_WB.inv()
    np.testing.assert_allclose(check.magnitude(), 0, atol=3e-6)  # six digits
    near(recording.vector("gyro"), W, atol=1e-6)


def test_optitrack(tmp_path: Path):
    """Motive's export of one rigid body; nothing where it was not seen."""
    head = [
        "Format Version,1.23,Take Name,run,Rotation Type,Quaternion",
        "",
        ",Type," + ",".join(["Rigid Body"] * 8),
        ",Name," + ",".join(["base"] * 8),
        ',ID,"' + '","'.join(["3C5A"] * 8) + '"',
        ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Error",
        "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,",
    ]
    rows = [
        ",".join([str(k), f"{t:.6f}", *(f"{x:.9f}" for x in (*q, *p)), "0.0001"])
        for k, (t, q, p) in enumerate(zip(T, X_WB.as_quat(), P, strict=True))
    ]
    rows[4] = f"4,{T[4]:.6f},,,,,,,,"
    path = tmp_path / "Take 1.csv"
    path.write_bytes("\r\n".join([*head, *rows]).encode("utf-8-sig"))
    assert proposed(path, "optitrack")
    recording, report = by_preset(path, "optitrack")
    assert report.topics[0].not_finite == 1
    near(np.delete(recording.vector("position"), 4, 0), np.delete(P, 4, 0), 1e-9)
    x = Rotation.from_quat(np.delete(recording.vector("attitude", "xyzw"), 4, 0))
    difference = x * X_WB[np.arange(N) != 4].inv()
    np.testing.assert_allclose(difference.magnitude(), 0, atol=1e-8)


def test_phasespace(tmp_path: Path):
    """Millimetres and the scalar first; zeros where the body was not seen."""
    x, y, z, w = X_WB.as_quat().T
    table = np.c_[1000 * T, 1000 * P, w, x, y, z]
    table[4, 1:] = 0.0
    path = tmp_path / "Body 01.csv"
    np.savetxt(path, table, "%.9f", ",")
    assert proposed(path, "phasespace")
    recording, _ = by_preset(path, "phasespace")
    seen = np.arange(N) != 4
    near(recording.vector("position")[seen], P[seen], 1e-9)
    assert np.isnan(recording.vector("position")[4]).all()
    turned = Rotation.from_quat(recording.vector("attitude", "xyzw")[seen])
    np.testing.assert_allclose((turned * X_WB[seen].inv()).magnitude(), 0, atol=1e-7)


def test_kentucky(tmp_path: Path):
    """Millimetres, degrees, and eight valves in one cell."""
    rows = [
        f'{t},{t + 1},{1000 * t},{-2000 * t},{90 * t},"[{k % 2}, 0, 0, 0, 0, 0, 0, 1]"'
        for k, t in enumerate(T)
    ]
    head = "MPC_Start_Time,Command_Sent_Time,Telemetry_X_mm,Telemetry_Z_mm"
    path = tmp_path / "real.csv"
    path.write_text("\n".join([f"{head},Telemetry_Yaw_deg,Command_Vector", *rows]))
    assert proposed(path, "kentucky")
    recording, report = by_preset(path, "kentucky")
    assert report.warnings == ()
    near(recording.vector("position"), np.c_[T, -2 * T, 0 * T])
    check_attitude(recording, Rotation.from_rotvec(np.outer(np.pi / 2 * T, [0, 0, 1])))
    np.testing.assert_array_equal(
        recording.column("thruster.t1.duty"), np.arange(N) % 2
    )
    np.testing.assert_array_equal(recording.column("thruster.t8.duty"), 1)


def test_spot(tmp_path: Path):
    names = ("RED_Px_m", "RED_Py_m", "RED_Rz_rad", "ARM_Shoulder_Rz_rad")
    names += ("ARM_Elbow_Rz_rad", "ARM_Wrist_Rz_rad")
    table = {"Time_s": T, **{name: k * T for k, name in enumerate(names)}}
    path = write_log("mat", tmp_path, {"dataClass": table})
    assert proposed(path, "spot")
    recording, report = by_preset(path, "spot")
    assert report.warnings == ()
    near(recording.column("position.y"), T)
    near(recording.column("joint.wrist.position"), 5 * T)
    check_attitude(recording, Rotation.from_rotvec(np.outer(2 * T, [0, 0, 1])))


def test_none_of_its_topics(tmp_path: Path):
    path = write_log("npz", tmp_path, {"flight": {"t": T, "x": T}})
    with pytest.raises(InputError) as raised:
        convert_file(path, "basilisk", tmp_path / "r.csv")
    assert str(raised.value) == (
        f"{path}: has none of the topics of preset 'basilisk', only '/flight'; write a "
        "map: 'orbident topics' proposes one"
    )
