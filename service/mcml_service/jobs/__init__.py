"""Long work: rows in `job`, taken by a runner in every server, executed by Dask."""
