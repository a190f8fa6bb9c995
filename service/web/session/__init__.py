"""The guided session: the next step, what each step shows, changes of masses."""
