"""Operations on people: accounts, comments, presence, links, webhooks, activity."""
