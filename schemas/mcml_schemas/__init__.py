"""The wire: pydantic models of every request and answer. Imports nothing of `mcml` and `mcml_service`."""
