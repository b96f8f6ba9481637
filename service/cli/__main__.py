"""`python -m service.cli` is `mcml`."""

from service.cli import main

main()
