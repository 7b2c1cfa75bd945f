"""A printed page packed into object streams: smaller, and the same document."""

import re
import zlib

import pytest
from pdf_objects import pdf_objects

from imo_analysis.report.pdf_pack import packed


def document(count: int) -> bytes:
    """A PDF as a browser lays it out: one page, a stream, and ``count`` small objects."""
    bodies = [b"<</Type /Catalog /Pages 2 0 R>>", b"<</Type /Pages /Kids [3 0 R] /Count 1>>",
              b"<</Type /Page /Parent 2 0 R /MediaBox [0 0 9 9] /Contents 4 0 R>>",
              b"<</Length 8>>\nstream\n0 0 m  S\nendstream",
              *(b"<</Type /StructElem /S /P /K %d>>" % k for k in range(count))]
    out, places = bytearray(b"%PDF-1.4\n"), []
    for number, body in enumerate(bodies, start=1):
        places.append(len(out))
        out += b"%d 0 obj\n%b\nendobj\n" % (number, body)
    start, size = len(out), len(bodies) + 1
    out += b"xref\n0 %d\n0000000000 65535 f \n" % size + b"".join(b"%010d 00000 n \n" % place for place in places)
    return bytes(out + b"trailer\n<</Size %d /Root 1 0 R>>\nstartxref\n%d\n%%%%EOF\n" % (size, start))


@pytest.mark.parametrize("count", [0, 1, 199, 1000])
def test_every_object_is_found_by_its_number(count: int) -> None:
    """By the stream of places, as a reader goes about it."""
    plain, small = document(count), packed(document(count))
    start = int(re.findall(rb"startxref\n(\d+)", small)[-1])
    head, data = re.match(rb"\d+ 0 obj\n<<(.*?)>>\nstream\n(.*)\nendstream", small[start:], re.DOTALL).groups()  # type: ignore[union-attr]
    assert b"/Root 1 0 R" in head and b"/W [1 4 2]" in head
    rows = zlib.decompress(data)
    places = [(rows[k], int.from_bytes(rows[k + 1:k + 5]), int.from_bytes(rows[k + 5:k + 7])) for k in range(0, len(rows), 7)]
    assert int(re.search(rb"/Size (\d+)", head)[1]) == len(places)  # type: ignore[index]
    for number, body in re.findall(rb"(\d+) 0 obj\n(.*?)\nendobj", plain, re.DOTALL):
        kind, place, index = places[int(number)]
        if kind == 1:
            assert small[place:].startswith(b"%b 0 obj\n%b\nendobj" % (number, body))
            continue
        assert kind == 2 and places[place][0] == 1
        stream = small[places[place][1]:]
        first = int(re.search(rb"/First (\d+)", stream)[1])  # type: ignore[index]
        text = zlib.decompress(re.search(rb"stream\n(.*?)\nendstream", stream, re.DOTALL)[1])  # type: ignore[index]
        heads = [int(one) for one in text[:first].split()]
        assert heads[2 * index] == int(number) and text[first + heads[2 * index + 1]:].startswith(body + b"\n")
    assert {one.strip() for one in pdf_objects(plain)} <= {one.strip() for one in pdf_objects(small)}
    assert count < 1000 or len(small) < len(plain) / 4


@pytest.mark.parametrize("change", [(b"/Root", b"/Prev 9 /Root"), (b"/Root", b"/Encrypt 4 0 R /Root"), (b"xref\n0", b"xref\n3"),
                                    (b"%%EOF", b"")])
def test_another_layout_is_left_as_it_is(change: tuple[bytes, bytes]) -> None:
    other = document(3).replace(*change)
    assert packed(other) == other
