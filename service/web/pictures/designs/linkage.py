"""A linkage as it moves: paths of its joints, twelve positions over a turn, and the one that a script moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from service.web.pictures.drawing import Circle, Group, Item, Line, Picture, Point, Words

WIDTH, HEIGHT = 640.0, 440.0
MARGIN, TOP = 40.0, 44.0
GHOSTS = 12
"""Positions that are drawn faintly, for paper and where no script runs."""
FRAMES = 120
"""Positions of the animation over a turn."""


@dataclass(frozen=True)
class Scene:
    """A linkage on paper: places (steps, points) of joints and mass centres by name, shapes of links as point names."""

    places: Mapping[str, tuple[Point, ...]]
    links: Mapping[str, tuple[str, ...]]
    ground: tuple[str, ...]
    centres: Mapping[str, tuple[Point, ...]]

    @classmethod
    def of(cls, drawing: Mapping[str, Any]) -> Scene:
        """The scene of an evaluation's drawing, at the largest scale at which the whole turn fits."""
        joints = drawing["joints"]
        moving = {name: joints[name] for link in drawing["links"] for name in link["points"] if name in joints}
        every = [one for places in moving.values() for one in places]
        left, right = min(x for x, _ in every), max(x for x, _ in every)
        low, high = min(y for _, y in every), max(y for _, y in every)
        room = ((WIDTH - 2 * MARGIN) / ((right - left) or 1.0), (HEIGHT - TOP - MARGIN) / ((high - low) or 1.0))
        scale = min(room)
        middle = (
            WIDTH / 2.0 - scale * (left + right) / 2.0,
            (HEIGHT + TOP - MARGIN / 2) / 2.0 + scale * (low + high) / 2.0,
        )

        def paper(places: Sequence[Sequence[float]]) -> tuple[Point, ...]:
            return tuple((middle[0] + scale * x, middle[1] - scale * y) for x, y in places)

        links = {link["name"]: tuple(name for name in link["points"] if name in joints) for link in drawing["links"]}
        centres = {name: paper(places) for name, places in drawing["centres"].items()}
        return cls({name: paper(p) for name, p in moving.items()}, links, tuple(drawing["ground"]), centres)

    @property
    def steps(self) -> int:
        """Positions over the turn."""
        return len(next(iter(self.places.values())))

    def frames(self) -> dict[str, Any]:
        """What the script moves: step by step, x and y of each point, to a tenth of a unit of the picture."""
        names = [*self.places, *(f"centre {name}" for name in self.centres)]
        tracks = [*self.places.values(), *self.centres.values()]
        chosen = [round(k * self.steps / FRAMES) % self.steps for k in range(FRAMES)]
        table = [[round(c, 1) for track in tracks for c in track[step]] for step in chosen]
        shapes = [[names.index(point) for point in points] for points in self.links.values()]
        return {"points": len(names), "joints": len(self.places), "shapes": shapes, "frames": table}


def linkage_picture(scene: Scene, title: str, words: str, step: int = 0) -> Picture:
    """Draw a linkage at a step of the turn; words: its description."""
    items: list[Item] = [Words((20.0, 22.0), title, "pic-title", "start", 17.0)]
    for name, path in scene.places.items():
        if name not in scene.ground:
            items.append(Line(path[:: max(1, scene.steps // 90)], "pic-path", closed=True))
    for k in range(GHOSTS):
        at = k * scene.steps // GHOSTS
        items += [
            _shape(tuple(scene.places[point][at] for point in points), "pic-ghost") for points in scene.links.values()
        ]
    items.append(Group(tuple(_moving(scene, step)), "moving"))
    for name in scene.ground:
        if name in scene.places:
            x, y = scene.places[name][0]
            items.append(Line(((x, y), (x - 11.0, y + 18.0), (x + 11.0, y + 18.0)), "pic-hub", closed=True))
            items.append(Words((x, y + 34.0), name, "pic-small", size=14.0))
    return Picture(WIDTH, HEIGHT, title, words, tuple(items))


def _moving(scene: Scene, step: int) -> list[Item]:
    out: list[Item] = [
        _shape(tuple(scene.places[point][step] for point in points), "pic-link") for points in scene.links.values()
    ]
    out += [Circle(path[step], 6.0, "pic-hole") for path in scene.places.values()]
    out += [Circle(path[step], 4.0, "pic-mass") for path in scene.centres.values()]
    return out


def _shape(corners: tuple[Point, ...], cls: str) -> Line:
    return Line(corners, cls, closed=True)
