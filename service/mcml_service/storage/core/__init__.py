"""The base of all repositories: tables, statements, checksums, dialects, a transaction. It imports none of them."""
