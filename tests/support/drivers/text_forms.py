"""Text files as loggers write them, of any form: the numbers that were written are known."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
from hypothesis import strategies as st

ROWS = 200
START = datetime(2026, 5, 4, 8, 30, tzinfo=UTC)


@dataclass(frozen=True)
class Form:
    """How a file is written."""

    encoding: str
    separator: str
    point: str
    end: str
    quoted: bool
    head: tuple[str, ...]
    units: bool
    unused: str
    time: str
    rate: float
    tail: str


@st.composite
def written(draw: st.DrawFn) -> Form:
    separator = draw(st.sampled_from([",", ";", "\t", " ", "|"]))
    blanks = separator == " "
    head = st.lists(
        st.sampled_from(["# logger 4", "Instrument: logger", "Sample rate,2560", "", "Überwachung"]), max_size=4
    )
    times = ["s", "ms", "us", "epoch", "none", "rounded", *([] if blanks else ["iso", "clock"])]
    time = draw(st.sampled_from(times))
    return Form(
        encoding=draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])),
        separator=separator,
        point=draw(st.sampled_from([".", ","] if separator != "," else ["."])),
        end=draw(st.sampled_from(["\n", "\r\n", "\r"])),
        quoted=draw(st.booleans()) and not blanks,
        head=tuple(draw(head)),
        units=draw(st.booleans()) and not blanks,
        unused=draw(st.sampled_from(["", "text", "doubled"])),
        time=time,
        rate=draw(st.sampled_from([100.0, 640.0, 2560.0, *([] if time == "rounded" else [25600.0])])),
        tail=draw(st.sampled_from(["", "cut", "blank"])),
    )


def time_cells(form: Form) -> list[str]:
    seconds = [row / form.rate for row in range(ROWS)]
    if form.time in ("iso", "clock"):
        pattern = "%Y-%m-%d %H:%M:%S.%f" if form.time == "iso" else "%H:%M:%S.%f"
        return [(START + timedelta(seconds=one)).strftime(pattern) for one in seconds]
    scale, offset = {"ms": (1e3, 0.0), "us": (1e6, 0.0), "epoch": (1.0, START.timestamp())}.get(form.time, (1.0, 0.0))
    if form.time == "rounded":
        return [f"{one:.{2 if form.rate < 1000 else 3}f}".replace(".", form.point) for one in seconds]
    return [f"{offset + scale * one:.7f}".replace(".", form.point) for one in seconds]


def text_of(form: Form, values: np.ndarray) -> str:
    title = {"ms": "t (ms)", "us": "t [us]"}.get(form.time, "t") if form.separator != " " else "t"
    names = [*([title] if form.time != "none" else []), "kp", "P"]
    extra = {"": [], "text": ["state"], "doubled": ["AI", "AI"]}[form.unused]
    rows = [[*names, *extra]]
    if form.units:
        unit = form.time if form.time in ("ms", "us") else "s"
        rows.append([*([unit] if form.time != "none" else []), "V", "m/s²", *("-" for _ in extra)])
    times = time_cells(form)
    for time, (kp, p) in zip(times, values, strict=True):
        cells = [f"{kp:.6g}".replace(".", form.point), f"{p:.9g}".replace(".", form.point)]
        rows.append([*([time] if form.time != "none" else []), *cells, *("OK" for _ in extra)])
    if form.tail == "cut":
        rows.append(rows[-1][:2] if form.time != "none" else rows[-1][:1])
    lines = [form.separator.join(f'"{cell}"' if form.quoted else cell for cell in row) for row in rows]
    return form.end.join([*form.head, *lines, *([""] if form.tail == "blank" else [])]) + form.end
