"""The actions of users, one verb in each file, one transaction each. Called by the API, the command line and jobs."""
