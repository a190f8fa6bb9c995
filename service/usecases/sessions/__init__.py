"""Sessions: opened, their runs and stops, the live view, reports, import of logs."""
