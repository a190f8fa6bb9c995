"""Units as DBCs, files and people spell them, turned into the ones that Drumtrue names."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping

SPELLINGS: Mapping[str, Mapping[str, str]] = {
    "displacement": {
        "um": "um µm micron microns micrometer micrometers micrometre micrometres mikrometer",
        "mm": "mm millimeter millimeters millimetre millimetres",
        "mil": "mil mils thou",
    },
    "velocity": {
        "mm/s": "mm/s mm/sec mms-1 mms^-1 mm*s^-1 mm.s-1 mm/second",
        "in/s": "in/s in/sec ips inch/s inches/s inch/sec inches/sec",
    },
    "acceleration": {
        "m/s2": "m/s2 m/s^2 m/s**2 m/s/s m/sec2 m/sec^2 ms-2 ms^-2 m*s^-2 m.s-2",
        "g": "g gn g's gs g0 grav",
    },
    "speed": {
        "rpm": "rpm r/min rev/min revs/min 1/min min-1 min^-1 /min u/min upm tr/min giri/min rot/min r.p.m. r/m o/min",
        "Hz": "hz 1/s s-1 s^-1 rps rev/s revs/s u/s",
        "rad/s": "rad/s rad/sec",
    },
    "angle": {
        "deg": "deg degs degree degrees ° º â° angulardegree",
        "rad": "rad radian radians",
    },
    "mass": {"g": "g gram grams gr gramm gramme", "kg": "kg kilogram kilograms", "mg": "mg", "oz": "oz ounce ounces"},
}
"""Spellings, in lower case and without blanks, by quantity and by the name that Drumtrue uses."""
PER_RPM = {"rpm": 1.0, "Hz": 60.0, "rad/s": 30.0 / math.pi}
PER_DEGREE = {"deg": 1.0, "rad": 180.0 / math.pi}
PER_GRAM = {"g": 1.0, "kg": 1000.0, "mg": 1e-3, "oz": 28.349523125}
"""One unit in r/min, degrees, g; the ounce as in the international yard and pound agreement of 1959."""

_DETECTIONS = (
    (re.compile(r"(?:^|[\s(\[_-])(p-p|pk-pk|pp|pkpk|peak[-_ ]to[-_ ]peak|p2p)[)\]]?$"), "peak_to_peak"),
    (re.compile(r"(?:^|[\s(\[_-])(0-p|0-pk|pk|peak|o-p|zero[-_ ]to[-_ ]peak)[)\]]?$"), "peak"),
    (re.compile(r"(?:^|[\s(\[_-])(r\.?m\.?s\.?|eff|effektiv)[)\]]?$"), "rms"),
)


def unit_of(text: str, quantity: str) -> str | None:
    """Drumtrue's name of a unit of a quantity (a key of `SPELLINGS`); None for one that is not known."""
    plain = _plain(text)
    for unit, spellings in SPELLINGS[quantity].items():
        if plain in spellings.split():
            return unit
    return None


def level_of(text: str) -> tuple[str | None, str | None]:
    """Unit of a vibration level, and the detection that is written with it (`mm/s RMS`); each None if not known."""
    rest, detection = text.strip().casefold(), None
    for pattern, name in _DETECTIONS:
        if found := pattern.search(rest):
            rest, detection = rest[: found.start()], name
            break
    for quantity in ("velocity", "displacement", "acceleration"):
        if (unit := unit_of(rest, quantity)) is not None:
            return unit, detection
    return None, detection


def _plain(text: str) -> str:
    """Lower case without blanks and brackets around, the signs for micro and squared as their usual letters."""
    spread = unicodedata.normalize("NFKC", text.replace("²", "2").replace("³", "3").replace("⁻", "-")).casefold()
    return re.sub(r"\s+", "", spread).replace("μ", "µ").replace("·", "*").strip("[]()")
