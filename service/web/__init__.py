"""Pages for a tablet beside the drum: a second client of the use cases, rendered at the server.

| module | what it does |
|---|---|
| `pages` | puts routers, static files and error pages on the application |
| `routers/` | one module a subject; a function reads a form, calls a use case, renders a template or sends on |
| `rendering` | `Page`: the request with the reader's language and units, and how a template is rendered |
| `problems` | every error as a page as text |
| `forms` | what was typed, read into numbers; a fault stands beside its field and what was typed is kept |
| `display`, `units`, `numbers` | stored numbers as the reader wants them, and back |
| `language`, `preferences`, `environment`, `assets` | catalogues, the cookie, Jinja, our own files |

Inside the use cases every number keeps its stored unit; units of the reader exist in this room only.
"""
