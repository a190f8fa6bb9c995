"""A client whose requests are answered by a function, each answer unread as one off a socket is."""

from __future__ import annotations

from collections.abc import Callable

import httpx2


def answering(answer: Callable[[httpx2.Request], httpx2.Response]) -> httpx2.Client:
    """A client that reaches nothing but `answer`."""

    def unread(request: httpx2.Request) -> httpx2.Response:
        made = answer(request)
        if not made.is_stream_consumed:
            return made
        return httpx2.Response(made.status_code, headers=made.headers, stream=httpx2.ByteStream(made.content))

    return httpx2.Client(transport=httpx2.MockTransport(unread))
