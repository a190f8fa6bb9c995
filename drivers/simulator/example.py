"""A threshing drum to try things on: 120 kg, 460 rpm, as in the published field experiment.

Mass, eccentricity, bearings, planes and positions are the published ones; inertia, stiffness and damping, which were
not published, are chosen so that the drum as found reads close to the published 3.109 and 4.785 mm/s rms, well below
its first resonance (about 1500 rpm).
"""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np

from drivers.simulator.rotor import Bearing, Rotor, Unbalance
from drivers.simulator.sensors import Sensor
from drivers.simulator.spec import DrumSpec, Plane, Scatter, true_readings

MASS_KG = 120.0
ECCENTRICITY_MM = (-0.154, 1.20)
RADIUS_MM = 330.0
PLANES_MM = {"1": -330.0, "2": 330.0}
BEARINGS_MM = {"P": -480.0, "Q": 440.0}
POSITIONS_DEG = tuple(20.0 * hole for hole in range(1, 19))
STOCK_G = (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)

NEEDED_G = (100.0, 450.0)
"""What a drawn drum needs in each plane: no less, for a drum that needs nothing is not balanced; no more, for three
pieces of the stock must do."""
MIN_READING_MM_S = 2.0
"""What each sensor of a drawn drum reads at least: a quieter drum is left alone."""


def threshing_drum_example(seed: int | None = None) -> DrumSpec:
    """Describe the published drum; with a seed, the same drum with a static and a couple unbalance drawn at random.

    A drawn unbalance can be cancelled by 100 to 450 g at the radius of each plane, and both sensors read at least
    2 mm/s rms. Masses in stock for it: `STOCK_G`.
    """
    x, y = ECCENTRICITY_MM
    found = Unbalance(0.0, 1000.0 * MASS_KG * math.hypot(x, y), math.degrees(math.atan2(y, x)))
    published = DrumSpec(
        name="threshing drum",
        rotor=Rotor(
            MASS_KG,
            polar_inertia=6.5,
            transverse_inertia=13.0,
            bearings=(
                Bearing("P", BEARINGS_MM["P"], 1.92e6, 2.60e6, 1500.0, 1800.0),
                Bearing("Q", BEARINGS_MM["Q"], 1.378e6, 2.10e6, 1400.0, 1700.0),
            ),
        ),
        planes=tuple(Plane(name, RADIUS_MM, place, POSITIONS_DEG) for name, place in PLANES_MM.items()),
        sensors=tuple(Sensor(name, place, noise=0.01, broadband_rms=0.3) for name, place in BEARINGS_MM.items()),
        unbalances=(found,),
        speed_rpm=460.0,
        rotation="cw",
        pickup_deg=90.0,
        seen_from="the end of bearing Q",
        scatter=Scatter(amplitude=0.03, phase_deg=2.0, run_speed=0.005),
    )
    return published if seed is None else _drawn(published, np.random.default_rng(seed))


def _drawn(drum: DrumSpec, rng: np.random.Generator) -> DrumSpec:
    """Draw a static and a couple unbalance, again until the drum is one worth balancing."""
    while True:
        static_g, couple_g = rng.uniform(100.0, 600.0), rng.uniform(0.0, 300.0)
        static_turn, couple_turn = rng.uniform(0.0, math.tau, 2)
        half = cmath.rect(static_g / 2.0, static_turn)
        couple = cmath.rect(couple_g, couple_turn)
        needed = (half - couple, half + couple)
        unbalances = tuple(
            Unbalance(plane.axial_mm, abs(grams) * plane.radius_mm, math.degrees(cmath.phase(grams)))
            for plane, grams in zip(drum.planes, needed, strict=True)
        )
        candidate = replace(drum, unbalances=unbalances)
        in_stock = all(NEEDED_G[0] <= abs(grams) <= NEEDED_G[1] for grams in needed)
        if in_stock and all(amplitude >= MIN_READING_MM_S for amplitude, _ in true_readings(candidate).values()):
            return candidate
