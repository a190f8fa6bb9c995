"""What may be said of a drum: what its runs err by, whether plans did what was expected, what is known of it now."""
