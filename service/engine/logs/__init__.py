"""Session logs without storage: read, solved again, compared."""
