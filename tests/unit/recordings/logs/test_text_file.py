"""Tables of text as people and their tools write them, through a map."""

from pathlib import Path

import numpy as np
import pytest
from conversions import HEAD

from orbident.errors import InputError
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import convert_file
from orbident.recordings.topics.survey import survey_file
from orbident.recordings.topics.topic_map import proposed_map

T = 0.05 * np.arange(40)
Q = 0.5 + T
ENTRY = (
    "  - {topic: /, type: table, stamp: %s, take: {joint.a.position: rad}, "
    "fields: {joint.a.position: q}}\n"
)


def lines(*above: str, separator: str = ",", comma: bool = False) -> str:
    rows = [separator.join([f"{t:.2f}", f"{q:.2f}"]) for t, q in zip(T, Q, strict=True)]
    rows = [row.replace(".", ",") for row in rows] if comma else rows
    return "\n".join([*above, *rows]) + "\n"


def converted(path: Path, entries: str):
    topic_map, out = path.parent / "map.yaml", path.parent / "out.parquet"
    topic_map.write_text(HEAD + entries)
    report = convert_file(path, topic_map, out)
    return read_recording(out), report


def refusal(path: Path, entries: str) -> str:
    with pytest.raises(InputError) as raised:
        converted(path, entries)
    assert "\n" not in str(raised.value)
    return str(raised.value)


WRITTEN = {
    "comments": lines("# log schema=1 units=SI", "% of May 5", "# a, b, c", "t,q"),
    "header in a comment": lines("# by savetxt", "# t q", separator=" "),
    "units in a row": lines("t,q", "s,rad"),
    "units and nothing known": lines("t,q", "number,number"),
    "units with brackets": lines("t;q", "[s];[rad]", separator=";"),
    "decimal commas": lines("t;q", separator=";", comma=True),
    "decimal commas and tabs": lines("t\tq", separator="\t", comma=True),
    "LabVIEW": lines(
        "LabVIEW Measurement\t",
        "Date\t2026/05/04",
        "***End_of_Header***\t",
        "t\tq",
        separator="\t",
        comma=True,
    ),
    "white space": lines("   t      q", separator="    "),
    "a comment between": lines("t,q", "0.00,0.50", "# 3, 4, 5") + "# end of log\n",
    "blank lines": lines("", "t,q", "") + "\n  \n",
}


@pytest.mark.parametrize("case", WRITTEN)
@pytest.mark.parametrize("suffix", [".csv", ".txt", ".dat"])
def test_what_stands_above_and_between(tmp_path: Path, case: str, suffix: str):
    path = tmp_path / f"log{suffix}"
    path.write_text(WRITTEN[case])
    recording, report = converted(path, ENTRY % "{t: s}")
    assert report.topics[0].rejected["duplicate"] == (case == "a comment between")
    np.testing.assert_allclose(recording.t, T, atol=1e-12)
    np.testing.assert_allclose(recording.column("joint.a.position"), Q, atol=1e-12)


def test_units_of_the_file_are_proposed_and_not_contradicted(tmp_path: Path):
    path = tmp_path / "log.csv"
    rows = [f"{1e3 * t:.0f},{q:.2f},1,2,3" for t, q in zip(T, Q, strict=True)]
    head = ["time,q,gyro.x,gyro.y,gyro.z", "ms,(deg),°/s,°/s,°/s"]
    path.write_text("\n".join([*head, *rows]))
    (found,) = survey_file(path)
    assert found.rate == pytest.approx(20)
    proposal = proposed_map([found])
    assert "stamp: {time: ms}" in proposal
    assert "gyro: deg/s" in proposal
    assert "q in deg" in proposal
    assert "'q' is in deg in the file, but in rad in the map" in (
        refusal(path, ENTRY % "{time: ms}")
    )
    assert "time 'time' is in ms in the file" in refusal(path, ENTRY % "{time: s}")


def test_units_behind_the_names(tmp_path: Path):
    path = tmp_path / "log.csv"
    path.write_text(lines("Time (s),q [deg]"))
    proposal = proposed_map(survey_file(path))
    assert "stamp: {Time (s): s}" in proposal
    entry = ENTRY.replace("position: q}", "position: 'q [deg]'}") % "{Time (s): s}"
    assert "is in deg in the file, but in rad" in refusal(path, entry)
    recording, _ = converted(path, entry.replace(": rad}", ": deg}"))
    np.testing.assert_allclose(recording.column("joint.a.position"), np.radians(Q))


TIMES = {
    "iso": ("time", "2026-05-04T10:00:{:09.6f}", "{time: ns}"),
    "iso with a comma": ("time", '"2026-05-04 10:00:{:06.3f}"', "{time: ns}"),
    "day of year": ("time", "2026-124T10:00:{:06.3f}Z", "{time: ns}"),
    "words": ("time", "May 04 2026 10:00:{:012.9f}", "{time: ns}"),
    "date and time of day": (
        "date,time",
        "2026-05-04,10:00:{:06.3f}",
        "{date: ns, time: ns}",
    ),
    "over midnight": ("time", "23:59:{:06.3f}", "{time: ns}"),
}


@pytest.mark.parametrize("case", TIMES)
def test_times_as_text(tmp_path: Path, case: str):
    names, form, stamp = TIMES[case]
    path = tmp_path / "log.csv"
    shown = [form.format(59 + t if "over" in case else t) for t in T]
    shown = [each.replace("23:59:6", "00:00:0") for each in shown]
    if "comma" in case:
        shown = [each.replace(".", ",") for each in shown]
    rows = [f"{time},{q:.2f}" for time, q in zip(shown, Q, strict=True)]
    path.write_text("\n".join([f"{names},q", *rows]))
    recording, _ = converted(path, ENTRY % stamp)
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    if case == "iso":
        (found,) = survey_file(path)
        assert found.rate == pytest.approx(20)
        assert refusal(path, ENTRY % "{time: s}").endswith(
            "time 'time' is in ns in the file, where dates are in ns, but in s in the "
            "map; write stamp: {time: ns}"
        )


def test_dates_between_blanks_without_names(tmp_path: Path):
    """As reports of FreeFlyer and GMAT have them."""
    path = tmp_path / "data.txt"
    rows = [
        f"Feb 04 2022 14:30:{t:012.9f}   {q:.2f}" for t, q in zip(T, Q, strict=True)
    ]
    path.write_text("\n".join(rows))
    assert survey_file(path)[0].labels == ("data.0", "data.1")
    entry = ENTRY.replace("position: q}", "position: data.1}") % "{data.0: ns}"
    recording, _ = converted(path, entry)
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.column("joint.a.position"), Q)


def test_seconds_and_nanoseconds_in_two_columns(tmp_path: Path):
    path = tmp_path / "log.csv"
    ns = 1_777_000_000_987_654_321 + np.round(T * 1e9).astype(int)
    rows = [f"{n // 10**9},{n % 10**9},{q:.2f}" for n, q in zip(ns, Q, strict=True)]
    path.write_text("\n".join(["sec,nanosec,q", *rows]))
    recording, report = converted(path, ENTRY % "{sec: s, nanosec: ns}")
    assert report.start_ns == ns[0]
    np.testing.assert_allclose(recording.t, T, atol=1e-12)


def test_vectors_in_cells_of_text(tmp_path: Path):
    path = tmp_path / "log.csv"
    rows = [f'{t:.2f},"[1, {k % 2}, 0.5]"' for k, t in enumerate(T)]
    rows[3] = f"{T[3]:.2f},"
    path.write_text("\n".join(["t,valves", *rows]))
    assert survey_file(path)[0].labels == ("t", "valves.0 to .2")
    entry = (
        "  - {topic: /, type: table, stamp: {t: s}, "
        "take: {thruster.b.duty: 1, thruster.c.duty: '%'}, "
        "fields: {thruster.b.duty: valves.1, thruster.c.duty: 100 * valves.2}}\n"
    )
    recording, _ = converted(path, entry)
    duty = recording.column("thruster.b.duty")
    assert np.isnan(duty[3])
    np.testing.assert_array_equal(duty[4:], np.arange(4, 40) % 2)
    assert recording.column("thruster.c.duty")[0] == 0.5
    path.write_text('t,valves\n0,"[1, 0]"\n1,"[1]"\n')
    assert "holds '[1]' in row 2, which is no vector of 2 numbers" in (
        refusal(path, entry)
    )


def test_rows_of_another_length(tmp_path: Path):
    path = tmp_path / "log.csv"
    path.write_text("# log\nt,q\n0,1\n1,2,3\n")
    assert refusal(path, ENTRY % "{t: s}") == (
        f"{path}: row 2 has 3 cells where 2 are expected; make them equal, or write "
        "the file again"
    )


def test_names_that_are_repeated(tmp_path: Path):
    """What stands above them tells them apart, as in an export of Motive."""
    path = tmp_path / "log.csv"
    path.write_text(
        "Format Version,1.23,Take Name,run\n\n,Type,Body,Body,Body\n"
        ",,Rotation,Position,\nFrame,Time (Seconds),X,X,Mean\n0,0.0,1,2,3\n"
        "1,0.1,1,2,3\n"
    )
    assert survey_file(path)[0].labels == (
        "Frame",
        "Time (Seconds)",
        "Rotation.X",
        "Position.X",
        "Mean",
    )


def test_one_signal_a_file(tmp_path: Path):
    """As NASA's 42 writes: blanks, no names, and empty where there is nothing."""
    folder = tmp_path / "InOut"
    folder.mkdir()
    (folder / "Inp_Sim.txt").write_text("<<<< Simulation Control >>>>\n")
    np.savetxt(folder / "time.42", T, "%lf")
    np.savetxt(folder / "wbn.42", np.outer(T, [1, 2, 3]), "%le")
    (folder / "MTB.42").write_text("")
    (folder / "Tree.42").write_text("SC 0\nBody 0 of 1\n")
    entry = (
        "  - {topic: /, type: table, stamp: {time: s}, frame: base, "
        "take: {gyro: rad/s}, fields: {gyro: wbn}}\n"
    )
    recording, _ = converted(folder, entry)
    np.testing.assert_allclose(recording.vector("gyro"), np.outer(T, [1, 2, 3]))
    with (folder / "wbn.42").open("a") as file:
        file.write("1.0 2.0")
    said = refusal(folder, entry)
    assert "field 'wbn' cannot be read: row 41 has 2 cells where 3 are" in said
