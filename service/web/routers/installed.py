"""What makes the pages an application of the tablet: manifest, service worker, the page for a lost link."""

from __future__ import annotations

import json
from functools import cache

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from service.web.assets import KINDS, address, digest, files
from service.web.rendering import HEADERS, PageDep

router = APIRouter()

COLOUR = "#0b4f8a"
CHECKED = {**HEADERS, "cache-control": "no-cache"}
"""Kept by the browser, but asked for each time: a new version is noticed at once. The worker fetches under the policy
of the pages, since the policy of other answers lets it fetch nothing."""
WORKER = "worker.js"


@cache
def _worker() -> str:
    """The service worker with the version and addresses of the files that it keeps."""
    kept = [address(name) for name in files() if name != WORKER]
    head = f"const VERSION = {json.dumps(digest())};\nconst FILES = {json.dumps(kept)};\n"
    return head + files()[WORKER].decode()


@router.get("/worker.js")
def get_worker() -> Response:
    """The service worker, at the root: it stands for every page."""
    return Response(_worker(), media_type=KINDS[".js"], headers=CHECKED)


@router.get("/manifest.webmanifest")
def get_manifest(page: PageDep) -> Response:
    """Name, colours and icons, for a tablet that installs the pages."""
    icons = [
        {"src": address("icon.svg"), "sizes": "any", "type": "image/svg+xml"},
        {"src": address("icon-192.png"), "sizes": "192x192", "type": "image/png"},
        {"src": address("icon-512.png"), "sizes": "512x512", "type": "image/png", "purpose": "any maskable"},
    ]
    told = {
        "id": "/",
        "name": "Drumtrue",
        "short_name": "Drumtrue",
        "lang": page.language,
        "start_url": "/",
        "scope": "/",
        "display": "standalone",
        "background_color": COLOUR,
        "theme_color": COLOUR,
        "icons": icons,
    }
    return Response(json.dumps(told), media_type=KINDS[".webmanifest"], headers=CHECKED)


@router.get("/offline")
def show_offline(page: PageDep) -> HTMLResponse:
    """What the tablet shows where it has no link and has not seen the page before."""
    return page.render("offline.html")
