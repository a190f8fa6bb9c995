"""The nine published problems and generators with seeds, each a request as POST /arrangements takes it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np

from service.balancing.arrangement import ArrangementProblem
from service.engine.arrangement.frame import frame_of
from service.engine.arrangement.parts import Posed, pose
from service.model.arrangement import ArrangementRequest
from service.model.base import read_json

SIZES = (6, 8, 10, 12, 16, 24, 48, 112)
BAR_G, KNIFE_G = 6000.0, 540.0


@dataclass(frozen=True)
class Named:
    """A problem by its name; known: the proved optimum where it is published."""

    name: str
    request: dict[str, Any]
    known: float | None = None

    def posed(self) -> Posed:
        """The problem in arrays."""
        request = read_json(ArrangementRequest, json.dumps(self.request))
        return pose(request, request.places or (), frame_of(request, None, None))

    def problem(self) -> ArrangementProblem:
        """What the solvers take."""
        return self.posed().problem


def published() -> Iterator[Named]:
    """The nine cases, one problem for each norm with an optimum; the chopper for four moves."""
    text = resources.files("service.bench.arrangement").joinpath("cases.json").read_text(encoding="utf-8")
    for case in json.loads(text)["cases"]:
        offset = [_plane(index, complex(*value)) for index, value in enumerate(case["offset_g_mm"], start=1)]
        request = {key: case[key] for key in ("places", "parts", "planes_axial_mm")} | {"offset": offset}
        for norm, value in case.get("optimum", {}).items():
            yield Named(f"{case['name']}, {norm}", request | {"norm": norm}, value)
        if "front_max" in case:
            yield Named(f"{case['name']}, 4 moves", request | {"norm": "max", "max_moves": 4}, case["front_max"]["4"])


def generated(sizes: tuple[int, ...] = SIZES, seeds: int = 1) -> Iterator[Named]:
    """Problems by size, in one plane and two, with kinds, an unbalanced drum, and a scale of 1 g."""
    for size in sizes:
        for seed in range(1, seeds + 1):
            for planes in (1, 2):
                yield _made(size, planes, seed, kinds=False)
            if size % 2 == 0:
                yield _made(size, 2, seed, kinds=True)


def _made(size: int, planes: int, seed: int, *, kinds: bool) -> Named:
    rng = np.random.default_rng([size, planes, seed, kinds])
    knives = size > 24
    rows = 4 if knives else 1
    radius = 260.0 if knives else 310.0
    places, parts = [], []
    for n in range(size):
        axial = -700.0 + 1400.0 * (n // rows) / max(size // rows - 1, 1) if knives else None
        angle = 360.0 * (n % rows) / rows + 11.25 * (n // rows) if knives else 360.0 * n / size
        kind = {"kind": "left" if n % 2 else "right"} if kinds else {}
        at = [axial] if axial is not None else [0.0] if planes == 1 else [-600.0, 600.0]
        places.append({"label": str(n + 1), "angle_deg": angle % 360.0, "radius_mm": radius, "axial_mm": at, **kind})
        mean = KNIFE_G if knives else BAR_G
        two_ended = len(at) == 2
        reading = np.round(rng.normal(mean / 2.0 if two_ended else mean, 10.0 if two_ended else 20.0, len(at)))
        mass: Any = [float(x) for x in reading] if two_ended else float(reading[0])
        parts.append({"id": f"p{n + 1}", "mass_g": mass, "present": str(n + 1), **kind})
    drum = rng.normal(scale=8e3, size=planes) + 1j * rng.normal(scale=8e3, size=planes)
    request = {
        "places": places,
        "parts": parts,
        "offset": [_plane(p, complex(u)) for p, u in enumerate(drum, start=1)],
        "norm": "max",
        "scale_resolution_g": 1.0,
        "seed": seed,
    } | ({"planes_axial_mm": [-500.0, 500.0]} if planes == 2 else {})
    what = "knives" if knives else "bars"
    plural = "plane" if planes == 1 else "planes"
    return Named(f"{size} {what}, {planes} {plural}{', two kinds' if kinds else ''}, seed {seed}", request)


def _plane(number: int, unbalance: complex) -> dict[str, Any]:
    angle = math.degrees(math.atan2(unbalance.imag, unbalance.real))
    return {"plane": number, "unbalance_g_mm": abs(unbalance), "angle_deg": angle}
