"""`report`: a page that needs nothing else, or one line that says why not."""

import hashlib
import json
from datetime import UTC, datetime
from pathlib import Path

import pytest
from running import LINEAR, Orbident, resealed, written

from orbident.recordings.recording import Recording


@pytest.fixture
def run(orbident: Orbident, flight: Recording) -> Path:
    """A RUN in the test's own folder."""
    written(flight, "r.csv", rows=slice(0, 400))
    orbident("identify", "paper-spatial", "r.csv", "-o", "run", *LINEAR).done()
    return Path("run")


def test_identify_writes_one(orbident: Orbident, run: Path):
    page = (run / "report.html").read_text()
    checksum = hashlib.sha256(Path("r.csv").read_bytes()).hexdigest()
    assert checksum in page
    kept = json.loads((run / "result.json").read_text())
    command = "orbident identify paper-spatial r.csv -o run --method least-squares"
    date = kept["input"]["date"]
    when = datetime.strptime(date, "%Y-%m-%d %H:%M:%S UTC").replace(tzinfo=UTC)
    assert 0 <= (datetime.now(UTC) - when).total_seconds() < 600
    assert kept["input"] == {
        **{"file": "r.csv", "sha256": checksum, "command": command, "date": date}
    }
    assert {"orbident", "numpy", "scipy", "python"} == kept["versions"].keys()
    shown = {command, date, *kept["versions"].values()}
    assert all(f">{each}</td>" in page for each in shown)
    assert kept["motion"]["joints"]["joint1"]["position"][0] < 0.1

    orbident("report", run).refused("run/report.html: exists already", "--force")
    assert (run / "report.html").read_text() == page
    (run / "report.html").unlink()
    said = "the report of run says: trusted\nwritten: run/report.html\n"
    assert orbident("report", run).done().out == said
    assert (run / "report.html").read_text() == page
    assert orbident("report", run, "--force", "--quiet").done().out == ""
    ran = orbident("report", run, "--force", "--json", "-").done()
    assert ran.json == {"report": "run/report.html"}


def test_a_validation_is_in_the_report(
    orbident: Orbident, flight: Recording, run: Path
):
    """Until it is identified again; what is no validation is refused."""
    other = written(flight, "other.csv", rows=slice(400, None))
    said = orbident("validate", run, other).done().out
    assert "'orbident report run --force' shows it in the report" in said
    orbident("report", run, "--force").done()
    page = (run / "report.html").read_text()
    assert '<section id="validation">' in page
    assert "other.csv, which was not used" in page
    (run / "validation.json").write_text("{}")
    orbident("report", run, "--force").refused("validation.json: was altered")
    orbident("identify", "paper-spatial", "r.csv", "-o", "run", *LINEAR, "--force")
    assert not (run / "validation.json").exists()


def test_bad_signals(orbident: Orbident, run: Path):
    (run / "signals.parquet").write_bytes(b"PAR1 no more")
    words = "signals.parquet: is not what 'orbident identify' wrote", "identify again"
    resealed(run)
    orbident("report", run, "--force").refused(*words)


def test_bad_history(orbident: Orbident, run: Path):
    (run / "history.csv").write_text("t,M\n0,1,2\n")
    resealed(run)
    orbident("report", run, "--force").refused("history.csv", "identify again")


def test_no_run(orbident: Orbident):
    orbident("report", "nowhere").refused("nowhere/result.json: cannot be read")
    Path("run").mkdir()
    Path("run/result.json").write_text("{")
    orbident("report", "run").refused("run/result.json: is not JSON")
