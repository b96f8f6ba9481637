"""`python -m mcml_service.cli` is `mcml`."""

from mcml_service.cli import main

main()
