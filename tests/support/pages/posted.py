"""Every form that the pages take, read off their routes: a form that no table knows is found."""

from __future__ import annotations

import re

from fastapi.routing import iter_route_contexts

from service.web import form_tokens, pages

POSTED = sorted(
    {
        re.sub(r"{[^}]*}", "x", one.path or "")
        for router in pages.ROUTERS
        for one in iter_route_contexts(router.routes)
        if (one.methods or set()) - form_tokens.SAFE
    }
)
"""Paths that are posted to, each parameter an x."""
GUIDED = [path for path in POSTED if path.startswith("/sessions/x/")]
"""Those of the guided session."""
