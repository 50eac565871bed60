"""The settings, input, signals and versions from which the numbers came about."""

from collections.abc import Iterator

from orbident.estimation.result import Result
from orbident.report.numbers import NONE, short
from orbident.report.references import BY_METHOD, SMOOTHING, SPECTRA, THE_PAPER
from orbident.report.section import ReportTable, Section, TableRow


def provenance(result: Result) -> Section:
    """Settings, input, signals, versions."""
    tables = [
        ReportTable("Settings", ("", "value"), tuple(_settings(result)), in_words=True),
        ReportTable(
            "How signals were obtained",
            ("signal", "origin"),
            tuple(
                TableRow((name.replace("_", " "), origin))
                for name, origin in result.origins.items()
            ),
            in_words=True,
        ),
        ReportTable(
            "Clocks", ("sensor", "behind", "± std", "corrected"), tuple(_clocks(result))
        ),
        ReportTable(
            "Left out", ("column", "samples"), tuple(_left_out(result)), in_words=True
        ),
    ]
    return Section(
        name="provenance",
        title="Settings and origin",
        tables=tuple(table for table in tables if table.rows),
    )


def references(result: Result) -> Section:
    """References of the methods that were used."""
    smoothed = any("smooth" in origin for origin in result.origins.values())
    return Section(
        name="references",
        title="References",
        words=(
            THE_PAPER,
            *BY_METHOD.get(result.method, ()),
            *([SMOOTHING] if smoothed else []),
            SPECTRA,
        ),
    )


def _settings(result: Result) -> Iterator[TableRow]:
    yield TableRow(("method", result.method))
    yield TableRow(("initial momentum", result.initial_momentum))
    for file in result.input.get("recordings", [result.input]):
        yield TableRow(("recording", str(file.get("file", NONE))))
        yield TableRow(("its SHA-256", str(file.get("sha256", NONE))))
        for end in ("from", "to"):
            if end in file:
                yield TableRow((f"used {end}", f"{file[end]:g} s"))
    if result.input.get("seed") is not None:
        yield TableRow(("seed of its noise", str(result.input["seed"])))
    yield TableRow(("samples", str(result.samples)))
    yield TableRow(("computing time", f"{short(result.elapsed_s)} s"))
    for name, version in result.versions.items():
        yield TableRow((f"{name}, version", version))


def _clocks(result: Result) -> Iterator[TableRow]:
    for sensor, delay in result.clocks.items():
        late, std = (f"{short(1e3 * x, 2)} ms" for x in (delay.late, delay.std))
        yield TableRow((sensor, late, std, "yes" if delay.believed else "no"))


def _left_out(result: Result) -> Iterator[TableRow]:
    for column, reasons in result.rejected.items():
        words = ", ".join(f"{count} {reason}" for reason, count in reasons.items())
        yield TableRow((column, words))
