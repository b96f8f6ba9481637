"""Stores of both kinds of database keep the contract that `mcml_service.testing` has for others."""

from mcml_service.testing import StoreContract


class TestStore(StoreContract):
    """On SQLite and on PostgreSQL (`tests/conftest.py: database`)."""
