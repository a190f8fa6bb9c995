"""Raw waveforms."""

from __future__ import annotations

from fastapi import APIRouter

from service.api.dependencies import ArrivalDep, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.usecases.readings import blocks
from service.usecases.readings.block_documents import BlockReceipt, RawBlock

router = APIRouter(route_class=StrictRoute)


@router.post("/blocks", status_code=201, tags=["readings"], responses=errors(404, 409))
def add_block(work: WorkDep, arrival: ArrivalDep, block: RawBlock) -> BlockReceipt:
    """Measure a block of raw waveforms and store a reading of each channel; sent again, they are stored once.

    Samples in each channel's unit (m/s2 by default), times in s from the first sample, speeds in r/min. Amplitudes come
    back in the sensors' units and detections, phases in degrees in the machine's `phase_sense`.
    """
    return blocks.ingest_block(work, block, arrival)
