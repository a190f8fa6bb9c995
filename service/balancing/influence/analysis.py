"""From runs to a correction and everything worth saying about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from service.balancing.influence.corrections import Correction, CorrectionOptions, least_squares, minimax
from service.balancing.influence.diagnosis import planes, readings
from service.balancing.influence.diagnosis import runs as consistency
from service.balancing.influence.diagnosis.findings import NOTHING_ELSE, Finding, RunConditions
from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.influence.speed_scatter import with_speed_scatter
from service.errors import NumericsError
from service.messages import Message

Method = Literal["least_squares", "minimax"]
_ORDER = {"error": 0, "warning": 1, "info": 2}


@dataclass(frozen=True)
class Analysis:
    """Fit, correction and findings, the gravest first."""

    fit: InfluenceFit
    correction: Correction
    findings: tuple[Finding, ...]


def analyse(
    runs: RunSet,
    wishes: CorrectionOptions | None = None,
    method: Method = "least_squares",
    circumstances: RunConditions = NOTHING_ELSE,
) -> Analysis:
    """Fit the runs, their scatter widened by their speeds, correct as wished, and examine both.

    A sensor without enough readings is left out and named in a finding. Raises NumericsError as `fit_influence`,
    `least_squares` and `minimax`.
    """
    wishes = wishes or CorrectionOptions()
    runs = with_speed_scatter(runs, circumstances.speed_rpm)
    fit = fit_influence(runs, "leave_out")
    solve = least_squares if method == "least_squares" else minimax
    try:
        correction = solve(fit, None, wishes)
    except NumericsError as error:
        raise _with_cause(error, diagnose(runs, fit, None, wishes, circumstances)) from error
    return Analysis(fit, correction, diagnose(runs, fit, correction, wishes, circumstances))


def diagnose(
    runs: RunSet,
    fit: InfluenceFit,
    correction: Correction | None,
    wishes: CorrectionOptions | None = None,
    circumstances: RunConditions = NOTHING_ELSE,
) -> tuple[Finding, ...]:
    """Examine runs as they were fitted, the fit and the correction.

    The gravest findings first, otherwise in the order of their causes.
    """
    found = readings.examine(runs, fit, circumstances)
    found += consistency.examine(runs, fit, circumstances)
    # Runs that are wrong make coefficients that are: what the planes say then would only hide the cause.
    if not any(finding.severity == "error" for finding in found):
        found += planes.examine(runs, fit, correction, wishes.weights if wishes else None)
    return tuple(sorted(found, key=lambda finding: _ORDER[finding.severity]))


def _with_cause(error: NumericsError, findings: tuple[Finding, ...]) -> NumericsError:
    """Name the gravest finding as the cause of an error, where there is one."""
    if not findings or findings[0].severity != "error":
        return error
    cause = findings[0]
    # The advice is that of the cause: what follows from it goes away with it.
    message = Message("cause", cause=cause.data, effect=error.data or error.message)
    return NumericsError(message, code=cause.code, field="runs", value=list(cause.runs))
