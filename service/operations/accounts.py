"""Accounts of people, invitations to them, and the tokens of programs."""

from __future__ import annotations

from datetime import timedelta
from typing import Annotated, Any

from pydantic import Field

from schemas.accounts import (
    AccountChange,
    AccountList,
    AccountView,
    InvitationList,
    InvitationMade,
    InvitationRequest,
    InvitationView,
    Me,
    PasswordChange,
    TokenList,
    TokenMade,
    TokenRequest,
    TokenView,
)
from service.errors import AccessError, NotFoundError, RequestError
from service.operations.arguments import MOST
from service.operations.call import Call
from service.operations.operation import RIGHTS
from service.storage.accounts import SCOPES, Account
from service.storage.identifiers import now

AccountName = Annotated[str, Field(min_length=1, max_length=256, description="Name of the account", examples=["kim"])]
TokenName = Annotated[str, Field(min_length=1, max_length=1024, description="Name of the token", examples=["render"])]
Number = Annotated[int, Field(ge=1, le=MOST, description="Number of the invitation", examples=[3])]


def get_account(call: Call) -> Me:
    """Who has no account has a token, or is on the server's own machine."""
    role: Any = None
    if call.account is not None:
        with call.database.read() as tx:
            role = tx.accounts.get(call.account).role
    scope: Any = call.scope
    return Me(name=call.author, role=role, scope=scope, rights=sorted(RIGHTS[call.scope]))


def list_accounts(call: Call) -> AccountList:
    """By name; closed ones too."""
    with call.database.read() as tx:
        return AccountList(items=[_view(one) for one in tx.accounts.all()])


def change_account(call: Call, name: AccountName, change: AccountChange) -> AccountView:
    """There is always an owner. A closed account opens nothing, and its sessions end; its name stays taken, as
    revisions carry it. Its tokens open something again when it is opened again.
    """
    values: dict[str, str | None] = {} if change.role is None else {"role": change.role}
    if change.closed is not None:
        values["closed"] = now() if change.closed else None
    with call.database.write(call.author) as tx:
        person = tx.accounts.change(name, **values) if values else tx.accounts.get(name)
        if person.closed is not None:
            tx.sessions.end_all(person.key)
        return _view(person)


def change_password(call: Call, change: PasswordChange) -> None:
    """All sessions of the account end, this one too: log in again."""
    # Imported here: other operations hash nothing.
    from service.passwords import hashed, opens

    if call.account is None:
        raise RequestError("Only accounts have a password.", remedy="Log in with a name and a password.")
    with call.database.read() as tx:
        kept = tx.accounts.get(call.account).password
    if not opens(change.current, kept):
        raise AccessError("This is not the password.", remedy="Give the one that you logged in with.")
    made = hashed(change.new, call.account)
    with call.database.write(call.author) as tx:
        tx.sessions.end_all(tx.accounts.change(call.account, password=made).key)


def invite(call: Call, request: InvitationRequest) -> InvitationMade:
    """Its link is for one person, who chooses a name and a password there. It is shown this once."""
    with call.database.write(call.author) as tx:
        code = tx.accounts.invite(request.role, call.author, timedelta(hours=request.hours))
    return InvitationMade(code=code, path=f"/login?invitation={code}", hours=request.hours)


def list_invitations(call: Call) -> InvitationList:
    """Those that can be accepted still."""
    with call.database.read() as tx:
        found: list[Any] = tx.accounts.invitations()
    return InvitationList(items=[InvitationView(**vars(one)) for one in found])


def revoke_invitation(call: Call, number: Number) -> None:
    """Nobody can accept it from then on."""
    with call.database.write(call.author) as tx:
        tx.accounts.take_back(number)


def list_tokens(call: Call) -> TokenList:
    """One's own; of who keeps the server running all. The tokens themselves are kept nowhere."""
    with call.database.read() as tx:
        found: list[Any] = [one for one in tx.tokens.all() if _sees(call, one.account)]
    return TokenList(items=[TokenView(**vars(one)) for one in found])


def add_token(call: Call, request: TokenRequest) -> TokenMade:
    """It belongs to the account that makes it: it may do no more, and ends with it. It is shown this once."""
    if SCOPES.index(request.scope) > SCOPES.index(call.scope):
        raise AccessError(
            f"A token of {call.author} cannot have the scope {request.scope}.", remedy=f"Ask for {call.scope} at most."
        )
    expires = None
    if request.days:
        expires = now(timedelta(days=request.days))
    with call.database.write(call.author) as tx:
        owner = None if call.account is None else tx.accounts.get(call.account)
        return TokenMade(
            name=request.name, token=tx.tokens.add(request.name, expires, scope=request.scope, owner=owner)
        )


def revoke_token(call: Call, name: TokenName) -> None:
    """Its sessions end with it."""
    with call.database.write(call.author) as tx:
        if not any(one.name == name and _sees(call, one.account) for one in tx.tokens.all()):
            raise NotFoundError(f"There is no token {name!r} of yours.", remedy="See `mcml token list`.")
        tx.tokens.remove(name)


def _sees(call: Call, account: str | None) -> bool:
    return call.scope == SCOPES[-1] or (account is not None and account == call.account)


def _view(person: Account) -> AccountView:
    role: Any = person.role
    return AccountView(name=person.name, role=role, created=person.created, closed=person.closed)
