"""The base installation: each extra that a verb needs is named in one line."""

import subprocess
import sys
from pathlib import Path

import pytest
from processes import finished
from running import LINEAR, Orbident, written
from urdf_pieces import robot_file

from orbident.recordings.recording import Recording

HIDDEN = (
    "import sys; sys.modules.update(dict.fromkeys({}, None)); "
    "from orbident.cli.app import main; main()"
)
"""The command where these libraries cannot be imported."""

REPORT = 'needs plotly: pip install "orbident[report]"'


def without(
    libraries: tuple[str, ...], *arguments: object
) -> subprocess.CompletedProcess[str]:
    return finished(sys.executable, "-c", HIDDEN.format(libraries), *arguments)


@pytest.fixture
def short(flight: Recording) -> Path:
    """A recording that takes little time."""
    return written(flight, "short.csv", rows=slice(0, 400))


def test_identify_and_report(orbident: Orbident, short: Path):
    ran = without(
        ("plotly", "matplotlib"),
        *("identify", "paper-spatial", short, "-o", "run", *LINEAR),
    )
    assert ran.returncode == 0
    assert ran.stderr == (
        f"orbident: warning: the report {REPORT}; run/report.html is not written\n"
    )
    assert not Path("run/report.html").exists()
    refused = without(("plotly",), "report", "run")
    assert refused.returncode == 2
    assert refused.stderr == f"orbident: the report {REPORT}\n"
    # All else is there: with plotly the report can be made later.
    orbident("report", "run").done()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("library", "need"), [("plotly", "the report"), ("matplotlib", "drawing a figure")]
)
def test_study(library: str, need: str):
    ran = without((library,), "study", "spatial", "-o", "kept")
    assert ran.returncode == 0
    assert ran.stderr == (
        f'orbident: warning: {need} needs {library}: pip install "orbident[report]"; '
        "kept is kept without its report and pictures\n"
    )
    names = {path.name for path in Path("kept").iterdir()}
    assert names >= {"trajectory.yaml", "recording.csv", "run"}
    assert "report.html" not in names
    assert Path("kept/run/result.json").exists()


@pytest.mark.slow
def test_export(orbident: Orbident, short: Path):
    orbident("identify", "paper-spatial", short, "-o", "run", *LINEAR).done()
    ran = without(("cvxpy",), "export", "run", "-o", "robot.urdf")
    assert ran.returncode == 2
    assert ran.stderr == (
        "orbident: the search for physically possible bodies needs cvxpy: "
        'pip install "orbident[export]"\n'
    )

    recorded = ("--recording", short)
    ran = without(("mcap",), "export", "run", "-o", "flight.mcap", *recorded)
    assert ran.returncode == 2
    assert ran.stderr == (
        'orbident: reading or writing a bag needs mcap: pip install "orbident[ros]"\n'
    )
    # What is known of the parameters needs no library but SciPy.
    assert without(("cvxpy", "mcap"), "export", "run", "-o", "p.mat").returncode == 0


@pytest.mark.parametrize("library", ["rosbags", "mcap"])
def test_bags(library: str):
    Path("flight.mcap").write_bytes(b"")
    ran = without((library,), "topics", "flight.mcap")
    assert ran.returncode == 2
    assert ran.stderr == (
        f"orbident: reading or writing a bag needs {library}: "
        'pip install "orbident[ros]"\n'
    )


@pytest.mark.parametrize(
    ("library", "content", "need"),
    [
        (
            "h5py",
            b"\x89HDF\r\n\x1a\n",
            "reading HDF5, which MATLAB's -v7.3 files are too, needs h5py: "
            'pip install "orbident[hdf5]"',
        ),
        (
            "pyulog",
            b"ULog\x01\x12\x35\x01",
            'reading a PX4 log needs pyulog: pip install "orbident[ulog]"',
        ),
    ],
)
def test_logs(library: str, content: bytes, need: str):
    name = {"h5py": "flight.h5", "pyulog": "flight.ulg"}[library]
    Path(name).write_bytes(content)
    ran = without((library,), "topics", name)
    assert ran.returncode == 2
    assert ran.stderr == f"orbident: {need}\n"
    # Without any extra, the others are read.
    Path("flight.csv").write_text("t,x\n0,1\n1,2\n")
    assert without((library, "rosbags", "mcap"), "topics", "flight.csv").returncode == 0


def test_view():
    ran = without(("viser",), "view", "paper-spatial")
    assert ran.returncode == 2
    assert ran.stderr == (
        'orbident: the viewer needs viser: pip install "orbident[view]"\n'
    )


@pytest.mark.slow
def test_a_clip_needs_no_viewer():
    clip = ("view", "paper-spatial", "--record", "clip.gif")
    ran = without(("matplotlib",), *clip)
    assert ran.returncode == 2
    assert ran.stderr == (
        'orbident: drawing a figure needs matplotlib: pip install "orbident[report]"\n'
    )
    ran = without(("viser",), *clip)
    assert ran.returncode == 2
    assert ran.stderr.startswith("orbident: --record: there is no motion to draw")


@pytest.mark.parametrize(
    ("name", "text", "library", "need"),
    [
        ("r.xml", "<mujoco/>", "mujoco", "an MJCF file"),
        ("r.xacro", "<robot/>", "xacro", "a xacro file"),
    ],
)
def test_a_robot_of_another_tool(name: str, text: str, library: str, need: str):
    Path(name).write_text(text)
    ran = without((library,), "inspect", name)
    assert ran.returncode == 2
    assert ran.stderr == (
        f'orbident: {name}: {need} needs {library}: pip install "orbident[{library}]"\n'
    )


@pytest.mark.parametrize(
    ("library", "orbit", "need"),
    [
        ("oem", "oem: x.oem, epoch: 2026-03-01", "reading an OEM needs oem"),
        (
            "ppigrf",
            "altitude: 400 km, inclination: 0, epoch: 2026-03-01",
            "the magnetic field of a date needs ppigrf",
        ),
    ],
)
def test_orbits(library: str, orbit: str, need: str):
    Path("x.oem").write_text("CCSDS_OEM_VERS = 2.0\n")
    robot = robot_file(Path.cwd(), lines=f"orbit: {{{orbit}}}\n")
    head = "schema: orbident/trajectory/1\nduration: 1\n"
    Path("m.yaml").write_text(head + "joints: {joint1: {}, joint2: {}}\n")
    ran = without((library,), "simulate", robot, "m.yaml", "-o", "r.csv")
    assert ran.returncode == 2
    assert ran.stderr.endswith(f'{need}: pip install "orbident[orbit]"\n')
    assert ran.stderr.count("\n") == 1
