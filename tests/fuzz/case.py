"""One input of the command: its arguments, and the files that it finds."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

COMMAND = "arguments.json"
"""Beside the files of a stored case."""
STDIN = "stdin"
"""The file that the command finds as its standard input, if the case has it."""
FIFO = "fifo"
"""What the name of a file begins with that the command finds as a FIFO: its content is
written once to whoever opens it."""
CLOSED, DELETED = "standard input closed", "working directory deleted"


@dataclass(frozen=True)
class Case:
    """What `orbident ARGUMENTS` is given, in a folder that holds the files."""

    group: str
    arguments: tuple[str, ...]
    files: Mapping[str, bytes]
    """Contents by relative path; a name that is not UTF-8 has surrogates, as Python
    reads it."""
    setting: str = ""
    """`CLOSED`, `DELETED` or nothing."""

    def write(self, folder: Path) -> None:
        """Put the files into a folder that exists."""
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)

    def store(self, folder: Path) -> None:
        """Keep the case, so that `stored` and a person can run it again."""
        (folder / "files").mkdir(parents=True)
        self.write(folder / "files")
        document = {"group": self.group, "arguments": self.arguments}
        document |= {"setting": self.setting}
        (folder / COMMAND).write_text(json.dumps(document) + "\n")


def stored(folder: Path) -> Case:
    """The case that `store` has kept there."""
    document = json.loads((folder / COMMAND).read_text())
    files = {
        os.fsdecode(path.relative_to(folder / "files")): path.read_bytes()
        for path in sorted((folder / "files").rglob("*"))
        if path.is_file()
    }
    arguments = tuple(document["arguments"])
    return Case(document["group"], arguments, files, document.get("setting", ""))
