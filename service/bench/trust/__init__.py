"""Are the answers true? Rotors that share no code with the product, sessions with every kind of error."""
