"""Waveforms in a universal file (UFF): its data sets 58, function at nodal DOF, that are responses over time.

Read by pyuff, which raises bare exceptions and believes the header: both are put right here.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.recording import Recording, read_bytes

TIME_RESPONSE = 1
SAME_RATE = 1e-4
"""Increments are written with 6 digits."""
AXES = {0: "", 1: "X", 2: "Y", 3: "Z", 4: "RX", 5: "RY", 6: "RZ"}
QUANTITIES = {8: "displacement", 11: "velocity", 12: "acceleration"}
UNITS = {
    "m/s2": "m/s2", "m/s^2": "m/s2", "m/s**2": "m/s2", "m/s²": "m/s2", "g": "g", "gn": "g",
    "mm/s": "mm/s", "in/s": "in/s", "um": "um", "µm": "um", "mm": "mm", "mil": "mil", "mils": "mil",
}  # fmt: skip
"""Labels of units that are understood; any other is taken to say nothing."""


def read_uff(path: Path) -> Recording:
    """Read a file; a column for each time response, named by node and direction: 12+Z.

    Raises `UnreadableFile` where there is none, two have one name, rates or lengths differ, or a set breaks the format.
    """
    name = str(path)
    read_bytes(path)  # says what is wrong with the file itself
    sets = [one for one in _sets(path) if one.get("type") == 58 and one.get("func_type") == TIME_RESPONSE]
    if not sets:
        raise UnreadableFile("has no data set 58 with a time response: export the time histories", path=name)
    step, count = _step(sets[0], name), len(sets[0]["data"])
    columns, stated = {}, {}
    for one in sets:
        title, data = _title(one), np.asarray(one["data"])
        if title in columns:
            raise UnreadableFile(f"has two time responses of {title}: keep one of them", path=name)
        if len(data) != one.get("num_pts") or np.iscomplexobj(data) or not np.isfinite(data).all():
            raise UnreadableFile(
                f"has {len(data)} samples of {title} where {one.get('num_pts')} real finite ones are announced",
                path=name,
            )
        if len(data) != count or abs(_step(one, name) - step) > SAME_RATE * step:
            raise UnreadableFile(f"has {title} at another rate or length than the first: export them alike", path=name)
        columns[title] = data.astype(float)
        label = str(one.get("ordinate_axis_units_lab", "")).strip().lower()
        stated[title] = (QUANTITIES.get(one.get("ordinate_spec_data_type", 0)), UNITS.get(label))
    return Recording(name, 1.0 / step, columns, stated)


def _sets(path: Path) -> list[dict[str, Any]]:
    import pyuff  # only those who read such files pay for it

    try:
        file = pyuff.UFF(str(path))
        kinds = [int(kind) for kind in file.get_set_types()]
        return [file.read_sets(index) for index, kind in enumerate(kinds) if kind == 58]
    except Exception as error:  # pyuff raises bare Exception, and whatever its parsing stumbles over
        raise UnreadableFile(f"breaks the format of data set 58 ({error}): export it again", path=str(path)) from error


def _step(one: dict[str, Any], path: str) -> float:
    """Time from sample to sample, s; raises for an axis that is not even."""
    step = float(one.get("abscissa_inc", 0.0))
    if one.get("abscissa_spacing") != 1 or not math.isfinite(step) or not 1e-9 <= step <= 1e3 or len(one["data"]) < 2:
        raise UnreadableFile(f"has no even time axis (increment {step}): export it at a constant rate", path=path)
    return step


def _title(one: dict[str, Any]) -> str:
    direction = int(one.get("rsp_dir", 0))
    axis = AXES.get(abs(direction), "")
    sign = "" if not axis else "-" if direction < 0 else "+"
    return f"{one.get('rsp_node', 0)}{sign}{axis}"
