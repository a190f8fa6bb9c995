"""`python -m service` is `drumtrue`."""

from service.cli import main

main()
