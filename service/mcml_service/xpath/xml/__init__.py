"""What columns have no answer to: documents as XML, evaluated by libxml2 or Saxon in processes with limits."""
