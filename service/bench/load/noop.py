"""`python -m service.bench.load.noop`: an endpoint that reads a body and answers, the limit of any other."""

from __future__ import annotations

import socket

import uvicorn
from fastapi import FastAPI, Request

app = FastAPI()


@app.post("/api/v1/readings", status_code=201)
async def take_nothing(request: Request) -> dict[str, int]:
    """Read the body, store nothing."""
    return {"accepted": len(await request.body()), "duplicates": 0}


def main() -> None:
    """Listen on a free port of this machine, say which, and answer until stopped."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        print(f"http://127.0.0.1:{listener.getsockname()[1]}")
        uvicorn.Server(uvicorn.Config(app, log_level="error", access_log=False)).run(sockets=[listener])


if __name__ == "__main__":
    main()
