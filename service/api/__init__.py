"""JSON over HTTP: routers, problem documents, limits."""
