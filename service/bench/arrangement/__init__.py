"""`drumtrue bench arrangement`: proofs, times and answers next to named methods."""
