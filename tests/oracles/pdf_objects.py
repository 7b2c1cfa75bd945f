"""What stands in a PDF that a test looks at: its objects as text, those in object streams among them."""

import re
import zlib

_STREAM = re.compile(rb"/Type /ObjStm /N (\d+) /First (\d+).*?>>\s*stream\n(.*?)\nendstream", re.DOTALL)


def pdf_objects(pdf: bytes) -> list[bytes]:
    """Dictionaries of all objects; of a stream only its head."""
    found = re.findall(rb"\d+ 0 obj\s*(<<.*?)(?:\nstream|endobj)", pdf, re.DOTALL)
    for count, first, data in _STREAM.findall(pdf):
        text = zlib.decompress(data)
        places = [int(one) for one in text[:int(first)].split()[1::2]]
        assert len(places) == int(count)
        body = text[int(first):]
        found += [body[a:b] for a, b in zip(places, [*places[1:], len(body)], strict=True)]
    return found
