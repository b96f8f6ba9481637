"""What a user does, one verb a file, one transaction each. Called by the API, the command line and jobs."""
