"""Long work over many sessions or draws, spread over cores or over a cluster; the same answers wherever it runs."""
