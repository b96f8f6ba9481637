"""Motion capture in Python: repositories on this machine or on a server, and files without any."""
