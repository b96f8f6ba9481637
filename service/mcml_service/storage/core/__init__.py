"""What all repositories stand on: tables, statements, checksums, dialects, a transaction. Knows none of them."""
