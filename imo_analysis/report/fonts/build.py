"""Makes `math.woff2` from STIX Math 1.1.1 (Debian's package fonts-stix): only the glyphs that the dossier can use.

    python imo_analysis/report/fonts/build.py STIXMath-Regular.otf

Needs fonttools and brotli. The name is changed because the licence (OFL.txt) reserves the original one. Not imported by the
package.
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
FAMILY = "Imo Math"


def build(source: Path, target: Path) -> int:
    """Write the subset and return its size in bytes."""
    from fontTools import subset  # type: ignore[import-untyped]
    from fontTools.ttLib import TTFont  # type: ignore[import-untyped]

    font = TTFont(source, recalcTimestamp=False)
    options = subset.Options(
        flavor="woff2", layout_features=["ssty", "dtls"], notdef_outline=True, name_IDs=[0, 1, 2, 4, 6, 7, 13, 14])
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=[code for first, last in RANGES for code in range(first, last + 1)])
    subsetter.subset(font)
    for record in font["name"].names:
        if record.nameID in (1, 4):
            record.string = FAMILY
        elif record.nameID == 6:
            record.string = FAMILY.replace(" ", "")
    font["CFF "].cff.fontNames = [FAMILY.replace(" ", "")]
    font["CFF "].cff[0].FamilyName = FAMILY
    font["CFF "].cff[0].FullName = FAMILY
    font.flavor = "woff2"
    font.save(target)
    return target.stat().st_size


if __name__ == "__main__":
    size = build(Path(sys.argv[1]), Path(__file__).with_name("math.woff2"))
    print(f"math.woff2: {size / 1024:.1f} KB")
