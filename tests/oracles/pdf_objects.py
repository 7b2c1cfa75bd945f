"""What stands in a PDF that a test looks at: its objects as text."""

import re


def pdf_objects(pdf: bytes) -> list[bytes]:
    """Dictionaries of all objects; of a stream only its head."""
    return re.findall(rb"\d+ 0 obj\s*(<<.*?)(?:\nstream|endobj)", pdf, re.DOTALL)
