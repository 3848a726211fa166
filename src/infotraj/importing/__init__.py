"""From any log to a flight table: `import_log`, `read_streams` (before the common clock), `recognise`."""

from infotraj.importing.importer import import_log, to_flight
from infotraj.importing.mapping import Mapping
from infotraj.importing.mapping_files import load_mapping, parse_mapping, shipped
from infotraj.importing.reading import Stream, Streams, read_streams
from infotraj.importing.recognise import recognise
from infotraj.importing.settings import Settings, parse_settings
from infotraj.importing.streams import Plan

__all__ = [
    "Mapping",
    "Plan",
    "Settings",
    "Stream",
    "Streams",
    "import_log",
    "load_mapping",
    "parse_mapping",
    "parse_settings",
    "read_streams",
    "recognise",
    "shipped",
    "to_flight",
]
