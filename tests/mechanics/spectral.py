"""A second formulation of linkage dynamics, sharing no code with the product: positions, then derivatives by FFT.

Positions by the law of cosines; velocities, accelerations and rates of momentum and energy from Fourier series over
the turn. Shaking force = - d2/dt2 sum m r_G - weight, moment = - d/dt angular momentum - that of the weight,
torque = d/dt (kinetic and potential energy) / crank speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.mechanics.chain import Linkage

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
NOISE = 3e-15
"""Harmonics below this part of the largest are rounding: their derivatives would drown the rest."""


@dataclass(frozen=True)
class Answer:
    """Arrays (n,) over the turn."""

    force: Complexes
    moment: Floats
    torque: Floats
    joints: dict[str, Complexes]


def places(linkage: Linkage, angles: Floats) -> dict[str, tuple[Complexes, Complexes]]:
    """Origin and unit vector of the local x axis of every link."""
    links = {link.name: link for link in linkage.links}
    known: dict[str, Complexes] = {name: np.full(len(angles), place) for name, place in linkage.ground.items()}
    placed: dict[str, tuple[Complexes, Complexes]] = {}

    def settle(name: str, origin: Complexes, axis: Complexes) -> None:
        placed[name] = (origin, axis)
        for point, local in links[name].points.items():
            known.setdefault(point, origin + axis * local)

    crank = links[linkage.crank]
    pivot = next(point for point in crank.points if point in linkage.ground)
    axis = np.exp(1j * angles)
    settle(linkage.crank, known[pivot] - axis * crank.points[pivot], axis)
    for dyad in linkage.dyads:
        first, second = (links[name] for name in dyad.links)
        held = [next(point for point in link.points if point in known) for link in (first, second)]
        lp = abs(first.points[dyad.joint] - first.points[held[0]])
        lq = abs(second.points[dyad.joint] - second.points[held[1]])
        line = known[held[1]] - known[held[0]]
        cosine = (lp**2 + np.abs(line) ** 2 - lq**2) / (2.0 * lp * np.abs(line))
        corner = np.arccos(cosine) * (1.0 if dyad.side == "left" else -1.0)
        joint = known[held[0]] + lp * np.exp(1j * (np.angle(line) + corner))
        for link, support in zip((first, second), held, strict=True):
            axis = (joint - known[support]) / (link.points[dyad.joint] - link.points[support])
            settle(link.name, known[support] - axis * link.points[support], axis)
    return placed


def answer(linkage: Linkage, speed: float, samples: int) -> Answer:
    """Force and moment on the frame, and torque on the crank."""
    angles = 2.0 * math.pi * np.arange(samples) / samples
    placed = places(linkage, angles)
    layout_point = linkage.moment_point or next(
        point
        for point in next(link for link in linkage.links if link.name == linkage.crank).points
        if point in linkage.ground
    )
    about = linkage.ground[layout_point]
    momentum = np.zeros(samples, dtype=np.complex128)
    spin, energy, weight_moment = np.zeros(samples), np.zeros(samples), np.zeros(samples)
    mass = 0.0
    for link in linkage.links:
        origin, axis = placed[link.name]
        body = link.body
        centre = origin + axis * body.centre
        velocity = rate(centre, speed)
        turning = np.real(rate(axis, speed) / (1j * axis))
        arm = centre - about
        momentum += body.mass * velocity
        spin += body.mass * np.imag(np.conj(arm) * velocity) + body.central_inertia * turning
        energy += 0.5 * body.mass * np.abs(velocity) ** 2 + 0.5 * body.central_inertia * turning**2
        energy += body.mass * linkage.gravity * centre.imag
        weight_moment += body.mass * linkage.gravity * arm.real
        mass += body.mass
    joints = {
        point: placed[link.name][0] + placed[link.name][1] * local
        for link in linkage.links
        for point, local in link.points.items()
    }
    return Answer(
        -rate(momentum, speed) - 1j * mass * linkage.gravity,
        -np.real(rate(spin, speed)) - weight_moment,
        np.real(rate(energy, speed)) / speed,
        joints,
    )


def rate(values: NDArray[np.generic], speed: float) -> Complexes:
    """Derivative by time of a function of the crank angle at constant speed."""
    series = np.fft.fft(values)
    series[np.abs(series) < NOISE * np.abs(series).max()] = 0.0
    harmonics = np.fft.fftfreq(len(values), 1.0 / len(values))
    harmonics[len(values) // 2] = 0.0
    return np.asarray(np.fft.ifft(1j * harmonics * speed * series))
