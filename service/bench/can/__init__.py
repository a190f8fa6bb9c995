"""`drumtrue bench can`: from the bus to the database."""
