"""What an entry of a table may say, and how it is refused."""

from pathlib import Path

import pytest
from conversions import refusal

TABLE = "{topic: /, type: table, stamp: {t: s}, "
REFUSED = {
    "no stamp": ("{topic: /, type: table, take: {wheel.a.speed: rpm}}", "stamp: this"),
    "another unit of time": (
        "{topic: /, type: table, stamp: {t: min}, take: {wheel.a.speed: rpm}}",
        "stamp: found {'t': 'min'}; give the field that holds the time, and its unit: "
        "{time: s}, with one of s, ms, us, ns, or '0.2 s' for counts",
    ),
    "a time of messages": (
        TABLE + "take: {gyro: deg/s}, fields: {gyro: w}, frame: base, time: header}",
        "time: a table's is in 'stamp'; leave this key out",
    ),
    "no fields": (
        TABLE + "take: {gyro: deg/s}, frame: base}",
        "fields: 'gyro' is missing; name what it is made of, such as fields: {gyro: "
        "[x, y, z]}",
    ),
    "nothing taken": (TABLE + "take: {}}", "take: found {}"),
    "too few fields": (
        TABLE + "take: {gyro: deg/s}, fields: {gyro: [a, b]}, frame: base}",
        "fields: 'gyro' has 2 fields; give 3: [x, y, z]",
    ),
    "fields of nothing": (
        TABLE + "take: {wheel.a.speed: rpm}, fields: {wheel.a.speed: x, gyro: y}}",
        "fields: 'gyro' is not in take",
    ),
    "counts of a time that are none": (
        "{topic: /, type: table, stamp: {t: 1e99999 s}, take: {wheel.a.speed: rpm}}",
        "stamp: found {'t': '1e99999 s'}; give the field that holds the time",
    ),
    "a scale that is not finite": (
        TABLE + "take: {wheel.a.speed: rpm}, fields: {wheel.a.speed: 1e999 * x}}",
        "fields.wheel.a.speed: found '1e999 * x'; give numbers of at most 1e+12",
    ),
    "a number beyond all float64": (
        TABLE
        + "take: {wheel.a.speed: rpm}, fields: {wheel.a.speed: 1"
        + 400 * "0"
        + "}}",
        "; give numbers of at most 1e+12",
    ),
    "no field": (
        TABLE + "take: {wheel.a.speed: rpm}, fields: {wheel.a.speed: true}}",
        "fields.wheel.a.speed: found True; give a field, a field with a minus",
    ),
    "another form of attitude": (
        TABLE + "take: {attitude: euler}, fields: {attitude: x}, frame: base}",
        "take: attitude: found 'euler'; give its form: quaternion, mrp, rad, ",
    ),
    "another dimension": (
        TABLE + "take: {position: rad}, fields: {position: p}, point: S}",
        "take: position: found 'rad'; declare the messages' unit: m, ",
    ),
    "no frame": (
        TABLE + "take: {attitude: mrp}, fields: {attitude: sigma}}",
        "neither of frame and rotation given for attitude",
    ),
    "no point": (
        TABLE + "take: {position: m}, fields: {position: p}}",
        "point missing for position",
    ),
    "an axis that is turned": (
        TABLE + "take: {gyro.z: rad/s}, fields: {gyro.z: w}, rotation: [1, 0, 0, 0]}",
        "rotation: 'gyro.z' is one axis, which cannot be turned; take 'gyro' with",
    ),
    "two times": (
        "{topic: /m, type: lab/Body, stamp: {us: us}, time: receive, "
        "take: {wheel.a.speed: rpm}, fields: {wheel.a.speed: rpm}}",
        "time: the time is in 'stamp'; leave this key out",
    ),
    "an offset of no time": (
        TABLE
        + "take: {gyro.z: deg/s}, fields: {gyro.z: w}, frame: base, offset: late}",
        "offset: found 'late'; give a finite number",
    ),
    "an offset beyond all clocks": (
        TABLE
        + "take: {gyro.z: deg/s}, fields: {gyro.z: w}, frame: base, offset: 1e10}",
        "offset: found '1e10'; give at most 146 years, in s",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(tmp_path: Path, case: str):
    entry, words = REFUSED[case]
    line = refusal(tmp_path, entry)
    assert line.startswith("topics[0]")
    assert words in line
