"""People: accounts, sessions, comments, presence, links, and what happens in the repository."""
