"""`export`: the identified model as a URDF, and its matrices in one configuration."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from made_results import REFUSED
from processes import ORBIDENT, finished
from running import LINEAR, Orbident, resealed, worst_error, written
from scipy.io import loadmat

from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording


@pytest.fixture(scope="module")
def made(flight: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a RUN and its recording, which every test copies."""
    folder = tmp_path_factory.mktemp("made")
    written(flight, folder / "r.parquet")
    identify = ("identify", "paper-spatial", "r.parquet", *LINEAR, "-o", "run")
    ran = finished(*ORBIDENT, *identify, "--quiet", cwd=folder)
    assert (ran.returncode, ran.stderr) == (0, "")
    return folder


@pytest.fixture
def run(made: Path) -> str:
    shutil.copytree(made, Path(), dirs_exist_ok=True)
    return "run"


def test_urdf(orbident: Orbident, run: str):
    """It is a robot with the identified parameters, for every other verb."""
    words = orbident("export", run, "-o", "identified.urdf").done().out
    assert "identified.urdf: URDF, 4 bodies, base parameters" in words
    text = Path(f"{run}/robot.yaml").read_text()
    Path("identified.yaml").write_text(text.replace("robot.urdf", "identified.urdf"))
    inspected = orbident("inspect", "identified.yaml", "--json", "-").done().json
    result = json.loads(Path(f"{run}/result.json").read_text())
    assert worst_error(result["base"], inspected["base"]) < 1e-9
    told = (
        orbident("export", run, "-o", "identified.urdf", "--force", "--json", "-")
        .done()
        .json
    )
    assert told["deviation"] < 1
    assert sum(told["masses"].values()) == pytest.approx(1110.0)


def test_matrices(orbident: Orbident, run: str):
    orbident("export", run, "-o", "at.json", "--q", "-0.1,0.2, 3e-1").done()
    document = json.loads(Path("at.json").read_text())
    assert document["q"] == {"joint1": -0.1, "joint2": 0.2, "joint3": 0.3}
    H = np.array(document["H_plus"])
    assert H.shape == (12, 12)
    assert len(document["speeds"]) == 12
    np.testing.assert_allclose(H, H.T, atol=1e-9)
    # Eq. 14: the total mass, and the wheels' inertia.
    np.testing.assert_allclose(np.diag(H)[:3], 1110.0, rtol=1e-9)
    np.testing.assert_allclose(np.diag(H)[9:], 0.18, rtol=1e-12)
    assert np.array(document["H_plus_std"]).shape == (12, 12)
    assert {np.array(J).shape for J in document["jacobians"].values()} == {(6, 12)}


def test_models_of_other_tools(orbident: Orbident, run: str):
    """Each file begins as its format does; what is in it: `tests/oracles`."""
    for name, begins, words in (
        ("r.xml", "<mujoco", "MJCF for MuJoCo, 4 bodies"),
        ("r.sdf", "<?xml", "SDF for Gazebo, 4 bodies"),
        ("r.py", '"""The spacecraft paper-spatial', "a script for Basilisk, 4 bodies"),
    ):
        assert words in orbident("export", run, "-o", name).done().out
        assert Path(name).read_text().startswith(begins)
    told = orbident("export", run, "-o", "r.xml", "--force", "--json", "-").done().json
    assert sum(told["masses"].values()) == pytest.approx(1110.0)


def test_matlab(orbident: Orbident, run: str):
    words = orbident("export", run, "-o", "r.mat").done().out
    assert "r.mat: 42 parameters" in words
    # By SciPy, and by our own reader of such files: signals are topics.
    found = loadmat("r.mat", simplify_cells=True)["identified"]
    assert found["mass"]["value"] == pytest.approx(1110.0)
    listed = orbident("topics", "r.mat").done().out
    assert "/identified/signals/velocity" in listed


def test_equations_in_c_and_matlab(orbident: Orbident, run: str):
    """What is in them: `tests/oracles/test_generated_code.py`."""
    words = orbident("export", run, "-o", "servicer.c").done().out
    assert "servicer.c: C99, H_plus(q, H) and c_plus(q, v, c)" in words
    assert (
        "void H_plus(const double q[], double H[12][12]);"
        in Path("servicer.c").read_text()
    )
    words = orbident("export", run, "-o", "servicer.m").done().out
    assert "servicer.m: MATLAB, [H, c] = servicer(q, v)" in words
    text = Path("servicer.m").read_text()
    assert text.startswith("function [H, c] = servicer(q, v)\n")
    orbident("export", run, "-o", "my-robot.m").refused(
        "cannot be the name of this function"
    )
    assert not Path("my-robot.m").exists()


def test_messages(orbident: Orbident, run: str):
    """With the recording that the RUN is from, its signals too; with another not."""
    arguments = ("export", run, "-o", "r.mcap", "--force", "--json", "-", "--recording")
    own = orbident(*arguments, "r.parquet").done().json
    assert own["messages"]["/imu/predicted"] == own["messages"]["/joint_states"]
    assert own["messages"]["/signals/velocity/predicted"] > 0
    recording = read_recording("r.parquet")
    written(recording, "other.parquet", rows=slice(0, 100))
    other = orbident(*arguments, "other.parquet").done().json
    assert other["messages"]["/joint_states"] == 100
    assert not any(topic.startswith("/signals") for topic in other["messages"])
    # `convert` reads it as any other bag.
    assert "/joint_states" in orbident("topics", "r.mcap").done().out


def test_refusals_of_messages(orbident: Orbident, run: str):
    def refused(*arguments: str, words: str):
        orbident("export", run, "-o", "a.mcap", *arguments).refused(words)

    refused(words="a RUN does not keep how the joints moved")
    refused("--recording", "gone.csv", words="gone.csv")
    written(read_recording("r.parquet"), "bare.csv", drop=("gyro", "attitude"))
    refused("--recording", "bare.csv", words="column 'gyro.x' is missing")
    assert not Path("a.mcap").exists()


def test_parameters_for_a_spreadsheet(orbident: Orbident, run: str):
    words = orbident("export", run, "-o", "p.csv").done().out
    result = json.loads(Path(f"{run}/result.json").read_text())
    with Path("p.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert f"p.csv: {len(rows)} parameters" in words
    for name in ("base", "phi", "pi"):
        own = [row for row in rows if row["set"] == name]
        assert [row["parameter"] for row in own] == result[name]["names"]
        assert [row["formula"] for row in own] == result[name]["formulas"]
        for key, column in (("values", "estimate"), ("std", "std")):
            read = [float(row[column]) if row[column] else None for row in own]
            assert read == result[name][key]


def test_parameters_for_a_paper(orbident: Orbident, run: str):
    orbident("export", run, "-o", "p.tex").done()
    text = Path("p.tex").read_text()
    result = json.loads(Path(f"{run}/result.json").read_text())
    rows = [line for line in text.splitlines() if line.endswith(r"\\")]
    count = sum(len(result[name]["names"]) for name in ("base", "phi", "pi"))
    assert len(rows) == 1 + count
    assert {row.count("&") for row in rows} == {4}
    assert rows[1].startswith("$M$ & $1110.")
    assert rows[1].endswith(r"& kg \\")
    assert text.count("$") % 2 == 0
    for k, row in enumerate(rows[1 : 1 + len(result["base"]["names"])]):
        _, estimate, std, *_ = (cell.strip(" $") for cell in row.split("&"))
        off = abs(float(estimate) - result["base"]["values"][k])
        assert off <= 0.051 * result["base"]["std"][k]
        assert float(std) == pytest.approx(result["base"]["std"][k], rel=0.051)


def test_refusals(orbident: Orbident, run: str):
    def refused(*arguments: str, words: str):
        orbident("export", *arguments).refused(words)

    refused(
        run, "-o", "a.zip", words="a.zip: give a name that ends in .urdf, .xml, .sdf"
    )
    refused(run, "-o", "a", words=".mcap, .mat, .csv, .tex or .json")
    refused(run, "-o", "a.json", words="give it with --q")
    refused(run, "-o", "a.urdf", "--q", "0,0,0", words="holds in every position")
    refused(run, "-o", "a.json", "--q", "0,0", words="expected 3 finite numbers")
    refused(run, "-o", "a.json", "--q", "0,nan,0", words="expected 3 finite numbers")
    refused(run, "-o", "a.json", "--q", "0;0", words="--q: found '0;0'")
    refused(run, "-o", "no/a.urdf", words="folder 'no' does not exist")
    refused("gone", "-o", "a.urdf", words="gone/result.json: cannot be read")
    assert not list(Path().glob("a.*"))


def test_a_rejected_run(orbident: Orbident, run: str):
    path = Path(run) / "result.json"
    document = json.loads(path.read_text())
    document["checks"].append(REFUSED.to_json())
    path.write_text(json.dumps(document))
    resealed(Path(run))
    for arguments in (
        *(
            ("-o", f"a{suffix}")
            for suffix in (".urdf", ".xml", ".sdf", ".py", ".c", ".m", ".mat")
        ),
        ("-o", "a.json", "--q", "0,0,0"),
        ("-o", "a.mcap", "--recording", "r.parquet"),
    ):
        orbident("export", run, *arguments).refused("is refused", "mass: no scale")
    assert not list(Path().glob("a.*"))


def test_no_physical_body(orbident: Orbident, run: str):
    """Link 3 would have less inertia than its first moment needs, with certainty."""
    path = Path(run) / "result.json"
    document = json.loads(path.read_text())
    values = document["base"]["values"]
    values[document["base"]["formulas"].index("Iyy(link3)")] = 1.0
    path.write_text(json.dumps(document))
    resealed(Path(run))
    ran = orbident("export", run, "-o", "a.urdf")
    assert ran.status == 1
    assert "a.urdf is not written: no bodies that can exist" in ran.err
    assert ran.err.count("\n") == 1
    assert not Path("a.urdf").exists()


def test_a_filter_for_flight(orbident: Orbident, run: str):
    recorded = ("--recording", "r.parquet")
    told = orbident("export", run, "--flight", "f", *recorded, "--json", "-").done()
    assert told.json["folder"] == "f"
    assert told.json["memory"] > told.json["state"] > 1000
    there = {path.name for path in Path("f").iterdir()}
    code = {"CMakeLists.txt", "flight.cpp", "main.c", "include", "eigen"}
    assert there == code | {"README.md", "LICENSE", "robot.h", "golden.h"}
    assert "Mozilla Public License" in Path("f/eigen/MPL-2.0.txt").read_text()
    assert (
        f"#define GOLDEN_STEPS {told.json['steps']}" in Path("f/golden.h").read_text()
    )
    # A robot file will do, of the same robot with the same numbers.
    orbident("export", "paper-spatial", "--flight", "g", *recorded, "--quiet").done()
    assert Path("g/robot.h").read_text() == Path("f/robot.h").read_text()
    again = ("export", "paper-spatial", "--flight", "g", *recorded, "--quiet")
    orbident(*again).refused("g: exists already; name another, or use --force")
    orbident(*again, "--force").done()


def test_refusals_of_a_filter_for_flight(orbident: Orbident, run: str):
    recorded = ("--recording", "r.parquet")

    def refused(*arguments: str, words: str):
        orbident("export", run, *arguments).refused(words)

    refused(words="give either -o FILE or --flight DIR")
    refused("-o", "a.urdf", "--flight", "f", words="give either -o FILE or --flight")
    refused("--flight", "f", words="give --recording REC")
    refused("-o", "a.urdf", *recorded, words="--recording: is for .mcap and --flight")
    refused("--flight", "f", "--q", "0", *recorded, words="--q: is for a .json")
    refused("--flight", run, *recorded, words="run: holds something else than a filter")
    assert not Path("f").exists()
