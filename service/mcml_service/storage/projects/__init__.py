"""Projects, their quotas, and the activity in them."""
