"""Topic maps: what each topic feeds, in which unit and frame; nothing is guessed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.schema_parts import MappingSchema, validated
from orbident.files.text import read_text
from orbident.files.yaml_mapping import read_yaml_mapping
from orbident.recordings.topics.entry import Entry
from orbident.recordings.topics.fields import Table
from orbident.recordings.topics.messages import MESSAGE_TYPES

SCHEMA = "orbident/topic-map/1"

TYPES: Mapping[str, type[Entry]] = {**MESSAGE_TYPES, "table": Table}
"""The messages that can be mapped, and the tables of files that hold no messages."""


class _TopicMap(MappingSchema):
    schema_: Literal["orbident/topic-map/1"] = Field(alias="schema")
    topics: tuple[dict[str, Any], ...] = Field(min_length=1)


def load_topic_map(path: str | Path, place: str | None = None) -> tuple[Entry, ...]:
    """Reads a topic map.

    Args:
        path: of the file.
        place: what messages call it; the path if it is not given.

    Raises:
        InputError: The file is missing, not YAML or of another schema; an entry has an
            unknown type or key, lacks a unit or a frame; or two feed one column.
    """
    place = place or str(path)
    document = read_yaml_mapping(read_text(Path(path)), place, SCHEMA)
    file = validated(_TopicMap, document, place)
    entries: list[Entry] = []
    for number, each in enumerate(file.topics):
        topic = f" ({each['topic']})" if each.get("topic") else ""
        entries.append(_entry(each, f"{place}: topics[{number}]{topic}"))
    fed: dict[str, str] = {}
    for entry in entries:
        for column in entry.columns:
            if column in fed:
                raise InputError(
                    f"{place}: column '{column}' is fed twice, by '{fed[column]}' and "
                    f"'{entry.topic}'; keep one"
                )
            fed[column] = entry.topic
    return tuple(entries)


def _entry(document: dict[str, Any], place: str) -> Entry:
    if "type" not in document:
        raise InputError(
            f"{place}: type: this key is missing; add it, 'orbident topics' shows it"
        )
    kind = str(document["type"]).replace("/msg/", "/")
    if kind not in TYPES:
        known = suggestion(kind, TYPES, "types")
        raise InputError(f"{place}: type: '{kind}' cannot be mapped; {known}")
    return validated(TYPES[kind], {**document, "type": kind}, place)
