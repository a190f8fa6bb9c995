"""What the measurement cannot tell of an objective, to first order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.influence.fit import predict
from service.engine.influence_fits import FittedModel
from service.engine.logs.replay import last_problem
from service.engine.objective_uncertainty import objective_scatter
from service.engine.selection_problem import PlanProblem
from service.model.plan import ObjectiveName
from tests.support.numerics.drum_log import session


def known() -> tuple[FittedModel, PlanProblem]:
    fitted, posed = last_problem(session())
    assert fitted is not None
    assert posed is not None
    return fitted, posed


FITTED, POSED = known()
OBJECTIVE, TARGET = POSED.objective, POSED.target
SPREAD = np.sqrt(2.0) * predict(FITTED.fit, TARGET).scatter / 0.7


@pytest.mark.parametrize(
    ("norm", "wanted"),
    [
        ("sum", float(np.sqrt((SPREAD**2).sum()))),
        ("rms", float(np.sqrt((SPREAD**2).mean()))),
        ("max", float(SPREAD.max())),
    ],
)
def test_residual_vibration_scatters_as_the_sensors_do(norm: str, wanted: float) -> None:
    objective = replace(OBJECTIVE, norm=norm)  # type: ignore[arg-type]
    assert objective_scatter(objective, "residual_vibration", FITTED, TARGET) == pytest.approx(wanted)


def test_without_a_fit_or_its_scatter_nothing_is_known() -> None:
    assert objective_scatter(OBJECTIVE, "residual_vibration", None, TARGET) == 0.0
    unknown = replace(FITTED, fit=replace(FITTED.fit, covariance=np.full_like(FITTED.fit.covariance, np.nan)))
    assert objective_scatter(OBJECTIVE, "residual_vibration", unknown, TARGET) == 0.0


def test_ten_times_the_scatter_is_ten_times_the_uncertainty() -> None:
    wide = replace(FITTED, fit=replace(FITTED.fit, covariance=100.0 * FITTED.fit.covariance))
    names: tuple[ObjectiveName, ...] = ("components", "bearing_force")
    for name in names:
        one, ten = (objective_scatter(OBJECTIVE, name, fit, TARGET) for fit in (FITTED, wide))
        assert ten == pytest.approx(10.0 * one, rel=0.05)
        assert one > 0.0
