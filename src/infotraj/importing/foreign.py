"""Files that are no log as they stand but hold one: packed, or text in another encoding; and how to get it out."""

from __future__ import annotations

from pathlib import Path

from infotraj.suggested import quoted

# First bytes: what it is, and what to do with the file in place of {}.
_PACKED = (
    (b"\x1f\x8b", "gzip data", "Unpack it: gunzip -k {}"),
    (b"BZh", "bzip2 data", "Unpack it: bunzip2 -k {}"),
    (b"\xfd7zXZ\x00", "xz data", "Unpack it: unxz -k {}"),
    (b"\x28\xb5\x2f\xfd", "zstd data", "Unpack it: unzstd {}"),
    (b"PK\x03\x04", "a zip archive or a spreadsheet", "Unpack it: unzip {}; a spreadsheet is to be saved as CSV."),
)
_ENCODED = (
    ((b"\xff\xfe", b"\xfe\xff"), "UTF-16"),
    ((b"",), "ISO-8859-1"),
)


def foreign(head: bytes, path: Path) -> tuple[str, str] | None:
    """What the file holds and what to do with it, by its first bytes; None where they say nothing."""
    name = quoted(path)
    for magic, what, remedy in _PACKED:
        if head.startswith(magic):
            return what, remedy.format(name)
    for marks, encoding in _ENCODED:
        if head.startswith(marks) and _is_text(head, encoding):
            what = f"text in {encoding}" if marks[0] else f"text that is not in UTF-8, maybe in {encoding}"
            return what, f"Write it in UTF-8: iconv -f {encoding} -t UTF-8 {name} > NEW.csv"
    return None


def _is_text(head: bytes, encoding: str) -> bool:
    text = head[: len(head) // 2 * 2].decode(encoding, errors="replace")
    return all(c.isprintable() or c in "\t\r\n" for c in text)
