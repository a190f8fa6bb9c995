"""Waveforms in a universal file (UFF): its data sets 58, function at nodal DOF, that are responses over time.

Read by pyuff, which raises bare exceptions and believes the header: both are put right here. A set that the layout does
not name may hold anything.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.began import moment_of
from drivers.files.recording import SAME_RATE, Recording, read_bytes
from drivers.quantities import PER_UNIT
from drivers.signal.block import Floats
from drivers.units import level_of

TIME_RESPONSE = 1
_BEGUN_TWICE = re.compile(rb"\s*    -1 *\r?\n(?=    -1 *\r?\n)")
"""The mark of a set's beginning, of which some writers put two in front of the first."""
AXES = {0: "", 1: "X", 2: "Y", 3: "Z", 4: "RX", 5: "RY", 6: "RZ"}
QUANTITIES = {8: "displacement", 11: "velocity", 12: "acceleration"}


def read_uff(path: Path, wanted: Sequence[str] = ()) -> Recording:
    """Read a file; wanted: columns by node and direction (12+Z), first line of text, or number (#3); none: all.

    Raises `UnreadableFile` where there is none, one that is wanted can be two, or a wanted one breaks the format.
    """
    name = str(path)
    read_bytes(path)  # says what is wrong with the file itself
    sets = [one for one in _sets(path) if one.get("type") == 58 and one.get("func_type") == TIME_RESPONSE]
    if not sets:
        raise UnreadableFile("has no data set 58 with a time response: export the time histories", path=name)
    chosen = {title: _chosen(sets, title, name) for title in wanted} or _all(sets)
    columns, stated, rates, starts = {}, {}, {}, {}
    first = next(iter(chosen.values()))
    rate = 1.0 / _step(first, name)
    for title, one in chosen.items():
        columns[title] = _samples(one, title, name)
        own = 1.0 / _step(one, name)
        if abs(own - rate) > SAME_RATE * rate:
            rates[title] = own
        if (start := float(one.get("abscissa_min", 0.0))) != 0.0:
            starts[title] = start
        unit = level_of(str(one.get("ordinate_axis_units_lab", "")))[0]
        quantity = QUANTITIES.get(one.get("ordinate_spec_data_type", 0))
        stated[title] = (quantity, unit if quantity is None or unit in PER_UNIT[quantity] else None)
    began = moment_of(str(first.get("id3", "")))
    return Recording(name, rate, columns, stated, rates_hz=rates, starts_s=starts, began=began)


def _sets(path: Path) -> list[dict[str, Any]]:
    contents = path.read_bytes()
    if twice := _BEGUN_TWICE.match(contents):  # pyuff takes sets from mark to mark, and would take what is between them
        with TemporaryDirectory() as folder:
            mended = Path(folder) / path.name
            mended.write_bytes(contents[twice.end() :])
            return _sets(mended)
    import pyuff  # only those who read such files pay for it

    try:
        file = pyuff.UFF(str(path))
        kinds = [int(kind) for kind in file.get_set_types()]
    except Exception as error:  # pyuff raises bare Exception, and whatever its parsing stumbles over
        raise UnreadableFile(f"breaks the format of data set 58 ({error}): export it again", path=str(path)) from error
    found, broken = [], ""
    for index, kind in enumerate(kinds):
        if kind == 58:
            try:
                found.append(file.read_sets(index))
            except Exception as error:
                broken = str(error) or type(error).__name__
                found.append({"type": 58, "func_type": TIME_RESPONSE, "broken": broken})
    if broken and all("broken" in one for one in found):
        raise UnreadableFile(f"breaks the format of data set 58 ({broken}): export it again", path=str(path))
    return found


def _all(sets: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Every set under a name that no other has."""
    found: dict[str, dict[str, Any]] = {}
    names = [name for one in sets for name in {title_of(one), text_of(one)}]
    for number, one in enumerate(sets, start=1):
        title = next((name for name in (title_of(one), text_of(one)) if name and names.count(name) == 1), f"#{number}")
        if "broken" not in one:
            found[title] = one
    return found


def _chosen(sets: list[dict[str, Any]], name: str, path: str) -> dict[str, Any]:
    """The one set of a name. Raises `UnreadableFile` where there is none or more."""
    for matches in (title_of, text_of):
        found = [one for one in sets if matches(one) == name]
        if len(found) > 1:
            numbers = ", ".join(f"#{i}" for i, one in enumerate(sets, start=1) if matches(one) == name)
            raise UnreadableFile(f"has {_counted(len(found))} of {name}: name one by its number, {numbers}", path=path)
        if found:
            return _sound(found[0], name, path)
    if name.startswith("#") and name[1:].isdigit() and 1 <= int(name[1:]) <= len(sets):
        return _sound(sets[int(name[1:]) - 1], name, path)
    known = ", ".join(f"#{i} {title_of(one)} {text_of(one)!r}" for i, one in enumerate(sets[:20], start=1))
    raise UnreadableFile(
        f"has no column {name!r}: its columns are {known}; name one by number, node and direction, or text", path=path
    )


def _counted(count: int) -> str:
    return "two time responses" if count == 2 else f"{count} time responses"


def _sound(one: dict[str, Any], name: str, path: str) -> dict[str, Any]:
    if "broken" in one:
        raise UnreadableFile(f"breaks the format in {name} ({one['broken']}): export it again", path=path)
    return one


def _samples(one: dict[str, Any], title: str, path: str) -> Floats:
    data = np.asarray(one["data"])
    if len(data) != one.get("num_pts") or np.iscomplexobj(data) or not np.isfinite(data).all():
        raise UnreadableFile(
            f"has {len(data)} samples of {title} where {one.get('num_pts')} real finite ones are announced", path=path
        )
    return data.astype(float)


def _step(one: dict[str, Any], path: str) -> float:
    """Time from sample to sample, s; raises for an axis that is not even."""
    step = float(one.get("abscissa_inc", 0.0))
    if one.get("abscissa_spacing") != 1:
        step = _even_step(np.asarray(one.get("x", ()), float))
    if not math.isfinite(step) or not 1e-9 <= step <= 1e3 or len(one["data"]) < 2:
        raise UnreadableFile(f"has no even time axis (increment {step}): export it at a constant rate", path=path)
    return step


def _even_step(times: Floats) -> float:
    """The step of an axis that is written out, if it is even; 0 if not."""
    if len(times) < 2 or not np.isfinite(times).all():
        return 0.0
    step = float((times[-1] - times[0]) / (len(times) - 1))
    off = np.abs(times - times[0] - step * np.arange(len(times))).max()
    return step if off <= 0.5 * abs(step) else 0.0


def title_of(one: dict[str, Any]) -> str:
    """Node and direction of a set: 12+Z."""
    direction = int(one.get("rsp_dir", 0))
    axis = AXES.get(abs(direction), "")
    sign = "" if not axis else "-" if direction < 0 else "+"
    return f"{one.get('rsp_node', 0)}{sign}{axis}"


def text_of(one: dict[str, Any]) -> str:
    """The first line of text of a set, which names its channel in many files."""
    return str(one.get("id1", "")).strip()
