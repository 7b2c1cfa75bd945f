"""A PDF with its small objects packed: a browser writes a tagged page as tens of thousands of them, each as plain text.

PDF 1.5 (ISO 32000-1, 7.5.7 and 7.5.8) keeps objects that are no streams in compressed object streams, and the table of places
in a stream, too. Nothing else changes: the objects keep their numbers and their text.
"""

from __future__ import annotations

import re
import zlib

TOGETHER = 200  # objects in a stream: a reader unpacks a whole stream for one of them
_START = re.compile(rb"startxref\s+(\d+)\s+%%EOF\s*\Z")
_TABLE = re.compile(rb"xref\s+0 (\d+)\s*\n")
_TRAILER = re.compile(rb"trailer\s*<<(.*?)>>\s*startxref", re.DOTALL)
_OBJECT = re.compile(rb"\s*(\d+) 0 obj\s*(.*?)\s*endobj\s*\Z", re.DOTALL)
_LINE = 20  # bytes of a place in the table


def packed(pdf: bytes) -> bytes:
    """The same document, smaller; as it is where it is not laid out as a browser does it (one table, no later changes)."""
    start = _START.search(pdf)
    table = _TABLE.match(pdf, int(start[1])) if start else None
    trailer = _TRAILER.search(pdf, table.end()) if table else None
    if table is None or trailer is None or b"/Prev" in trailer[1] or b"/Encrypt" in trailer[1]:
        return pdf
    lines = [pdf[at:at + _LINE] for at in range(table.end(), table.end() + _LINE * int(table[1]), _LINE)]
    places = sorted(int(line[:10]) for line in lines if line[17:18] == b"n")
    objects = [_OBJECT.match(pdf[a:b]) for a, b in zip(places, [*places[1:], table.start()], strict=True)]
    if not objects or any(one is None for one in objects):
        return pdf
    bodies = {int(one[1]): one[2] for one in objects if one is not None}
    streams = {number: body for number, body in bodies.items() if body.endswith(b"endstream")}
    small = [number for number in sorted(bodies) if number not in streams]
    found: dict[int, tuple[int, int, int]] = {0: (0, 0, 65535)}  # number -> kind, place, generation or index
    out = bytearray(b"%PDF-1.5\n%\xd3\xeb\xe9\xe1\n")
    last = int(table[1])
    for at in range(0, len(small), TOGETHER):
        group = small[at:at + TOGETHER]
        texts = [bodies[number] + b"\n" for number in group]
        heads = b" ".join(b"%d %d" % (number, sum(map(len, texts[:k]))) for k, number in enumerate(group))
        about = b"/Type /ObjStm /N %d /First %d" % (len(group), len(heads) + 1)
        streams[last] = _stream(about, heads + b"\n" + b"".join(texts))
        found |= {number: (2, last, k) for k, number in enumerate(group)}
        last += 1
    for number, body in streams.items():
        found[number] = (1, len(out), 0)
        out += b"%d 0 obj\n%b\nendobj\n" % (number, body)
    here = len(out)
    found[last] = (1, here, 0)
    rows = b"".join(bytes([kind]) + place.to_bytes(4) + rest.to_bytes(2)
                    for kind, place, rest in (found.get(number, (0, 0, 65535)) for number in range(last + 1)))
    more = re.sub(rb"/Size \d+", b"", trailer[1]).strip()
    body = _stream(b"/Type /XRef /Size %d /W [1 4 2] %b" % (last + 1, more), rows)
    return bytes(out + b"%d 0 obj\n%b\nendobj\nstartxref\n%d\n%%%%EOF\n" % (last, body, here))


def _stream(head: bytes, data: bytes) -> bytes:
    small = zlib.compress(data, 9)
    return b"<<%b /Filter /FlateDecode /Length %d>>\nstream\n%b\nendstream" % (head, len(small), small)
