"""The optional libraries that read and write bags; nothing else imports them."""

# ruff: noqa: F401

from orbident.extras import extra

with extra("ros", "reading or writing a bag"):
    from mcap.exceptions import EndOfFile as McapEnd
    from mcap.reader import NonSeekingReader as McapStream
    from mcap.reader import SeekingReader as McapIndex
    from mcap.records import Channel as McapChannel
    from mcap.records import Schema as McapSchema
    from mcap.writer import Writer as McapWriter
    from rosbags.interfaces import MessageDefinition, MessageDefinitionFormat, TopicInfo
    from rosbags.rosbag1 import Reader as Ros1Reader
    from rosbags.rosbag1.reader import Header as Ros1Header
    from rosbags.rosbag1.reader import RecordType as Ros1Record
    from rosbags.rosbag1.reader import read_bytes, read_uint32
    from rosbags.rosbag2 import Reader as Ros2Reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    from rosbags.typesys.store import Typestore
