"""The wire: pydantic models of every request and answer. Imports nothing of `service`."""
