"""Names of joints and motions: `mcml names apply`, `names set`, `mapping save`, `alias`, `mcml project vocabulary`."""

from __future__ import annotations

from typing import Annotated

import typer

from mcml.client.choosing import choose_documents, id_of
from mcml.errors import NotFoundError
from mcml_schemas.documents import DocumentSummary
from mcml_schemas.names import Alias, AppliedNames, JointChoices, Rename, SavedAliases
from mcml_schemas.querying.saved import VocabularyToSave, VocabularyWord
from mcml_schemas.retarget import JointPair, SavedMapping
from mcml_service.cli.terminal.choosing import IdsArgument, MotionNameOption, ProjectOption, XPathOption, for_each
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    ServerOption,
    console,
    open_client,
    print_json,
    write_to_the_end,
)
from mcml_service.cli.terminal.present import present
from mcml_service.operations import OPERATIONS

MOST_COLOURS = 7
"""The last of the studio's colours of names."""

JointsOption = Annotated[
    list[str] | None, typer.Option("--joint", help="SOURCE=TARGET for each joint to move; may be repeated")
]


def apply(
    ids: IdsArgument = None,
    project: ProjectOption = None,
    motion_name: MotionNameOption = None,
    xpath: XPathOption = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Preview the renames without changing anything")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Apply the joint names that an import would give now; each changed document gets a revision.

    All documents, unless some are named or chosen. With --dry-run documents whose joints would change alike, as those
    of one rig do, are listed together.
    """
    write_to_the_end()
    client = open_client(database, server)
    options = {"project": project, "motion_name": motion_name, "xpath": xpath}
    if ids and any(option is not None for option in options.values()):
        raise typer.BadParameter("name documents, or choose them by --project, --motion-name, --xpath")
    documents = choose_documents(client, ids, **options)
    made: list[AppliedNames] = []

    def apply_one(item: DocumentSummary) -> None:
        made.append(client.call("apply_names", id=item.id, dry_run=dry_run, if_match="*"))
        for name in made[-1].items if not (as_json or dry_run) else ():
            console.print(f"{item.id}  {name.source}: {describe(name)}")

    try:
        for_each(documents, apply_one)
    finally:
        if as_json:
            print_json({"items": [item.model_dump() for item in made]})
        else:
            if dry_run:
                print_by_rig(made)
            done = sum(bool(item.items) for item in made)
            console.print(f"{done} of {len(documents)} documents {'would be' if dry_run else 'were'} changed")


def print_by_rig(made: list[AppliedNames]) -> None:
    """Print renamed joints, grouped by documents whose joints would change in the same way; the largest group first."""
    rigs: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for item in made:
        if item.items:
            key = tuple((name.source, describe(name)) for name in item.items)
            rigs.setdefault(key, []).append(item.document)
    for names, documents in sorted(rigs.items(), key=lambda rig: -len(rig[1])):
        console.print(f"{len(documents)} documents, such as {documents[0]}: {len(names)} names")
        for source, told in names:
            console.print(f"  {source}: {told}")


def describe(name: Rename) -> str:
    """The name that a joint had and the new one, or its role if that alone changes."""
    return f"{name.before} -> {name.after}" if name.before != name.after else f"role {name.role or 'none'}"


def set_names(
    document: Annotated[str, typer.Argument(metavar="ID", help="Document")],
    pairs: Annotated[
        list[str], typer.Argument(help="JOINT=NAME, such as Hüfte=Root; JOINT= for the name that its file has")
    ],
    remember: Annotated[
        bool, typer.Option("--remember", help="Use the names for later imports of the project too")
    ] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Give joints of a document names of MCML's, as a revision."""
    if not all("=" in pair for pair in pairs):
        raise typer.BadParameter("JOINT=NAME, such as Hüfte=Root")
    write_to_the_end()
    client = open_client(database, server)
    items = [{"joint": joint, "name": name or None} for joint, _, name in (pair.rpartition("=") for pair in pairs)]
    choices = JointChoices.model_validate({"items": items, "remember": remember})
    made = client.call("name_joints", id=id_of(client, document), choices=choices, if_match="*")
    present(OPERATIONS["name_joints"], made, as_json)


def alias(
    pairs: Annotated[list[str] | None, typer.Argument(help="NAME=JOINT, such as Hüfte=Root")] = None,
    remove: Annotated[list[str] | None, typer.Option("--remove", help="Take this one away; may be repeated")] = None,
    project: Annotated[str, typer.Option(help="Project whose files call joints so")] = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Set names of joints in a project, for future imports. `mcml names apply` renames joints of existing documents."""
    from mcml.language.joint_names import alias_key

    pairs_of_texts = [text.rpartition("=")[::2] for text in pairs or ()]
    if not all(joint and other for joint, other in pairs_of_texts) or not (pairs_of_texts or remove):
        raise typer.BadParameter("NAME=JOINT, such as Hüfte=Root, or --remove NAME")
    write_to_the_end()
    client = open_client(database, server)
    present_table = client.call("get_aliases", project=project)
    gone = {alias_key(name) for name in (*(joint for joint, _ in pairs_of_texts), *(remove or ()))}
    items = [item for item in present_table.items if alias_key(item.source) not in gone]
    items += [Alias(source=joint, name=other) for joint, other in pairs_of_texts]
    match = f'"{present_table.version}"'
    if not items:
        client.call("delete_aliases", project=project, if_match=match)
        return
    made = client.call("save_aliases", aliases=SavedAliases(items=items), project=project, if_match=match)
    present(OPERATIONS["save_aliases"], made, as_json)


def vocabulary(
    project: Annotated[str, typer.Argument(help="Name of the project")],
    words: Annotated[list[str] | None, typer.Argument(help="NAME or NAME=DESCRIPTION, to be added or changed")] = None,
    colour: Annotated[
        list[str] | None, typer.Option("--colour", metavar="NAME=0..7", help="Show it so in the studio")
    ] = None,
    remove: Annotated[list[str] | None, typer.Option("--remove", help="Take this one away; may be repeated")] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """List the vocabulary of a project, which the studio suggests first; with names, change it."""
    from mcml.language.motion_names import canonical

    client = open_client(database, server)
    kept = client.call("get_vocabulary", project=project)
    if not (words or colour or remove):
        present(OPERATIONS["get_vocabulary"], kept, as_json)
        return
    items = {word.name: word for word in kept.items}
    for text in words or ():
        name, equals, description = text.partition("=")
        before = items.get(canonical(name), VocabularyWord(name=canonical(name)))
        items[before.name] = before.model_copy(update={"description": description} if equals else {})
    for text in colour or ():
        name, _, number = text.rpartition("=")
        if name == "" or canonical(name) not in items or not (number.isdigit() and int(number) <= MOST_COLOURS):
            raise typer.BadParameter("NAME=0..7, of a name of the vocabulary", param_hint="--colour")
        items[canonical(name)] = items[canonical(name)].model_copy(update={"colour": int(number)})
    for name in remove or ():
        items.pop(canonical(name), None)
    match = f'"{kept.version}"' if kept.version else None
    if not items:
        client.call("delete_vocabulary", project=project, if_match=match)
        return
    asked = VocabularyToSave(items=list(items.values()))
    made = client.call("save_vocabulary", vocabulary=asked, project=project, if_match=match)
    present(OPERATIONS["save_vocabulary"], made, as_json)


def save(
    name: Annotated[str, typer.Argument(help="Mapping; one of that name is replaced")],
    joints: JointsOption = None,
    suggest: Annotated[
        tuple[str, str] | None,
        typer.Option(metavar="ID SKELETON", help="Start with the suggested mapping of these two"),
    ] = None,
    project: Annotated[str, typer.Option(help="Project that keeps the mapping")] = "default",
    database: DatabaseOption = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
) -> None:
    """Save a mapping of joints: your own pairs, in addition to those suggested for two documents."""
    write_to_the_end()
    client = open_client(database, server)
    pairs: dict[str, str] = {}
    if suggest is not None:
        joint, other = (id_of(client, text) for text in suggest)
        asked = {"skeleton": other, "preview": True}
        pairs = {match.target: match.source for match in client.call("retarget", id=joint, request=asked).matches}
    pairs |= {pair.target: pair.source for pair in joint_pairs(joints)}
    if not pairs:
        raise typer.BadParameter("give --joint SOURCE=TARGET, or --suggest ID SKELETON")
    try:
        version = client.call("get_mapping", name=name, project=project).version
    except NotFoundError:
        match = None
    else:
        match = f'"{version}"'
    mapping = SavedMapping(pairs=[JointPair(source=source, target=target) for target, source in pairs.items()])
    made = client.call("save_mapping", name=name, mapping=mapping, project=project, if_match=match)
    present(OPERATIONS["save_mapping"], made, as_json)


def joint_pairs(joints: list[str] | None) -> list[JointPair]:
    """SOURCE=TARGET texts."""
    pairs = [text.partition("=")[::2] for text in joints or ()]
    if not all(source and other for source, other in pairs):
        raise typer.BadParameter("SOURCE=TARGET, such as left_hand=left_wrist", param_hint="--joint")
    return [JointPair(source=source, target=other) for source, other in pairs]
