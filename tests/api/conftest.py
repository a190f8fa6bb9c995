"""Sessions that the tests of a module share."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.http.tiny_bench import Bench, bench_on
from tests.support.http.workshop import DRUM, Workshop, machine_body, mass, reading


@pytest.fixture(scope="module")
def bench(shared_shop: Workshop) -> Bench:
    """A bench that tests share: they only add plans to it."""
    return bench_on(shared_shop)


@pytest.fixture(scope="module")
def noisy(shared_shop: Workshop) -> Bench:
    """Six masses a plane of twelve kinds, and readings that scatter."""
    box = shared_shop.box(count=4, masses=[10.0, 15.0, 20.0, 25.0, 30.0, *(10.0 * n for n in range(4, 11))])
    planes = [{**plane, "max_masses": 6} for plane in machine_body()["planes"]]
    session = shared_shop.session(shared_shop.machine(planes=planes), box)
    rng = np.random.default_rng(8)
    for masses in ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)]):
        readings = [
            reading(s, v + complex(*rng.normal(0.0, 0.02, 2)), scatter=0.02) for s, v in DRUM.vibration(masses).items()
        ]
        kind = "trial" if masses else "initial"
        shared_shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})
    return Bench(shared_shop, session, box, shared_shop.correct(session))
