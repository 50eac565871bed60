"""The settings, input, signals and versions from which the numbers came about.

Where the methods come from. Data only.
"""

from collections.abc import Iterator

from orbident.data_table import table_of
from orbident.estimation.result import Result
from orbident.preprocessing.origins import SMOOTHED, WORDS
from orbident.report.numbers import NONE, short
from orbident.report.page import Section


def provenance(result: Result) -> Section:
    """Settings, input, signals, versions."""
    origins = ((name.replace("_", " "), how) for name, how in result.origins.items())
    head, clocks = ("sensor", "behind", "± std", "corrected"), _clocks(result)
    tables = [
        table_of("Settings", ("", "value"), _settings(result), in_words=True),
        table_of("How signals were obtained", ("signal", "origin"), origins, True),
        table_of("Clocks", head, clocks),
        table_of("Left out", ("column", "samples"), _left_out(result), in_words=True),
    ]
    return Section(
        name="provenance",
        title="Settings and origin",
        tables=tuple(table for table in tables if table.rows),
    )


def references(result: Result) -> Section:
    """References of the methods that were used."""
    words = {way for origin in result.origins.values() for way in origin.split("; ")}
    smoothed = any(WORDS[each] in words for each in SMOOTHED)
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


def _settings(result: Result) -> Iterator[tuple[str, ...]]:
    yield "method", result.method
    yield "initial momentum", result.initial_momentum
    for file in result.input.get("recordings", [result.input]):
        yield "recording", str(file.get("file", NONE))
        yield "its SHA-256", str(file.get("sha256", NONE))
        for end in ("from", "to"):
            if end in file:
                yield f"used {end}", f"{file[end]:g} s"
    if result.input.get("seed") is not None:
        yield "seed of its noise", str(result.input["seed"])
    yield "samples", str(result.samples)
    yield "computing time", f"{short(result.elapsed_s)} s"
    for name, version in result.versions.items():
        yield f"{name}, version", version


def _clocks(result: Result) -> Iterator[tuple[str, ...]]:
    for sensor, delay in result.clocks.items():
        late, std = (f"{short(1e3 * x, 2)} ms" for x in (delay.late, delay.std))
        yield sensor, late, std, "yes" if delay.believed else "no"


def _left_out(result: Result) -> Iterator[tuple[str, ...]]:
    for column, reasons in result.rejected.items():
        words = ", ".join(f"{count} {reason}" for reason, count in reasons.items())
        yield column, words


THE_PAPER = (
    "On the parameter identification of free-flying space manipulator systems: "
    "momentum (Eqs. 17-26), velocity (Eqs. 27-31), mass (Eqs. 32-42)"
)

_LINEAR = (
    "G. Golub, Numerical methods for solving linear least squares problems, "
    "Numerische Mathematik 7, 1965",
    "W. Khalil, E. Dombre, Modeling, Identification and Control of Robots, 2002 "
    "(minimal sets)",
)

_MOST_LIKELY = (
    "R. Maine, K. Iliff, Identification of Dynamic Systems: Theory and Formulation, "
    "NASA RP-1138, 1985 (output error)",
    "H. G. Bock, Recent advances in parameter identification techniques for ODE, 1983 "
    "(multiple shooting)",
    "D. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, "
    "SIAM Journal on Applied Mathematics 11, 1963",
    "G. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977",
    "P. Huber, Robust estimation of a location parameter, Annals of Mathematical "
    "Statistics 35, 1964 (outliers)",
)

BY_METHOD = {
    "least-squares": _LINEAR,
    "structured": (*_LINEAR, _MOST_LIKELY[2]),
    "maximum-likelihood": (*_LINEAR, *_MOST_LIKELY),
    "recursive": (
        *_LINEAR,
        _MOST_LIKELY[3],
        "A. Willsky, H. Jones, A generalized likelihood ratio approach to the "
        "detection and estimation of jumps in linear systems, IEEE Transactions on "
        "Automatic Control 21, 1976",
        "M. Basseville, I. Nikiforov, Detection of Abrupt Changes, 1993",
    ),
}

SMOOTHING = (
    "G. Wahba, Improper priors, spline smoothing and the problem of guarding against "
    "model errors in regression, Journal of the Royal Statistical Society B 40, 1978"
)

SPECTRA = (
    "P. Welch, The use of fast Fourier transform for the estimation of power spectra, "
    "IEEE Transactions on Audio and Electroacoustics 15, 1967"
)
