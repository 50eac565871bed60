import os
import tempfile
import tracemalloc
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from orbident.errors import InputError
from orbident.files.bounds import FAINTEST, LARGEST
from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording, write_recording

SUFFIXES = [".csv", ".parquet"]
values = st.floats(-LARGEST, LARGEST).filter(
    lambda x: x == 0.0 or abs(x) >= FAINTEST
) | st.just(np.nan)
times = st.lists(
    st.floats(-LARGEST, LARGEST), min_size=2, unique_by=lambda t: round(t, 6)
).map(lambda t: np.array(sorted(t)) + 0.0)


@st.composite
def recordings(draw):
    t = draw(times)
    names = draw(
        st.lists(
            st.sampled_from(["gyro.x", "joint.a.position", 'wheel."r,w".speed', "é"]),
            unique=True,
        )
    )
    columns = {name: draw(arrays(float, t.size, elements=values)) for name in names}
    return t, columns


def bits(x):
    return np.where(np.isnan(x), np.nan, x).view(np.int64)


def same(read, written):
    assert list(read.columns) == list(written.columns)
    np.testing.assert_array_equal(bits(read.t), bits(written.t))
    for name, column in written.columns.items():
        np.testing.assert_array_equal(bits(read.columns[name]), bits(column))


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(recording=recordings())
def test_round_trip_is_bit_identical(suffix, recording):
    recording = Recording(*recording)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"flight{suffix}"
        write_recording(recording, path)
        same(read_recording(path), recording)


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".CSV", ".Parquet"])
def test_many_batches(tmp_path, suffix):
    t = np.arange(150_001) * 0.05
    x = np.where(np.arange(t.size) % 7 == 0, np.nan, np.sin(t))
    recording = Recording(t, {"gyro.x": x, "empty": np.full(t.size, np.nan)})
    path = tmp_path / f"flight{suffix}"
    write_recording(recording, path)
    read = read_recording(str(path))
    same(read, recording)
    assert read.source == str(path)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(
    "suffix", [pytest.param(".csv", marks=pytest.mark.slow), ".parquet"]
)
def test_reading_holds_the_recording_and_little_else(tmp_path, suffix):
    t = np.arange(400_000) * 0.05
    columns = {f"x{k}": np.sin(t + k) for k in range(20)}
    path = tmp_path / f"flight{suffix}"
    write_recording(Recording(t, columns), path)
    tracemalloc.start()
    read_recording(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # 67 MB of data and some slack for one column's checks. Arrow counts its own
    # memory: it reads some 32 blocks of 1 MB ahead, however long the file is.
    assert peak < 1.15 * 21 * t.nbytes
    assert pa.default_memory_pool().max_memory() < 50e6


def read(tmp_path, content, name="flight.csv"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_recording(path)


CSV_ACCEPTED = {
    "plain": "t,x\n0,1\n1,2\n",
    "no last newline": "t,x\n0,1\n1,2",
    "blank lines": "\nt,x\n0,1\n\n1,2\n\n  \n\n",
    "header spaces": " t , x \n0,1\n1,2\n",
    "cell spaces": "t,x\n 0 , 1\n1 , 2 \n",
    "byte order mark": "\ufefft,x\n0,1\n1,2\n",
    "windows": "t,x\r\n0,1\r\n1,2\r\n",
    "old mac": "t,x\r0,1\r1,2\r",
    "quoted": '"t","x"\n"0","1"\n"1","2"\n',
    "other order": "x,t\n1,0\n2,1\n",
    "notations": "t,x\n0.,+1e0\n1,.2E1\n",
    "comments": "# a log\n% schema=1 units=SI\nt,x\n# begin\n0,1\n1,2\n# end\n",
    "header in a comment": "# a log\n# t,x\n0,1\n1,2\n",
    "title": "Flight of May 5\nt,x\n0,1\n1,2\n",
    "units in SI": "t,x\ns,rad/s\n0,1\n1,2\n",
    "semicolons and decimal commas": "t;x\n0,0;1,0\n1,0;2,0\n",
    "semicolons": "t; x\n0; 1\n1; 2\n",
    "tabs": "t\tx\n0\t1\n1\t2\n",
    "white space": "  t   x\n  0.0 1\n  1.0   2 \n",
}


@pytest.mark.parametrize("text", CSV_ACCEPTED.values(), ids=CSV_ACCEPTED.keys())
def test_csv_accepted(tmp_path, text):
    recording = read(tmp_path, text)
    np.testing.assert_array_equal(recording.t, [0, 1])
    np.testing.assert_array_equal(recording.columns["x"], [1, 2])


def test_csv_empty_cells_and_nan_are_no_samples(tmp_path):
    recording = read(tmp_path, "t,x,y\n0,,\n1,nan, \n2,NaN,   \n3, NaN,4\n")
    assert np.isnan(recording.columns["x"]).all()
    np.testing.assert_array_equal(recording.columns["y"], [np.nan] * 3 + [4])


CSV_REFUSED = {
    "empty": ("", "is empty"),
    "blank": ("\n \n", "is empty"),
    "no header": ("0,1\n1,2\n", "line 1 holds numbers where the column names"),
    "only header": ("t,x\n", "0 samples"),
    "only header, no newline": ("t,x", "no rows"),
    "one row": ("t,x\n0,1\n", "1 samples"),
    "text": ("t,x\n0,1\n\n1,on\n", "column 'x', row 2: found 'on'"),
    "underscore": ("t,x\n0,1\n1,1_000\n", "column 'x', row 2: found '1_000'"),
    "text after an empty row": ("t,x\n0,1\n,\nab,1\n", "'t', row 3: found 'ab'"),
    "not text": (b"t,x\n0,1\n1,2\n2,\xff\n", "UTF-8"),
    "late not text": (
        b"t,x\n" + b"".join(b"%d,1\n" % k for k in range(9999)) + b"9999,\xff\n",
        "line 10001: byte 0xff is not UTF-8",
    ),
    "utf-16": ("t,x\n0,1\n".encode("utf-16"), "UTF-8"),
    "ragged": ("t,x\n0,1\n1,2,3\n", "row 2 has 3 cells but the header names 2"),
    "short": ("t,x\n0,1\n1\n", "row 2 has 1 cells"),
    "twice": ("t,x, x\n0,1,1\n1,2,2\n", "2 columns are named 'x'"),
    "columns": ("t," + "x," * 10_000 + "\n", "10002 columns; give at most 10000"),
    "nameless": (",t\n0,0\n1,1\n", "column 1 has no name"),
    "no t": ("time,x\n0,1\n1,2\n", "'t' is missing .* found 'time', 'x'"),
    "another unit": ("t,gyro.x\ns,deg/s\n0,1\n1,2\n", "'gyro.x' is in deg/s; a rec"),
    "a date": ("t,x\n2026-05-04T10:00:00,1\n", "found '2026.*let 'orbident convert'"),
    "a clock that was set": ("t,x\n0,1\n9,2\n0,3\n", "cut the recording here if its"),
    "thousands": ("t;x\n0;1,000\n1;2.5\n", "'x', row 1: found '1,000'"),
    "no time": ("t,x\n0,1\n,2\n", "'t', row 2: found nan"),
    "repeated time": ("t,x\n0,1\n0,2\n", "row 2: 0.0 s does not come after"),
    "infinite": ("t,x\n0,1\n1,inf\n", "'x', row 2: found inf"),
    "overflow": ("t,x\n0,1\n1,1e999\n", "'x', row 2: found inf"),
    "open quote": ('t,x\n0,1\n1,"2\n', "flight.csv: "),
}


@pytest.mark.parametrize(
    ("content", "message"), CSV_REFUSED.values(), ids=CSV_REFUSED.keys()
)
def test_csv_refused(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, content)
    assert "flight.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def parquet_file(tmp_path, columns, names=None):
    path = tmp_path / "flight.parquet"
    arrays_ = [pa.array(values) for values in columns.values()]
    table = pa.Table.from_arrays(arrays_, names=names or list(columns))
    parquet.write_table(table, path)
    return path


def test_parquet_numbers_of_every_kind(tmp_path):
    path = parquet_file(
        tmp_path,
        {
            "t": pa.array([0, 1, 2], pa.int64()),
            "single": pa.array([0.5, None, np.nan], pa.float32()),
            "decimal": pa.array([1, None, 2], pa.decimal128(9, 2)),
            "void": pa.nulls(3),
            "huge": pa.array([2**62 + 1, 0, None], pa.uint64()),
        },
    )
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.t, [0, 1, 2])
    np.testing.assert_array_equal(recording.columns["single"], [0.5, np.nan, np.nan])
    np.testing.assert_array_equal(recording.columns["decimal"], [1, np.nan, 2])
    assert np.isnan(recording.columns["void"]).all()
    np.testing.assert_array_equal(recording.columns["huge"], [2.0**62, 0, np.nan])


PARQUET_REFUSED = {
    "text": ({"t": [0.0, 1.0], "x": ["a", "b"]}, None, "'x' holds string from row 1"),
    "boolean": ({"t": [0.0, 1.0], "x": [True, False]}, None, "'x' holds bool"),
    "lists": ({"t": [0.0, 1.0], "x": [[1.0], [2.0]]}, None, "'x' holds list"),
    "dates": (
        {"t": pa.array([0, 1], pa.timestamp("ns"))},
        None,
        r"'t' holds timestamp\[ns\]",
    ),
    "twice": ({"t": [0.0, 1.0], "x": [0.0, 0.0]}, ["t", "t"], "2 columns .* 't'"),
    "no t": ({"x": [0.0, 1.0]}, None, "'t' is missing"),
    "no rows": ({"t": pa.array([], pa.float64())}, None, "0 samples"),
}


@pytest.mark.parametrize(
    ("columns", "names", "message"), PARQUET_REFUSED.values(), ids=PARQUET_REFUSED
)
def test_parquet_refused(tmp_path, columns, names, message):
    path = parquet_file(tmp_path, columns, names)
    with pytest.raises(InputError, match=message):
        read_recording(path)


def test_parquet_damaged(tmp_path):
    for content in (b"", b"t,x\n0,1\n", b"PAR1 nonsense PAR1"):
        with pytest.raises(InputError, match=r"flight\.parquet: ") as caught:
            read(tmp_path, content, "flight.parquet")
        assert "\n" not in str(caught.value)


def test_parquet_overwritten_inside(tmp_path):
    path = parquet_file(tmp_path, {"t": np.arange(9e3), "x": np.sin(np.arange(9e3))})
    content = bytearray(path.read_bytes())
    content[100:4000] = bytes(3900)
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"flight\.parquet: "):
        read_recording(path)


def test_parquet_with_a_name_that_is_not_text(tmp_path):
    path = parquet_file(tmp_path, {"t": [0.0, 1.0], "abcdefgh": [0.0, 1.0]})
    path.write_bytes(path.read_bytes().replace(b"abcdefgh", b"abcd\xffefg"))
    with pytest.raises(InputError, match="is not a readable Parquet file"):
        read_recording(path)


@pytest.mark.parametrize("name", ["flight.xlsx", "flight", "flight.csv.gz"])
def test_other_suffixes_refused(tmp_path, name):
    recording = Recording(np.arange(2.0), {})
    with pytest.raises(InputError, match=r"ends in \.csv or \.parquet"):
        read_recording(tmp_path / name)
    with pytest.raises(InputError, match=r"ends in \.csv or \.parquet"):
        write_recording(recording, tmp_path / name)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_places_refused(tmp_path, suffix):
    path = tmp_path / f"flight{suffix}"
    recording = Recording(np.arange(2.0), {})
    with pytest.raises(InputError, match="does not exist"):
        read_recording(path)
    with pytest.raises(InputError, match=r"folder '.*nowhere' does not exist"):
        write_recording(recording, tmp_path / "nowhere" / path.name)
    path.mkdir()
    with pytest.raises(InputError, match="is a folder"):
        read_recording(path)
    with pytest.raises(InputError, match="is a folder"):
        write_recording(recording, path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_failed_write_leaves_the_old_file(tmp_path, suffix, monkeypatch):
    path = tmp_path / f"flight{suffix}"
    write_recording(Recording(np.arange(2.0), {}), path)
    before = path.read_bytes()

    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(InputError, match=r"cannot be written \(No space left"):
        write_recording(Recording(np.arange(3.0), {}), path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_a_bad_byte_in_a_row_of_the_wrong_length(tmp_path, capfd):
    path = tmp_path / "flight.csv"
    path.write_bytes(b"t,gyro.x\r\n0,1\r\n" + b"0,1\r\n" * 9000 + b"1,2,\xff\r\n")
    with pytest.raises(
        InputError, match=r"flight.csv: line 9003: byte 0xff is not UTF-8"
    ):
        read_recording(path)
    assert capfd.readouterr() == ("", "")


def test_a_character_that_is_cut_off(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_bytes(b"t,gyro.x\n0,1\n1,\xc3")
    with pytest.raises(InputError, match=r"flight.csv: line 3: byte 0xc3 is not UTF-8"):
        read_recording(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_whose_name_is_not_utf_8(tmp_path, suffix):
    write_recording(Recording(np.array([0.0, 1.0]), {}), tmp_path / f"plain{suffix}")
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff" + suffix.encode()))
    (tmp_path / f"plain{suffix}").rename(path)
    assert read_recording(path).t.tolist() == [0.0, 1.0]


def test_a_damaged_parquet_file_says_what_to_do(tmp_path):
    path = tmp_path / "flight.parquet"
    path.write_bytes(b"PAR1" + b"\xff" * 100 + b"\x10\0\0\0PAR1")
    with pytest.raises(
        InputError, match=r"flight.parquet: is not a readable Parquet file"
    ):
        read_recording(path)


@pytest.mark.parametrize(
    "header", ["time" + "x" * 20_000, '"time, s\n' + "joint1 position/rad " * 99 + '"']
)
@pytest.mark.parametrize("columns", [1, 3])
def test_a_long_name_is_cut(tmp_path, header, columns):
    path = tmp_path / "flight.csv"
    names = [header[:-1] + f"{k}" + header[-1] for k in range(columns)]
    path.write_text(",".join(names) + "\n" + ",".join("0" * columns) + "\n")
    with pytest.raises(InputError, match="column 't' is missing") as caught:
        read_recording(path)
    assert len(str(caught.value)) < 100 + columns * 90 + len(str(path))
