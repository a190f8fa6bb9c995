"""A simulated drum as a technician would describe it to the service."""

from __future__ import annotations

from typing import Any

from drivers.simulator.drum_driver import STOCK_G, DrumSpec

LIMIT_MM_S = 0.2
"""Vibration limit of the demo's drums, mm/s rms: a tenth of the quietest drum that the example draws."""
PIECES = 10
"""Pieces of each stock mass in the demo's box."""


def machine_of(
    spec: DrumSpec, name: str, *, max_masses: int = 3, limit_mm_s: float | None = LIMIT_MM_S
) -> dict[str, Any]:
    """The machine document of a simulated drum: geometry and conventions; nothing of its dynamics or unbalance."""
    return {
        "name": name,
        "type": spec.name,
        "rotor_mass_kg": spec.rotor.mass_kg,
        "service_speed_rpm": spec.speed_rpm,
        "rotation": spec.rotation,
        "seen_from": spec.seen_from,
        "balance_grade_mm_s": 16.0,
        **({} if limit_mm_s is None else {"vibration_limit_mm_s": limit_mm_s}),
        "angle_sense": spec.angle_sense,
        "phase_sense": spec.phase_sense,
        "bearings": [{"name": b.name, "axial_mm": b.axial_mm} for b in spec.rotor.bearings],
        "planes": [
            {
                "name": plane.name,
                "radius_mm": plane.radius_mm,
                "axial_mm": plane.axial_mm,
                "positions_deg": list(plane.positions_deg),
                "max_masses": max_masses,
            }
            for plane in spec.planes
        ],
        "sensors": [
            {
                "name": sensor.name,
                "axial_mm": sensor.axial_mm,
                "quantity": sensor.quantity,
                "unit": sensor.unit,
                "detection": sensor.detection,
            }
            for sensor in spec.sensors
        ],
    }


def catalogue_of(name: str, pieces: int | None = PIECES) -> dict[str, Any]:
    """The box of stock masses of the drum experiment: 10 20 50 100 200 300 g."""
    return {"name": name, "items": [{"mass_g": mass, "count": pieces} for mass in STOCK_G]}
