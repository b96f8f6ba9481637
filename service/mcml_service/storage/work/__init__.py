"""What people make beside documents: jobs, results, mappings, saved things."""
