"""Makes the fonts beside it from STIX 1.1.1 (Debian's package fonts-stix): only the glyphs that pages and figures can use.

    python imo_analysis/fonts/build.py /usr/share/fonts/opentype/stix-word

`math.woff2` is for the formulas and figures of a page, `figure.woff2` and `figure-italic.woff2` for a figure that is a file of
its own. Needs fonttools and brotli. The names are changed because the licence (OFL.txt) reserves the original one. Not imported
by the package.
"""

from __future__ import annotations

import sys
from pathlib import Path

RANGES = [
    (0x20, 0x7E),  # ASCII
    (0xA0, 0xFF),
    (0x131, 0x131),
    (0x237, 0x237),
    (0x2C6, 0x2DC),  # spacing accents
    (0x300, 0x30C),  # combining accents
    (0x391, 0x3C9),  # Greek
    (0x3D1, 0x3D6),
    (0x3F0, 0x3F5),
    (0x2010, 0x2026),
    (0x2032, 0x2034),
    (0x2061, 0x2064),  # invisible operators
    (0x20D7, 0x20D7),
    (0x2102, 0x2124),  # letterlike, R and C
    (0x2190, 0x2194),
    (0x21D2, 0x21D4),
    (0x2200, 0x2213),
    (0x221A, 0x2223),
    (0x2225, 0x222C),
    (0x2245, 0x2248),
    (0x2260, 0x226B),
    (0x2295, 0x2297),
    (0x22A5, 0x22A5),
    (0x22C5, 0x22C6),
    (0x22EE, 0x22F1),
    (0x2308, 0x230B),
    (0x239B, 0x23B3),  # pieces of tall brackets
    (0x23DE, 0x23DF),  # braces above and below
    (0x27E8, 0x27E9),
    (0x1D434, 0x1D467),  # italic Latin
    (0x1D400, 0x1D433),  # bold Latin
    (0x1D6A4, 0x1D6A5),
    (0x1D6E2, 0x1D71B),  # italic Greek
]
FIGURE = [
    (0x20, 0x7E),
    (0xA0, 0xA0),
    (0xA8, 0xA8),
    (0xAF, 0xB7),  # degree, plus-minus, powers, middle dot
    (0xD7, 0xD7),
    (0x2C6, 0x2DC),
    (0x391, 0x3C9),
    (0x3D5, 0x3D5),
    (0x2012, 0x2014),
    (0x2018, 0x2019),
    (0x201C, 0x201D),
    (0x2026, 0x2026),
    (0x2032, 0x2033),
    (0x2190, 0x2193),
    (0x2206, 0x2206),
    (0x2212, 0x2212),
    (0x221A, 0x221A),
    (0x221E, 0x221E),
    (0x2225, 0x2225),
    (0x2248, 0x2248),
    (0x2264, 0x2265),
    (0x22C5, 0x22C5),
]
LETTERS = [(0x20, 0x20), (0x41, 0x5A), (0x61, 0x7A), (0x391, 0x3C9), (0x3D5, 0x3D5)]

# target, source, family, style, code points, features of the layout that are kept
FONTS = [
    ("math.woff2", "STIXMath-Regular.otf", "Imo Math", "Regular", RANGES, ["ssty", "dtls"]),
    ("figure.woff2", "STIX-Regular.otf", "Imo Figure", "Regular", FIGURE, []),
    ("figure-italic.woff2", "STIX-Italic.otf", "Imo Figure", "Italic", LETTERS, []),
]


def build(source: Path, target: Path, family: str, style: str, ranges: list[tuple[int, int]], features: list[str]) -> int:
    """Write the subset and return its size in bytes."""
    from fontTools import subset  # type: ignore[import-untyped]
    from fontTools.ttLib import TTFont  # type: ignore[import-untyped]

    font = TTFont(source, recalcTimestamp=False)
    options = subset.Options(
        flavor="woff2", layout_features=features, notdef_outline=True, name_IDs=[0, 1, 2, 4, 6, 7, 13, 14],
        hinting=bool(features))  # a figure's letters are small and often turned: hints are bytes for nothing
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=[code for first, last in ranges for code in range(first, last + 1)])
    subsetter.subset(font)
    full = family if style == "Regular" else f"{family} {style}"
    for record in font["name"].names:
        if record.nameID in (1, 4):
            record.string = family if record.nameID == 1 else full
        elif record.nameID == 6:
            record.string = full.replace(" ", "")
    font["CFF "].cff.fontNames = [full.replace(" ", "")]
    font["CFF "].cff[0].FamilyName = family
    font["CFF "].cff[0].FullName = full
    font.flavor = "woff2"
    font.save(target)
    return target.stat().st_size


if __name__ == "__main__":
    for name, file, *how in FONTS:
        size = build(Path(sys.argv[1]) / file, Path(__file__).with_name(name), *how)  # type: ignore[arg-type]
        print(f"{name}: {size / 1024:.1f} KB")
