"""Accounts of people, invitations to them, and the tokens of programs."""

from __future__ import annotations

from datetime import timedelta
from typing import Annotated, Any

from pydantic import Field

from mcml.errors import AccessError, ConflictError, NotFoundError, RequestError
from mcml_schemas.examples import PROJECT
from mcml_schemas.team.accounts import (
    AccountChange,
    AccountList,
    AccountView,
    Belonging,
    InvitationList,
    InvitationMade,
    InvitationRequest,
    InvitationView,
    Me,
    MemberChange,
    MemberList,
    MemberView,
    OwnerRequest,
    PasswordChange,
    TokenList,
    TokenMade,
    TokenRequest,
    TokenView,
)
from mcml_service.operations.arguments import MOST
from mcml_service.operations.call import Call
from mcml_service.operations.operation import RIGHTS
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.views import SCOPES
from mcml_service.storage.counting import count_attempt, forget_attempts
from mcml_service.storage.team.accounts import Account
from mcml_service.storage.team.entries import PROJECT_ROLES

AccountName = Annotated[str, Field(min_length=1, max_length=256, description="Name of the account", examples=["kim"])]
TokenName = Annotated[str, Field(min_length=1, max_length=1024, description="Name of the token", examples=["render"])]
OfProject = Annotated[str, Field(min_length=1, max_length=256, description="Project", examples=[PROJECT])]
Number = Annotated[int, Field(ge=1, le=MOST, description="Number of the invitation", examples=[3])]


def get_account(call: Call) -> Me:
    """Users without an account have a token, or are on the server's own machine."""
    role: Any = None
    with call.database.read() as tx:
        if call.account is not None:
            role = tx.accounts.get(call.account).role
        named = {tx.projects.name(key): _role_of(scope) for key, scope in call.view.projects}
    scope: Any = call.scope
    projects = [Belonging(project=name, role=own) for name, own in sorted(named.items())]
    return Me(name=call.author, role=role, scope=scope, rights=sorted(RIGHTS[call.scope]), projects=projects)


def list_accounts(call: Call) -> AccountList:
    """By name; closed ones too."""
    with call.database.read() as tx:
        return AccountList(items=[_view(person) for person in tx.accounts.all()])


def add_owner(call: Call, request: OwnerRequest) -> AccountView:
    """The administrator of the server creates it while the repository has no owner.

    From then on requests need an account or a token. Owners invite everybody else.
    """
    # Imported here: other operations hash nothing.
    from mcml_service.passwords import check_name, hash_password

    name = check_name(request.name)
    made = hash_password(request.password, name)
    with call.database.write(name) as tx:
        if tx.accounts.have_owner():
            raise ConflictError("The repository has an owner.", remedy="Ask an owner for an invitation.")
        return _view(tx.accounts.add(name, "owner", made))


def change_account(call: Call, name: AccountName, change: AccountChange) -> AccountView:
    """There is always an owner.

    A closed account has no access, and its sessions end; its name stays in use, because revisions have it. When it is
    reopened, its tokens work again.
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
    from mcml_service.passwords import hash_password, opens

    if call.account is None:
        raise RequestError("Only accounts have a password.", remedy="Log in with a name and a password.")
    with call.database.read() as tx:
        kept = tx.accounts.get(call.account).password
    counted = {"address": call.origin or "", "password": call.account}
    count_attempt(call.repository.database, counted)
    if not opens(change.current, kept):
        raise AccessError("This is not the password.", remedy="Give the one that you logged in with.")
    forget_attempts(call.repository.database, counted)
    made = hash_password(change.new, call.account)
    with call.database.write(call.author) as tx:
        tx.sessions.end_all(tx.accounts.change(call.account, password=made).key)


def invite(call: Call, request: InvitationRequest) -> InvitationMade:
    """The link is for one person: choose a name and a password there.

    It is shown only once. Owners of a project can invite to that project; new members see no other project.
    """
    if request.project is not None and request.role == "member":
        raise RequestError("In a project one is a reader, an editor or an owner.", remedy="Name one of these roles.")
    with call.database.write(call.author) as tx:
        project = None if request.project is None else tx.projects.get(request.project)
        code = tx.accounts.invite(request.role, call.author, timedelta(hours=request.hours), project)
    return InvitationMade(code=code, path=f"/login?invitation={code}", hours=request.hours)


def list_invitations(call: Call) -> InvitationList:
    """Lists invitations that can still be accepted. Owners of single projects see those for their projects."""
    with call.database.read() as tx:
        invitations: list[Any] = tx.accounts.invitations()
    return InvitationList(items=[InvitationView(**vars(invitation)) for invitation in invitations])


def revoke_invitation(call: Call, number: Number) -> None:
    """It can no longer be accepted."""
    with call.database.write(call.author) as tx:
        tx.accounts.take_back(number)


def list_tokens(call: Call) -> TokenList:
    """Lists your own tokens; users with the right `operate` see all. The tokens themselves are not stored."""
    with call.database.read() as tx:
        tokens: list[Any] = [token for token in tx.tokens.all() if _sees(call, token.account)]
    return TokenList(items=[TokenView(**vars(token)) for token in tokens])


def add_token(call: Call, request: TokenRequest) -> TokenMade:
    """The token belongs to the account that creates it, never has more rights, and ends with it.

    It is shown only once. The first token ends anonymous access, so create an owner's account first.
    """
    if SCOPES.index(request.scope) > SCOPES.index(call.scope):
        raise AccessError(
            f"A token of {call.author} cannot have the scope {request.scope}.", remedy=f"Ask for {call.scope} at most."
        )
    expires = None
    if request.days:
        expires = now(timedelta(days=request.days))
    with call.database.write(call.author) as tx:
        if not tx.tokens.exist():
            tx.accounts.require_owner()
        owner = None if call.account is None else tx.accounts.get(call.account)
        projects = [tx.projects.get(name) for name in dict.fromkeys(request.projects)]
        if call.view.limited and not projects:
            # A token of some projects cannot create tokens for others.
            projects = sorted(call.view.readable)
        secret = tx.tokens.add(request.name, expires, scope=request.scope, owner=owner, projects=projects)
        return TokenMade(name=request.name, token=secret)


def revoke_token(call: Call, name: TokenName) -> None:
    """Its sessions end with it."""
    with call.database.write(call.author) as tx:
        if not any(token.name == name and _sees(call, token.account) for token in tx.tokens.all()):
            raise NotFoundError(f"There is no token {name!r} of yours.", remedy="See `mcml token list`.")
        tx.tokens.remove(name)


def list_members(call: Call, project: OfProject) -> MemberList:
    """Those with a role in the whole repository too."""
    with call.database.read() as tx:
        members: list[Any] = tx.members.of_project(tx.projects.get(project))
    return MemberList(items=[MemberView(**vars(member)) for member in members])


def set_member(call: Call, name: AccountName, change: MemberChange, project: OfProject) -> MemberList:
    """A role in the whole repository that is more stays so. Answers with all members."""
    with call.database.write(call.author) as tx:
        tx.members.put(tx.projects.get(project), name, change.role)
    return list_members(call, project)


def remove_member(call: Call, name: AccountName, project: OfProject) -> None:
    """They see it no more, unless they have a role in the whole repository."""
    with call.database.write(call.author) as tx:
        tx.members.remove(tx.projects.get(project), name)


def _role_of(scope: str) -> Any:
    return next((role for role, own in PROJECT_ROLES.items() if own == scope), "owner")


def _sees(call: Call, account: str | None) -> bool:
    return call.scope == SCOPES[-1] or (account is not None and account == call.account)


def _view(person: Account) -> AccountView:
    role: Any = person.role
    return AccountView(name=person.name, role=role, created=person.created, closed=person.closed)
