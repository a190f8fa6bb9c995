"""HTTP protocol errors as problem JSON, before the application sees the request."""

from __future__ import annotations

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from service.api.problems import problem


class ProblemProtocol(HttpToolsProtocol):
    """The server's HTTP/1.1, that answers bytes which are no request of it with a problem."""

    def send_400_response(self, msg: str) -> None:
        """Answer and hang up: where the next request would begin cannot be known. msg: the server's words."""
        answer = problem(
            400, "bad_request", msg.rstrip(".").lower(), advice="send HTTP/1.1; content-length is a number of bytes"
        )
        head = [(b"connection", b"close"), *self.server_state.default_headers, *answer.raw_headers]
        lines = [b"HTTP/1.1 400 Bad Request", *(name + b": " + value for name, value in head), b"", bytes(answer.body)]
        self.transport.write(b"\r\n".join(lines))
        self.transport.close()
