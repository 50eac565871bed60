"""MATLAB's objects, by the library's own writer; a timeseries by its properties.

MATLAB keeps a timeseries as `Data_`, and its time in `TimeInfo`: the times, or where
they are equally spaced the first, the step and their number.
"""

import warnings
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from conversions import HEAD

from orbident.extras import MissingLibraryError
from orbident.files.confined import ConfinedError
from orbident.recordings.logs import mat_objects
from orbident.recordings.logs.log import open_log
from orbident.recordings.source import Source
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import convert_file

with warnings.catch_warnings():
    # It sets an option of pandas that no longer does anything.
    warnings.simplefilter("ignore")
    from matio import save_to_mat
    from matio.utils.matclass import MatlabOpaque

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

T = np.arange(5.0) / 4
NONE = np.zeros((0, 0))


def timeseries(data: np.ndarray, equal: bool) -> MatlabOpaque:
    about = {
        "Units": "seconds",
        "Time_": NONE if equal else T[:, None],
        "Start_": np.array([[0.0]]) if equal else NONE,
        "Increment_": np.array([[0.25]]) if equal else NONE,
        "Length": np.array([[5.0]]),
    }
    info = MatlabOpaque(properties=about, classname="tsdata.timemetadata")
    properties = {"Data_": data, "Time_": NONE, "TimeInfo": info}
    return MatlabOpaque(properties=properties, classname="timeseries")


def simulink_dataset(**signals: MatlabOpaque) -> MatlabOpaque:
    """What Simulink logs by default: a Dataset of signals, each a timeseries."""
    cells = np.empty((len(signals), 1), dtype=object)
    for k, (name, values) in enumerate(signals.items()):
        properties = {"Name": name, "Values": values}
        cells[k, 0] = MatlabOpaque(properties, "Simulink.SimulationData.Signal")
    storage = "Simulink.SimulationData.Storage.RamDatasetStorage"
    properties = {
        "Name": "logsout",
        "Storage_": MatlabOpaque({"Elements": cells}, storage),
    }
    return MatlabOpaque(properties, "Simulink.SimulationData.Dataset")


@pytest.fixture(params=["v7", "v7.3"])
def path(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    index = pd.Index((T * 1e9).astype("m8[ns]"), name="Time")
    dates = pd.Index((T * 1e9).astype("M8[ns]"), name="When")
    # A vector over time is kept with time last.
    vectors = np.stack([T, 2 * T, 3 * T])[:, None]
    content = {
        "table": pd.DataFrame({"time": T, "q": 2 * T, "note": ["a"] * 5}),
        "timetable": pd.DataFrame({"q": 2 * T}, index=index),
        "dated": pd.DataFrame({"q": 2 * T}, index=dates),
        "series": timeseries(2 * T[:, None], equal=False),
        "out": {"w": timeseries(vectors, equal=True), "t": T},
        "logsout": simulink_dataset(q=timeseries(2 * T[:, None], equal=True)),
    }
    save_to_mat(tmp_path / "log.mat", content, version=request.param)
    return tmp_path / "log.mat"


def values(log: Source, topic: str, name: str) -> np.ndarray:
    return log.topics[topic].column(name)


def test_every_kind(path: Path):
    with open_log(path) as log:
        for topic, name in (
            ("/table", "q"),
            ("/timetable", "q"),
            ("/dated", "q"),
            ("/series", "data"),
            ("/out/w", "data.1"),
            ("/logsout/Storage_/Elements/0_q/Values", "data"),
        ):
            group = log.topics[topic]
            assert group.time == "time"
            unit = group.fields["time"].unit
            scale = {"": 1.0, "s": 1.0, "ns": 1e-9}[unit]
            np.testing.assert_allclose(values(log, topic, "time") * scale, T)
            np.testing.assert_allclose(values(log, topic, name), 2 * T)
        assert "holds text" in log.topics["/table"].fields["note"].problem
        np.testing.assert_array_equal(values(log, "/out", "t"), T)


def test_converted(path: Path, tmp_path: Path):
    (tmp_path / "map.yaml").write_text(
        HEAD + "  - {topic: /series, type: table, stamp: {time: s}, "
        "take: {joint.a.position: rad}, fields: {joint.a.position: data}}\n"
    )
    convert_file(path, tmp_path / "map.yaml", tmp_path / "r.csv")
    recording = read_recording(tmp_path / "r.csv")
    np.testing.assert_allclose(recording.column("joint.a.position"), 2 * T)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (MissingLibraryError("reading one needs matio"), "(reading one needs matio)"),
        (ConfinedError("crashes"), "(crashes)"),
        (RuntimeError("Traceback"), "(it cannot be read)"),
    ],
)
def test_the_rest_is_read_without_them(path: Path, monkeypatch, error, words: str):
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(mat_objects, "confined", refuse)
    with open_log(path) as log:
        np.testing.assert_array_equal(values(log, "/out", "t"), T)
        problem = log.topics["/"].fields["series"].problem
    assert problem.startswith(f"is a MATLAB object {words}; save it as a struct: s = ")


def test_objects_in_a_file_that_leads_to_others(tmp_path: Path):
    path = tmp_path / "log.mat"
    content = {"series": timeseries(T[:, None], equal=False), "t": T}
    save_to_mat(path, content, version="v7.3")
    with h5py.File(path, "r+") as file:
        file["#refs#/other"] = h5py.ExternalLink("secret.h5", "/x")
    with open_log(path) as log:
        problem = log.topics["/"].fields["series"].problem
    assert "refers to other files, which are not read" in problem
