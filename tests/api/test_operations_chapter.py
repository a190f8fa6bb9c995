"""The chapter on operations speaks of every metric that there is, and of none that there is not."""

from __future__ import annotations

import re
from pathlib import Path

from service.runtime.metrics import Metrics

CHAPTER = (Path(__file__).parents[2] / "docs" / "how-to" / "operations.md").read_text(encoding="utf-8")


def test_every_metric_is_explained() -> None:
    meters = Metrics()
    meters.stored(0, 0, [])
    families = set(re.findall(r"^# TYPE (drumtrue_\w+) ", meters.text({}).decode(), re.MULTILINE))
    there_are = {name for name in families if not name.endswith("_created")}
    assert set(re.findall(r"`(drumtrue_\w+)", CHAPTER)) == there_are
