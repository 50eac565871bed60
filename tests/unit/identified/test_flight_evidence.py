"""What can be shown of a flight build by other tools: coverage, MISRA, stack, size.

What they print stands in docs/how-to/flight-computer.md.
"""

import json
import re
import shutil
from collections import Counter
from pathlib import Path

import pytest
from flight_builds import (
    CHECKS,
    WARNINGS,
    exported,
    needs_compilers,
    one_joint,
    ran,
    sliding,
)
from processes import finished

pytestmark = needs_compilers

FLIGHT = (
    "-std=c++17",
    "-fno-exceptions",
    "-fno-rtti",
    "-fno-math-errno",
    "-fno-threadsafe-statics",
    "-ffp-contract=off",
)
CORTEX = ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-mthumb")


def includes(folder: Path) -> list[object]:
    return [f"-I{folder}", f"-I{folder / 'include'}", "-isystem", folder / "eigen"]


def needs(*programs: str) -> pytest.MarkDecorator:
    """Skips a test where a program is missing that Orbident itself does not need."""
    missing = [name for name in programs if shutil.which(name) is None]
    reason = f"{', '.join(missing)}: to look at flight builds only, and not installed"
    return pytest.mark.skipif(bool(missing), reason=reason)


@pytest.fixture(scope="module")
def spatial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("flight") / "f"
    return exported(folder, "paper-spatial", 16.0, 10.0)


@pytest.fixture(scope="module")
def compiled(spatial: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The filter, which may be linked into a program or a shared library."""
    out = tmp_path_factory.mktemp("compiled") / "flight.o"
    flags = (*FLIGHT, "-O2", "-fPIC", *WARNINGS, *includes(spatial))
    ran("c++", *flags, "-c", spatial / "flight.cpp", "-o", out)
    return out


@pytest.mark.slow
@needs("ld")
def test_a_linked_program_has_no_heap(compiled: Path, tmp_path: Path):
    """The filter alone in a shared library: the map names what it draws in."""
    out, map_ = tmp_path / "flight.so", tmp_path / "map"
    shared = ("-shared", "-nostdlib", f"-Wl,-Map={map_}")
    ran("c++", *shared, compiled, "-o", out)
    told = map_.read_text()
    assert "orbident_step" in told
    assert not re.search(r"malloc|calloc|realloc|free\b|_Zn|_Zd|__cxa", told)


@pytest.mark.long
@needs("gcov")
def test_branches_are_taken(spatial: Path, tmp_path: Path):
    """Of our own headers, without optimisation, by the checks of four robots."""
    robots = [spatial]
    for make in (one_joint, sliding):
        at = tmp_path / make.__name__
        at.mkdir()
        robots.append(exported(at / "f", make(at), 16.0, 10.0))
    robots.append(exported(tmp_path / "plane", "cepheus-like", 12.0, 10.0))
    object_ = tmp_path / "flight.o"
    coverage = ("-O0", "--coverage", *includes(spatial))
    ran("c++", *FLIGHT, *coverage, "-c", spatial / "flight.cpp", "-o", object_)
    for folder in robots:
        for source, runs in (
            (folder / "main.c", [()]),
            (CHECKS, [("refusals",), ("fuzz", 3000, 1)]),
        ):
            out = tmp_path / "program"
            ran("cc", *includes(folder), source, object_, "-lm", "-lgcov", "-o", out)
            for run in runs:
                ran(out, *run)
    taken, every = branches(object_)
    share = taken.total() / every.total()
    print(f"{taken.total()} of {every.total()}: {100 * share:.1f} %")
    assert share >= 0.95


def branches(object_: Path) -> tuple[Counter[str], Counter[str]]:
    """Those that were taken, and all, in each of our headers."""
    told = json.loads(ran("gcov", "--branch-probabilities", "--stdout", "-j", object_))
    taken, every = Counter(), Counter()
    for file in told["files"]:
        if "orbident/" in file["file"]:
            found = [branch for line in file["lines"] for branch in line["branches"]]
            every[file["file"]] = len(found)
            taken[file["file"]] = sum(branch["count"] > 0 for branch in found)
    return taken, every


@pytest.mark.slow
def test_an_application_for_cfs(spatial: Path, compiled: Path, tmp_path: Path):
    """The example against our own stubs of cFE: every estimate that it sends."""
    example = CHECKS.parents[3] / "examples" / "cfs"
    stubs = CHECKS.parent / "cfs_stubs"
    out = tmp_path / "app"
    sources = (example / "orbident_app.c", stubs / "bus.c", compiled)
    paths = (f"-I{stubs}", f"-I{example}", *includes(spatial))
    ran("cc", "-std=gnu11", "-O1", *WARNINGS, *paths, *sources, "-lm", "-o", out)
    assert re.match(r"(\d+) of \1 agree", ran(out))


DEVIATIONS = {
    "flight.cpp": {"12.3", "2.3"},
    "main.c": {"12.3", "2.4", "2.5", "20.5"},
}
"""Rules of MISRA C 2012 that our headers do not keep; the how-to gives the reasons."""


@needs("cppcheck")
@pytest.mark.parametrize("source", DEVIATIONS)
def test_deviations_from_misra_are_listed(spatial: Path, source: str):
    """Those of the library, in C++ and as a program in C sees it.

    The program that replays a recording is an example of its use, not flight code.
    """
    paths = [f"-I{spatial}", f"-I{spatial / 'include'}"]
    form = "--template={file} {id}"
    run = finished("cppcheck", "-q", "--addon=misra", form, *paths, source, cwd=spatial)
    ours = re.compile(r"^(?!main\.c|golden|eigen)\S+ misra-c2012-(\S+)", re.M)
    found = ours.findall(run.stderr)
    print(source, sorted(Counter(found).items()))
    assert found
    assert {*found} <= DEVIATIONS[source]


@needs("arm-none-eabi-g++", "arm-none-eabi-size")
def test_it_is_compiled_for_a_small_processor(spatial: Path, tmp_path: Path):
    for level, most in (("-Os", 25_000), ("-O2", 31_500)):
        object_ = tmp_path / "flight.o"
        flags = (*FLIGHT, *CORTEX, level, "-fstack-usage", *includes(spatial))
        source = spatial / "flight.cpp"
        ran("arm-none-eabi-g++", *flags, "-c", source, "-o", object_)
        text, data, bss = map(
            int, ran("arm-none-eabi-size", object_).splitlines()[1].split()[:3]
        )
        frames = [
            int(line.split("\t")[1])
            for line in object_.with_suffix(".su").read_text().splitlines()
        ]
        print(f"{level}: text {text}, frames {sum(frames)}, largest {max(frames)}")
        assert text < most
        assert (data, bss) == (0, 0)
