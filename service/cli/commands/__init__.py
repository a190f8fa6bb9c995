"""The commands of `drumtrue`, one module each."""
