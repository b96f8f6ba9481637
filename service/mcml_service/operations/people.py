"""PEOPLE: operations on accounts, members, share links, webhooks and tokens, as rows of OPERATIONS."""

from __future__ import annotations

from mcml_service.operations.operation import Effect, Operation, Right

READS, WRITES = Effect.READS, Effect.WRITES
READ, EDIT, OWN, OPERATE = Right.READ, Right.EDIT, Right.OWN, Right.OPERATE

# fmt: off
PEOPLE = [
    Operation("get_account", "GET /account", READS, READ,
              "Get your account: name, role and permissions.", "team.accounts", "account me"),
    Operation("change_password", "PUT /account/password", WRITES, READ,
              "Change your own password.", "team.accounts", status=204),
    Operation("list_accounts", "GET /accounts", READS, OPERATE, "List accounts.", "team.accounts", "account list"),
    Operation("add_owner", "POST /accounts", WRITES, OPERATE,
              "Create the first account, an owner's.", "team.accounts", status=201),
    Operation("change_account", "PATCH /accounts/{name}", WRITES, OPERATE,
              "Change the role of an account, or close it.", "team.accounts"),
    Operation("list_invitations", "GET /invitations", READS, OWN,
              "List open invitations.", "team.accounts", "account invitations"),
    Operation("invite", "POST /invitations", WRITES, OWN,
              "Invite a person to create an account with a role, in the repository or in one project.", "team.accounts",
              status=201),
    Operation("revoke_invitation", "DELETE /invitations/{number}", WRITES, OWN,
              "Revoke an invitation.", "team.accounts", "account uninvite NUMBER", status=204),
    Operation("list_members", "GET /members", READS, READ,
              "List the members of a project with their roles.", "team.accounts", "project members PROJECT"),
    Operation("set_member", "PUT /members/{name}", WRITES, OWN,
              "Add a member to a project, or change their role.", "team.accounts"),
    Operation("remove_member", "DELETE /members/{name}", WRITES, OWN,
              "Remove a member from a project.", "team.accounts", "project remove PROJECT NAME", status=204),
    Operation("list_shares", "GET /shares", READS, EDIT, "List share links.", "team.sharing", "share list [PROJECT]"),
    Operation("add_share", "POST /shares", WRITES, EDIT,
              "Create a share link, with which people without an account can view documents.", "team.sharing",
              status=201),
    Operation("revoke_share", "DELETE /shares/{number}", WRITES, EDIT,
              "Revoke a share link.", "team.sharing", "share revoke NUMBER", status=204),
    Operation("list_webhooks", "GET /webhooks", READS, OWN,
              "List webhooks.", "team.webhooks", "webhook list [PROJECT]"),
    Operation("add_webhook", "POST /webhooks", WRITES, OWN,
              "Add a webhook, which receives events at a URL.", "team.webhooks", status=201),
    Operation("remove_webhook", "DELETE /webhooks/{number}", WRITES, OWN,
              "Delete a webhook.", "team.webhooks", "webhook remove NUMBER", status=204),
    Operation("list_deliveries", "GET /webhooks/{number}/messages", READS, OWN,
              "List sent and waiting messages of a webhook.", "team.webhooks", "webhook log NUMBER"),
    Operation("redeliver", "POST /webhooks/{number}/messages/{message}", WRITES, OWN,
              "Send a message of a webhook again.", "team.webhooks", "webhook redeliver NUMBER MESSAGE", status=202),
    Operation("list_tokens", "GET /tokens", READS, READ, "List your tokens: names, scopes, dates.", "team.accounts"),
    Operation("add_token", "POST /tokens", WRITES, READ, "Create a token for a program.", "team.accounts", status=201),
    Operation("revoke_token", "DELETE /tokens/{name}", WRITES, READ,
              "Revoke a token immediately.", "team.accounts", status=204),
]
# fmt: on
