"""OEM files, written by the library that reads them."""

from datetime import datetime
from pathlib import Path

import numpy as np
from astropy.time import Time, TimeDelta
from oem import OrbitEphemerisMessage
from oem.components import EphemerisSegment, HeaderSection, MetaDataSection


def write_oem(
    path: Path,
    epoch: datetime,
    t: np.ndarray,
    states: np.ndarray,
    kind: str = "kvn",
    **metadata: str,
) -> OrbitEphemerisMessage:
    """Write states, m and m/s, at times after the epoch, and give what was written."""
    scale = metadata.get("TIME_SYSTEM", "UTC").lower()
    zero = getattr(Time(epoch, scale="utc", precision=6), scale)
    times = [zero + TimeDelta(each, format="sec") for each in t]
    start, stop = times[0].isot, times[-1].isot
    fields = {
        "OBJECT_NAME": "SERVICER",
        "OBJECT_ID": "2026-001A",
        "CENTER_NAME": "EARTH",
        "REF_FRAME": "EME2000",
        "TIME_SYSTEM": "UTC",
        "START_TIME": start,
        "STOP_TIME": stop,
        "INTERPOLATION": "HERMITE",
        "INTERPOLATION_DEGREE": "7",
        **metadata,
    }
    header = HeaderSection(
        {
            "CCSDS_OEM_VERS": "2.0",
            "CREATION_DATE": start,
            "ORIGINATOR": "ORBIDENT",
        }
    )
    columns = (times, *(states.T / 1e3).tolist())
    segment = EphemerisSegment(MetaDataSection(fields), columns)
    message = OrbitEphemerisMessage(header, [segment])
    message.save_as(path, file_format=kind)
    return message
