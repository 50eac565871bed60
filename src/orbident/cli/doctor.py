"""`orbident doctor`."""

import platform
import re
from importlib.metadata import PackageNotFoundError, requires, version
from typing import TYPE_CHECKING

import typer

from orbident.cli.output import Output

if TYPE_CHECKING:
    from orbident.studies.spatial import SelfTest

_UNLISTED = ("all", "docs", "test")
"""Extras that are the others together, or that only developers need."""


def doctor(output: Output) -> None:
    """Check this installation: versions, extras and a self-test."""
    libraries = _libraries()
    tested, problems = _tested()
    problems += [
        f'{name} is not installed: pip install "{name}"'
        for name, installed in libraries[""].items()
        if installed is None
    ]
    output.warn(" ".join(each.split()) for each in problems)
    system = f"{platform.system()} {platform.machine()}"
    output.say(
        f"orbident {version('orbident')}, Python {platform.python_version()}, {system}",
        "libraries: " + _versions(libraries[""]),
        "compiler: not needed; the core is compiled already",
        *(
            f'extra {name}: not installed: pip install "orbident[{name}]"'
            if None in found.values()
            else f"extra {name}: {_versions(found)}"
            for name, found in sorted(libraries.items())
            if name
        ),
    )
    if tested:
        output.say(f"self-test: {_said(tested)}")
    output.write_json(
        {
            "schema": "orbident/doctor/1",
            "orbident": version("orbident"),
            "python": platform.python_version(),
            "libraries": {k: v for each in libraries.values() for k, v in each.items()},
            "extras": {
                name: None not in found.values()
                for name, found in libraries.items()
                if name
            },
            "self_test": tested and vars(tested),
            "problems": problems,
        }
    )
    if problems:
        raise typer.Exit(1)


def _tested() -> "tuple[SelfTest | None, list[str]]":
    """The self-test, and what is wrong."""
    try:
        from orbident.studies.spatial import LARGEST_ERROR, self_test

        tested = self_test()
    # Whatever is broken about the installation is what was asked for.
    except Exception as error:
        return None, [f"the self-test ended with {type(error).__name__}: {error}"]
    if tested.passed:
        return tested, []
    return tested, [
        f"the self-test is wrong: {_said(tested)}, but at most {LARGEST_ERROR:g} is "
        "right; install again: pip install --force-reinstall orbident"
    ]


def _said(tested: "SelfTest") -> str:
    return (
        f"{tested.parameters} parameters of '{tested.robot}' in "
        f"{tested.seconds:.1f} s, largest error {tested.error:.1g}"
    )


def _libraries() -> dict[str, dict[str, str | None]]:
    """Installed versions by extra and library, as the package states what it needs."""
    found: dict[str, dict[str, str | None]] = {"": {}}
    for requirement in requires("orbident") or ():
        name = re.split(r"[^\w.-]", requirement, maxsplit=1)[0]
        extra = re.search(r"extra == ['\"]([\w-]+)", requirement)
        if extra and extra[1] in _UNLISTED:
            continue
        found.setdefault(extra[1] if extra else "", {})[name] = _installed(name)
    return found


def _installed(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _versions(found: dict[str, str | None]) -> str:
    return ", ".join(f"{name} {each or 'missing'}" for name, each in found.items())
