"""Topic maps of laboratories and tools, one file each."""

import re
from importlib.resources import files
from pathlib import Path

from orbident.files.names import quoted, refuse_unknown

_FOLDER = Path(str(files(__name__)))


def presets() -> tuple[str, ...]:
    """The names of the maps that come with the package, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def preset_path(name: str) -> Path:
    """Where the map of this name is."""
    return _FOLDER / f"{name}.yaml"


def preset_topics(name: str) -> set[str]:
    """The topics that the map of this name is for."""
    return set(re.findall(r"topic: ([^,\s]+)", preset_path(name).read_text("utf-8")))


def known_preset(name: str) -> str:
    """The name, if there is such a map.

    Raises:
        InputError: There is none.
    """
    fault = f"--preset {quoted(name)}: there is no such map"
    refuse_unknown(name, presets(), fault, "presets")
    return name
