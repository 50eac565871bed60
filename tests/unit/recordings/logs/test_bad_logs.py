"""Files that cannot be read, and maps that do not fit them: one line that says why."""

import io
import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from conversions import HEAD
from log_writers import KINDS, write_log, write_ulog
from scipy.io import savemat

from orbident.errors import InputError
from orbident.recordings.logs import mat5
from orbident.recordings.logs.log import open_log
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import convert_file
from orbident.recordings.topics.survey import survey_file

N = 200
TABLE = {
    "timestamp": np.arange(N) * 1e4,
    "q": np.arange(N) / N,
    "w": np.ones((N, 3)),
}
ENTRY = """\
  - topic: {topic}
    type: table
    stamp: {{timestamp: us}}
    take: {{joint.a.position: rad}}
    fields: {{joint.a.position: q}}
"""


def refusal(path: Path, entries: str) -> str:
    """What `convert` says, and that nothing is left."""
    topic_map, out = path.parent / "map.yaml", path.parent / "r.csv"
    topic_map.write_text(HEAD + entries)
    with pytest.raises(InputError) as raised:
        convert_file(path, topic_map, out)
    assert not out.exists()
    line = str(raised.value)
    assert "\n" not in line
    return line


def entry(kind: str) -> str:
    return ENTRY.format(topic="/" if kind in {"csv", "parquet"} else "/log")


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def path(kind: str, tmp_path: Path) -> Path:
    return write_log(kind, tmp_path, {"log": TABLE})


CUT_OFF = {
    "mat": "is damaged or no MATLAB file",
    "mat-7": "is damaged or no MATLAB file",
    "mat-7.3": "is damaged or no MATLAB file",
    "hdf5": "is damaged or no HDF5 file",
    "npz": "is damaged or no NumPy file",
    "csv": "field 'q' holds text: '0.4e' in row 99",
    "parquet": "is damaged or no Parquet file",
}


@pytest.mark.parametrize("kind", CUT_OFF, indirect=True)
def test_a_file_that_is_cut_off(path: Path, kind: str):
    content = path.read_bytes()
    half = content[: len(content) // 2]
    if kind == "csv":
        half = b"\n".join(content.split(b"\n")[:99]) + b"\n990000.0,0.4e,1.0,1.0,1.0"
    path.write_bytes(half)
    assert CUT_OFF[kind] in refusal(path, entry(kind))


def test_a_log_that_lost_power(tmp_path: Path):
    """PX4 writes until power is gone: what came before is whole."""
    path = write_log("ulog", tmp_path, {"log": TABLE})
    path.write_bytes(path.read_bytes()[:-7])
    (tmp_path / "map.yaml").write_text(HEAD + entry("ulog"))
    report = convert_file(path, tmp_path / "map.yaml", tmp_path / "r.csv")
    (warning,) = report.warnings
    assert "ends within a message, so it is cut off" in warning
    assert report.samples == N - 1
    (tmp_path / "r.csv").unlink()
    path.write_bytes(path.read_bytes()[:100])
    assert "is damaged; copy it again" in refusal(path, entry("ulog"))


def test_empty(path: Path, kind: str):
    path.write_bytes(b"")
    assert refusal(path, entry(kind)) == f"{path}: is empty; record again"


@pytest.mark.parametrize("content", [b"hello, world\n" * 20, bytes(range(256)) * 4])
def test_not_what_its_suffix_says(path: Path, kind: str, content: bytes):
    path.write_bytes(content)
    line = refusal(path, entry(kind))
    if kind == "csv":
        assert "has no topic" in line or "CSV" in line or "holds no arrays" in line
    else:
        assert "does not begin as a" in line


def test_another_kind_is_named(tmp_path: Path):
    path = write_log("hdf5", tmp_path, {"log": TABLE})
    kinds = {".mat": "MATLAB", ".npz": "NumPy", ".csv": "CSV", ".ulg": "PX4 ULog"}
    for suffix, kind in kinds.items():
        renamed = path.with_name(f"other{suffix}")
        renamed.write_bytes(path.read_bytes())
        assert refusal(renamed, entry("hdf5")) == (
            f"{renamed}: is by its content a file of HDF5, not {kind}; rename it to "
            "other.h5"
        )
    unknown = path.with_name("other.xyz")
    unknown.write_bytes(path.read_bytes())
    assert "a file whose name ends in one of" in refusal(unknown, entry("hdf5"))


def test_a_field_that_is_missing(path: Path, kind: str):
    line = refusal(path, entry(kind).replace("position: q}", "position: qq}"))
    assert "has no field 'qq'; did you mean 'q'? known fields: " in line
    line = refusal(path, entry(kind).replace("{timestamp:", "{time:"))
    assert "has no field 'time'; did you mean 'timestamp'?" in line


def test_a_topic_that_is_missing(path: Path, kind: str):
    assert "has no topic '/lag'" in refusal(path, ENTRY.format(topic="/lag"))


def test_messages_and_tables_are_two_things(path: Path, kind: str):
    topic = "/" if kind in {"csv", "parquet"} else "/log"
    entries = (
        f"  - {{topic: {topic}, type: std_msgs/Float64, "
        "take: {joint.a.position: rad}}\n"
    )
    assert "type: found std_msgs/Float64, but it is table" in refusal(path, entries)


def test_an_array_where_a_number_is_wanted(tmp_path: Path):
    path = write_log("npz", tmp_path, {"log": TABLE})
    line = refusal(path, entry("npz").replace("position: q}", "position: w}"))
    assert "'w' has 3 numbers a row; name one of them, 'w.0' to 'w.2'" in line
    line = refusal(path, entry("npz").replace("position: q}", "position: w.3}"))
    assert "'w' has columns 0 to 2 a row, not 3" in line


TEXT = np.array(["one"] * N)


@pytest.mark.parametrize("kind", ["mat", "hdf5", "npz", "csv", "parquet"])
def test_text_for_numbers(kind: str, tmp_path: Path):
    texts = [b"one"] * N if kind == "hdf5" else TEXT
    if kind == "csv":
        path = tmp_path / "log.csv"
        path.write_text("timestamp,q\n0,1\n10000,one\n")
    else:
        path = write_log(kind, tmp_path, {"log": {**TABLE, "q": np.array(texts)}})
    line = refusal(path, entry(kind))
    assert "field 'q' holds text" in line
    assert "write" in line


def test_nothing_pickled_is_loaded(tmp_path: Path):
    class Trap:
        def __reduce__(self) -> tuple:
            return (Path.touch, (tmp_path / "run",))

    path = tmp_path / "log.npz"
    trap = np.array([Trap()], dtype=object)
    np.savez(path, **{"log.timestamp": TABLE["timestamp"], "log.q": trap})  # pyright: ignore
    line = refusal(path, entry("npz"))
    assert "field 'q' holds Python objects, which are never loaded" in line
    assert not (tmp_path / "run").exists()


def test_damage_that_only_reading_shows(tmp_path: Path):
    q = np.linspace(0, 1, 10**6)
    path = write_log("npz", tmp_path, {"log": {"timestamp": q * 1e9, "q": q}})
    content = bytearray(path.read_bytes())
    content[content.index(q.tobytes()) + 4_000_000] ^= 1
    path.write_bytes(content)
    line = refusal(path, entry("npz"))
    assert "field 'q' cannot be read (its compressed data are damaged)" in line


def test_absurd_sizes_are_not_read(tmp_path: Path):
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        file["log/timestamp"] = TABLE["timestamp"]
        file.create_dataset("log/q", (10**12,), "f8", chunks=(1000,))
        file.create_dataset("log/image", (9, 9, 9), "f8")
    assert "field 'q' has 1000000000000 numbers; write at most" in refusal(
        path, entry("hdf5")
    )
    line = refusal(path, entry("hdf5").replace("position: q}", "position: image}"))
    assert "field 'image' has shape (9, 9, 9)" in line
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        head, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}
    )
    path = tmp_path / "log.npz"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("log.timestamp.npy", head.getvalue())
    assert "time: 'timestamp' has 1000000000000 numbers" in refusal(path, entry("npz"))


def test_what_is_compressed_a_thousand_times_is_passed_over(tmp_path: Path):
    zeros = np.zeros(2**22)
    table = {"timestamp": np.arange(2.0**10), "q": zeros}
    savemat(tmp_path / "log.mat", {"log": table, "x": zeros}, do_compression=True)
    tracemalloc.start()
    with open_log(tmp_path / "log.mat") as log:
        assert log.topics["/log"].fields["q"].count == zeros.size
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < zeros.nbytes / 8


def mat_element(kind: int, data: bytes, order: str = "<") -> bytes:
    """An element by MathWorks' format."""
    return struct.pack(f"{order}II", kind, len(data)) + data.ljust(
        -(-len(data) // 8) * 8
    )


def mat_matrix(kind: int, name: bytes, *content: bytes, order: str = "<") -> bytes:
    sizes = struct.pack(f"{order}II", 1, 2)
    flags = struct.pack(f"{order}II", kind, 0)
    parts = [(6, flags), (5, sizes), (1, name)]
    head = b"".join(mat_element(each, data, order) for each, data in parts)
    return mat_element(14, head + b"".join(content), order)


def write_mat_5(path: Path, *matrices: bytes, order: str = "<") -> Path:
    end = b"\0\1IM" if order == "<" else b"\1\0MI"
    path.write_bytes(b"MATLAB 5.0".ljust(124) + end + b"".join(matrices))
    return path


@pytest.mark.parametrize("order", "<>")
def test_numbers_of_either_byte_order(tmp_path: Path, order: str):
    numbers = mat_element(9, struct.pack(f"{order}dd", 1.5, -2.0), order)
    matrix = mat_matrix(6, b"q", numbers, order=order)
    path = write_mat_5(tmp_path / "log.mat", matrix, order=order)
    with open_log(path) as log:
        assert log.topics["/"].column("q").tolist() == [1.5, -2.0]


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (mat_matrix(6, b"q", mat_element(9, bytes(24))), "3 numbers are no matrix"),
        (mat_matrix(6, b"q", mat_element(9, bytes(16))[:-8]), "ends within a variable"),
        (mat_element(15, zlib.compress(mat_matrix(6, b"q"))[:-4] + b"four"), "damaged"),
        (mat_element(15, zlib.compress(struct.pack("<II", 14, 2**32 - 1))), "ends"),
    ],
)
def test_a_mat_file_that_lies(tmp_path: Path, matrix: bytes, words: str):
    path = write_mat_5(tmp_path / "log.mat", matrix)
    with pytest.raises(InputError, match=words), open_log(path):
        pass


def test_arrays_without_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(mat5, "MOST", 100)
    cells = mat_matrix(1, b"c", mat_element(14, b"") * 100)
    path = write_mat_5(tmp_path / "log.mat", cells)
    with pytest.raises(InputError, match="holds more than 100 arrays"), open_log(path):
        pass


def test_structs_without_an_end(tmp_path: Path):
    matrix = mat_element(14, b"")
    for _ in range(2000):
        matrix = mat_matrix(1, b"", matrix)
    path = write_mat_5(tmp_path / "log.mat", matrix)
    with pytest.raises(InputError, match="too many levels"), open_log(path):
        pass


def test_what_an_hdf5_file_says_is_in_another_is_not_read(tmp_path: Path):
    (tmp_path / "secret").write_bytes(bytes(8 * N))
    path = tmp_path / "log.h5"
    source = h5py.VirtualSource("other.h5", "x", shape=(N,))
    layout = h5py.VirtualLayout((N,), "f8")
    layout[:] = source
    with h5py.File(path, "w") as file:
        file["log/timestamp"] = TABLE["timestamp"]
        place = [(tmp_path / "secret", 0, 8 * N)]
        file.create_dataset("log/outside", (N,), "f8", external=place)
        file.create_virtual_dataset("log/virtual", layout)
        file["log/linked"] = h5py.ExternalLink("other.h5", "/x")
    for name in ("outside", "virtual", "linked"):
        line = refusal(
            path, entry("hdf5").replace("position: q}", f"position: {name}}}")
        )
        assert f"field '{name}' is kept in another file, which is not read" in line


def test_another_version(tmp_path: Path):
    path = write_ulog(tmp_path / "log.ulg", {"log": TABLE}, version=7)
    assert "is a ULog of version 7, but only version 1 is known" in refusal(
        path, entry("ulog")
    )
    path = tmp_path / "log.mat"
    path.write_bytes(np.array([0, 2, 1, 0, 2], "<i4").tobytes() + b"q\0" + bytes(16))
    assert "is a MATLAB file of version 4, which is not read" in (
        refusal(path, entry("mat"))
    )
    path.write_bytes(b"MATHLAB 5.0 MAT-file" + bytes(128))
    assert "does not begin as a MATLAB file does; write it again, with 'save -v7'" in (
        refusal(path, entry("mat"))
    )


TIMES = {
    "not finite": ([0, np.nan], "row 2: found nan; every row needs a time"),
    "too late": ([0, 1e30], "goes beyond 146 years in us"),
    "larger than numbers are": ([0, 1e308], "goes beyond 146 years in us"),
}


@pytest.mark.parametrize("case", TIMES)
def test_times(tmp_path: Path, case: str):
    start, words = TIMES[case]
    times = TABLE["timestamp"].copy()
    times[:2] = start
    path = write_log("npz", tmp_path, {"log": {**TABLE, "timestamp": times}})
    assert words in refusal(path, entry("npz"))


def test_fields_of_another_length(tmp_path: Path):
    path = write_log("npz", tmp_path, {"log": {**TABLE, "q": np.ones(3)}})
    line = refusal(path, entry("npz"))
    assert "field 'q' has 3 values, but 'timestamp' has 200" in line


def test_quaternions_that_are_none(tmp_path: Path):
    path = write_log("npz", tmp_path, {"log": TABLE})
    entries = (
        "  - {topic: /log, type: table, stamp: {timestamp: us}, frame: base, "
        "take: {attitude: quaternion}, fields: {attitude: [w.0, w.1, w.2, q]}}\n"
    )
    assert "200 of 200 quaternions are not of length one" in refusal(path, entries)


def test_no_numbers_at_all(tmp_path: Path):
    path = write_log("mat", tmp_path, {"log": {"name": np.array("flight")}})
    with pytest.raises(InputError, match="holds no arrays of numbers over time"):
        survey_file(path)


def test_repeated_and_late_rows_are_counted(tmp_path: Path):
    times = TABLE["timestamp"].copy()
    times[[5, 6, 9]] = times[[6, 5, 8]]
    path = write_log("npz", tmp_path, {"log": {**TABLE, "timestamp": times}})
    (tmp_path / "map.yaml").write_text(HEAD + entry("npz"))
    report = convert_file(path, tmp_path / "map.yaml", tmp_path / "r.csv")
    assert report.topics[0].rejected["duplicate"] == 1
    assert report.topics[0].out_of_order == 1
    q = read_recording(tmp_path / "r.csv").column("joint.a.position")
    assert q[5] == TABLE["q"][6]


def test_version_4_of_matlab(tmp_path: Path):
    path = tmp_path / "r.mat"
    savemat(path, {"t": np.arange(3.0)}, format="4")
    assert "is a MATLAB file of version 4" in refusal(path, entry("mat"))


@pytest.mark.parametrize("coding", ["utf-16-le", "utf-16-be"])
def test_text_in_utf_16(tmp_path: Path, coding: str):
    path = tmp_path / "log.csv"
    path.write_bytes("\ufefft,q\n0,1\n".encode(coding))
    said = refusal(path, entry("csv"))
    assert said == (
        f"{path}: is text in UTF-16, which is not read; save it as CSV in UTF-8"
    )


def test_a_cell_array_of_text_is_one_field(tmp_path: Path):
    path = tmp_path / "r.mat"
    cells = np.array(["start", "stop"], dtype=object)
    savemat(path, {"log": {"timestamp": np.arange(2.0), "q": cells}})
    said = refusal(path, entry("mat"))
    assert "field 'q' holds text, 'start'; write it as numbers" in said
