"""People: accounts, tokens, links, comments, webhooks."""
