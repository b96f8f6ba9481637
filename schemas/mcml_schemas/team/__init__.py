"""People: accounts, sessions, comments, presence, links, and the activity in the repository."""
