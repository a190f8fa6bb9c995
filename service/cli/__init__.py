"""The command `drumtrue`."""


def main() -> None:
    """Run the command line."""
    raise SystemExit("drumtrue: no command yet")
