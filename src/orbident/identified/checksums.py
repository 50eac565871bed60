"""What a result and the files beside it held when it was written."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from orbident.errors import InputError
from orbident.estimation.result import SCHEMA
from orbident.files.checksum import sha256
from orbident.files.names import quoted

FILES, OWN = "files", "sha256"
"""Keys of `result.json`: the SHA-256 of every file, and of all else in itself."""


def with_checksums(
    document: Mapping[str, Any], folder: Path, names: Iterable[str]
) -> dict[str, Any]:
    """The content of `result.json`, with the checksums that its reader checks.

    Args:
        document: the result.
        folder: of the files.
        names: of those that may be there.

    Raises:
        InputError: a file cannot be read.
    """
    there = [name for name in names if (folder / name).is_file()]
    files = {name: sha256(folder / name) for name in there}
    whole = {**document, FILES: files}
    return {**whole, OWN: _digest(whole)}


def check_document(document: Mapping[str, Any], path: Path) -> None:
    """Refuse a `result.json` that is not as it was written.

    Raises:
        InputError: it has no checksums, or was altered.
    """
    schema = document.get("schema") if isinstance(document, Mapping) else None
    if schema != SCHEMA:
        raise InputError(
            f"{path}: schema: found {quoted(schema)}, expected '{SCHEMA}'; identify "
            "again"
        )
    if not {FILES, OWN} <= document.keys():
        raise InputError(
            f"{path}: has no checksums, so an earlier orbident wrote it, and whether "
            "it is complete cannot be known; identify again"
        )
    whole = {key: value for key, value in document.items() if key != OWN}
    if _digest(whole) != document[OWN]:
        raise InputError(_altered(path))


def check_files(files: Mapping[str, str], folder: Path, names: Iterable[str]) -> None:
    """Refuse files that are not as they were written.

    Args:
        files: their checksums, by name.
        folder: where they are.
        names: of those that are looked at.

    Raises:
        InputError: a file is missing, cut off or altered, or belongs to no result.
    """
    for name in names:
        path = folder / name
        if name not in files and path.exists():
            raise InputError(f"{path}: does not belong to this result; move it away")
        if name in files and not path.is_file():
            raise InputError(f"{path}: is missing; identify again")
        if name in files and sha256(path) != files[name]:
            raise InputError(_altered(path))


def _digest(document: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _altered(path: Path) -> str:
    return (
        f"{path}: was altered or cut off after 'orbident identify' wrote it; "
        "identify again"
    )
