"""Objects other than documents: jobs, results, mappings, saved items."""
