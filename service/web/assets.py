"""Files of our own that a page asks for, under an address with their digest: kept by the browser for good."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from fastapi import APIRouter, Request, Response

from service.errors import NotFound
from service.messages import Message

FOLDER = Path(__file__).parent / "static"
KINDS = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".webmanifest": "application/manifest+json",
}
FOR_GOOD = "public, max-age=31536000, immutable"

router = APIRouter(include_in_schema=False)


@cache
def files() -> dict[str, bytes]:
    """All files by name; there are few, and they are small."""
    return {p.relative_to(FOLDER).as_posix(): p.read_bytes() for p in sorted(FOLDER.rglob("*")) if p.suffix in KINDS}


@cache
def digest() -> str:
    """Digest of all files together: modules name each other by relative addresses, so they change together."""
    total = hashlib.sha256()
    for name, contents in files().items():
        total.update(name.encode() + b"\0" + contents)
    return total.hexdigest()[:12]


def address(name: str) -> str:
    """Where a page finds a file. Raises KeyError for one that is not there."""
    assert name in files(), name  # noqa: S101
    return f"/static/{digest()}/{name}"


@router.get("/static/{version}/{name:path}")
def get_static(request: Request, version: str, name: str) -> Response:
    """A file; under an earlier digest the present one, which is then not kept."""
    contents = files().get(name)
    if contents is None:
        raise NotFound(Message("not_found.file", name=name), field="name", value=name)
    tag = f'"{digest()}"'
    headers = {"cache-control": FOR_GOOD if version == digest() else "no-cache", "etag": tag}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(contents, media_type=KINDS[Path(name).suffix], headers=headers)


@router.get("/favicon.ico")
def get_icon() -> Response:
    """The icon, where a browser asks for it without being told."""
    return Response(files()["icon.svg"], media_type="image/svg+xml", headers={"cache-control": "max-age=86400"})
