"""Pages by subject: each function reads a form, calls a use case, and renders a template or sends on."""
