"""OPERATIONS: everything that a user can ask of the repository, readable from top to bottom.

A row says the name, the address below /api/v1, what the operation does to the store, what right it needs, its words,
the module beside this one with the function of that name, and the command with its positional arguments in capitals. A
row without a command has none, or one made by hand (`mcml_service.cli`). Nothing is imported until an operation is
used.
"""

from __future__ import annotations

from mcml.errors import NotFoundError
from mcml_service.operations.operation import Effect, Operation, Right

READS, STREAMS, WRITES, STARTS = Effect.READS, Effect.STREAMS, Effect.WRITES, Effect.STARTS
READ, EDIT, OWN, OPERATE = Right.READ, Right.EDIT, Right.OWN, Right.OPERATE

PREVIEW = "What would be stored, where `preview` was asked"

# fmt: off
_ROWS = [
    # documents
    Operation("list_documents", "GET /documents", READS, READ,
              "Documents, in any order.", "documents", "ls [TEXT]", heavy="xpath"),
    Operation("get_facets", "GET /facets", READS, READ,
              "What the list of documents can be narrowed by, with counts.", "facets", "facets [TEXT]", heavy="xpath"),
    Operation("get_document", "GET /documents/{id}", READS, READ,
              "Everything about a document but its frames.", "documents", "show ID"),
    Operation("upload_documents", "POST /documents", WRITES, EDIT,
              "Store files as documents.", "uploads", status=201, heavy=True),
    Operation("inspect_files", "POST /inspect", READS, READ,
              "What an upload of these files would find.", "uploads", heavy=True),
    Operation("change_document", "PATCH /documents/{id}", WRITES, EDIT,
              "Change name, project, description, properties, unit, up axis or frame time.", "documents"),
    Operation("delete_document", "DELETE /documents/{id}", WRITES, EDIT,
              "Hide a document.", "documents", status=204),
    Operation("restore_document", "POST /documents/{id}/restore", WRITES, EDIT,
              "Bring a deleted document back, or make an earlier revision current, as a new revision.", "documents",
              "restore ID [REVISION]"),
    Operation("undo_revision", "POST /documents/{id}/undo", WRITES, EDIT,
              "Take back what one revision did, as a new revision.", "documents", "undo ID [REVISION]"),
    Operation("list_revisions", "GET /documents/{id}/revisions", READS, READ,
              "The history of a document, newest first.", "documents", "history ID"),
    Operation("compare_revisions", "GET /documents/{id}/difference", READS, READ,
              "What differs between two revisions: elements, frames, labels, samples, angles between poses.",
              "documents", "diff ID BEFORE [AFTER]", terse=True, heavy=True),
    Operation("set_properties", "POST /properties", WRITES, EDIT,
              "Set properties of many documents from a CSV table.", "documents", "properties TABLE", heavy=True),

    # many documents at once
    Operation("delete_documents", "POST /selections/delete", WRITES, EDIT,
              "Hide all documents of a selection.", "selections", heavy=True),
    Operation("restore_documents", "POST /selections/restore", WRITES, EDIT,
              "Bring deleted documents back.", "selections", heavy=True),
    Operation("copy_documents", "POST /selections/copy", WRITES, EDIT,
              "Copy documents with their histories into a project.", "selections", status=201, heavy=True),
    Operation("change_documents", "POST /selections/change", WRITES, EDIT,
              "Change facts of all documents of a selection, and name frames of them.", "selections", heavy=True),

    # files of documents
    Operation("get_mcml", "GET /documents/{id}/mcml", STREAMS, READ,
              "The document as MCML, valid against `mcml.dtd`.", "exports"),
    Operation("find_text", "GET /documents/{id}/find", READS, READ,
              "The next place of a text in a document: its line, and the address of the element there.", "exports",
              "find ID TEXT"),
    Operation("export_document", "GET /documents/{id}/export", STREAMS, READ,
              "The document in a motion-capture format.", "exports", shared=True),
    Operation("export_documents", "POST /exports", STREAMS, READ,
              "The documents of a selection as one zip of files.", "exports", heavy=True),

    # what is drawn
    Operation("get_skeleton", "GET /documents/{id}/skeleton", READS, READ,
              "The skeleton of a document, with all that one needs to draw or move it.", "viewing", "skeleton ID",
              shared=True),
    Operation("get_thumbnail", "GET /documents/{id}/thumbnail", STREAMS, READ,
              "A small moving picture of a document's skeleton.", "viewing", shared=True),

    Operation("get_calibration", "GET /documents/{id}/calibration", READS, READ,
              "What questions about motion rest on: unit, up axis, floor, leg, and where each is from.", "viewing",
              "calibration ID"),
    Operation("change_calibration", "PATCH /documents/{id}/calibration", WRITES, EDIT,
              "Set the unit, up axis, floor, leg or reference pose of a document, as a revision.", "viewing",
              "calibrate ID"),

    # what one looks at beside the motion
    Operation("put_media", "PUT /documents/{id}/media", WRITES, EDIT,
              "Let a document carry video or audio for reference.", "media"),
    Operation("get_media", "GET /documents/{id}/media", STREAMS, READ,
              "The video or audio that a document carries for reference.", "media"),
    Operation("change_media", "PATCH /documents/{id}/media", WRITES, EDIT,
              "Say where in its video or audio the motion of a document begins.", "media"),
    Operation("delete_media", "DELETE /documents/{id}/media", WRITES, EDIT,
              "Take the video or audio of a document away.", "media", status=204),

    # what people say about it
    Operation("list_comments", "GET /documents/{id}/comments", READS, READ,
              "Comments on a document, its frames and joints.", "comments", "comment list ID"),
    Operation("add_comment", "POST /documents/{id}/comments", WRITES, READ,
              "Say something about a document, some of its frames, or a joint.", "comments", "comment add ID TEXT",
              status=201),
    Operation("change_comment", "PATCH /documents/{id}/comments/{comment}", WRITES, READ,
              "Change the text of one's own comment.", "comments", "comment change ID COMMENT TEXT"),
    Operation("resolve_comment", "PUT /documents/{id}/comments/{comment}/resolved", WRITES, READ,
              "Say that what a comment asks for is done.", "comments", "comment resolve ID COMMENT"),
    Operation("reopen_comment", "DELETE /documents/{id}/comments/{comment}/resolved", WRITES, READ,
              "Say that what a comment asks for is not done.", "comments", "comment reopen ID COMMENT"),
    Operation("delete_comment", "DELETE /documents/{id}/comments/{comment}", WRITES, READ,
              "Delete a comment.", "comments", "comment delete ID COMMENT", status=204),
    Operation("list_present", "GET /documents/{id}/presence", READS, READ,
              "Who looks at a document now, or edits it.", "presence"),
    Operation("keep_presence", "PUT /documents/{id}/presence", WRITES, READ,
              "Say that one looks at a document, or edits it, and hear who else does.", "presence"),
    Operation("end_presence", "DELETE /documents/{id}/presence", WRITES, READ,
              "Say that one looks at a document no more.", "presence", status=204),

    # frames
    Operation("get_frames", "GET /documents/{id}/frames", STREAMS, READ,
              "Frames of a document as numbers in the source's units.", "frames", shared=True),
    Operation("edit_frames", "POST /documents/{id}/frames", WRITES, EDIT,
              "Delete, keep, move, insert, reverse, mirror, smooth, adjust or resample ranges of frames.", "frames"),
    Operation("put_frames", "PUT /documents/{id}/frames", WRITES, EDIT,
              "Set channels of consecutive frames to numbers: JSON, or a NumPy file.", "frames"),

    # labels
    Operation("list_labels", "GET /documents/{id}/labels", READS, READ,
              "The motion names of a document and the frames that carry them, in order.", "labels", "labels list ID",
              shared=True),
    Operation("suggest_labels", "GET /documents/{id}/labels/suggested", READS, READ,
              "Anatomical movements found in the motion, as names for its frames.", "labels", heavy=True),
    Operation("add_labels", "POST /documents/{id}/labels", WRITES, EDIT,
              "Name ranges of frames.", "labels", status=201),
    Operation("change_label", "PATCH /documents/{id}/labels/{label}", WRITES, EDIT,
              "Rename a label, move its ends, or split it.", "labels", "labels change ID LABEL"),
    Operation("delete_label", "DELETE /documents/{id}/labels/{label}", WRITES, EDIT,
              "Take a motion name off its frames.", "labels", "labels delete ID LABEL", status=204),
    Operation("label_by_query", "POST /labels", WRITES, EDIT,
              "Name all frames that an XPath expression selects, or take the name off them.", "labels",
              "labels query NAME XPATH", heavy=True),
    Operation("export_labels", "GET /labels", READS, READ,
              "The labels of documents as a CSV table: document, label, first, last.", "labels",
              "labels export OUTPUT"),
    Operation("import_labels", "PUT /labels", WRITES, EDIT,
              "Add labels from a CSV table, as the export writes it.", "labels", "labels import TABLE", heavy=True),

    # elements
    Operation("list_children", "GET /documents/{id}/children", READS, READ,
              "The children of an element, a window at a time.", "elements", "element children ID [ADDRESS]"),
    Operation("get_element", "GET /documents/{id}/elements", READS, READ,
              "One element of a document as XML, or the value of one attribute as text.", "elements",
              "element get ID XPATH"),
    Operation("change_element", "PATCH /documents/{id}/elements", WRITES, EDIT,
              "Change attributes or text of elements.", "elements"),
    Operation("delete_element", "DELETE /documents/{id}/elements", WRITES, EDIT,
              "Delete elements or attributes, unless `mcml.dtd` or the frames need them.", "elements",
              "element delete ID XPATH"),
    Operation("replace_element", "PUT /documents/{id}/elements", WRITES, EDIT,
              "Put other elements in the place of one.", "elements", "element replace ID XPATH [FRAGMENT]"),
    Operation("insert_elements", "POST /documents/{id}/elements", WRITES, EDIT,
              "Put elements beside one, or into it.", "elements", "element insert ID XPATH [FRAGMENT]"),
    Operation("edit_elements", "POST /documents/{id}/elements/batch", WRITES, EDIT,
              "Change, delete, replace, insert and move elements as one revision: all, or none.", "elements",
              "element batch ID EDITS"),

    Operation("make_changes", "POST /documents/{id}/changes", WRITES, EDIT,
              "Make values of frames, elements, labels and facts of a document one revision: all, or none.", "changes",
              "change ID CHANGES"),

    # questions
    Operation("get_query", "GET /xpath", STREAMS, READ,
              "Ask one document or all an XPath question, such as `//frame[motion_name='left-arm-abduction']`.",
              "queries", terse=True, waits=True, heavy=True),
    Operation("post_query", "POST /xpath", STREAMS, READ,
              "Ask an XPath question that is long, or has variables.", "queries", terse=True, waits=True, heavy=True),
    Operation("complete_query", "GET /xpath/complete", READS, READ,
              "What may come next in an expression: elements, attributes, axes, functions, and names that occur.",
              "queries"),
    Operation("search_motion", "POST /search", READS, READ,
              "The poses or motions of the library that are most like one: of a document, or of joints at positions.",
              "searching", waits=True, heavy=True),
    Operation("search_file", "POST /search/file", READS, READ,
              "The poses or motions of the library that are most like one of a file that is not stored.",
              "searching", waits=True, heavy=True),

    # new documents of others
    Operation("compose", "POST /compose", WRITES, EDIT,
              "Make a document of frames of others, one segment after the other, with transitions between them.",
              "composing", status=201, terse=True, unmade=PREVIEW, heavy=True),
    Operation("split_document", "POST /documents/{id}/split", WRITES, EDIT,
              "Store parts of a document as documents: cut before frames, or around every range of a motion name.",
              "composing", "split ID [AT]", status=201, heavy=True),
    Operation("retarget", "POST /documents/{id}/retarget", WRITES, EDIT,
              "Bring a motion onto the skeleton of another document, as a new document.", "composing", status=201,
              terse=True, unmade=PREVIEW, heavy=True),
    Operation("retarget_many", "POST /retarget", WRITES, EDIT,
              "Bring the motions of all selected documents onto one skeleton, each as a new document.", "composing",
              heavy=True),

    # what projects keep
    Operation("list_collections", "GET /collections", READS, READ,
              "Collections of documents, by project and name.", "saved", "collections", terse=True),
    Operation("get_collection", "GET /collections/{name}", READS, READ,
              "One collection, and the documents that are in it.", "saved", terse=True),
    Operation("save_collection", "PUT /collections/{name}", WRITES, EDIT,
              "Save a collection of documents under a name.", "saved", status=201, terse=True,
              unmade="A collection that was there, changed"),
    Operation("delete_collection", "DELETE /collections/{name}", WRITES, EDIT,
              "Delete a collection.", "saved", status=204),
    Operation("list_saved_queries", "GET /queries", READS, READ,
              "Saved XPath questions, by project and name.", "saved", "queries"),
    Operation("get_saved_query", "GET /queries/{name}", READS, READ,
              "One saved question.", "saved"),
    Operation("save_query", "PUT /queries/{name}", WRITES, EDIT,
              "Save an XPath question under a name.", "saved", status=201, unmade="A question that was there, changed"),
    Operation("delete_query", "DELETE /queries/{name}", WRITES, EDIT,
              "Delete a saved question.", "saved", status=204),
    Operation("get_colours", "GET /colours", READS, READ,
              "The colours in which a project shows motion names.", "saved"),
    Operation("save_colours", "PUT /colours", WRITES, EDIT,
              "Save all colours of motion names of a project.", "saved", status=201,
              unmade="Colours that were there, changed"),
    Operation("get_vocabulary", "GET /vocabulary", READS, READ,
              "The motion names that a project agrees on.", "saved", terse=True),
    Operation("save_vocabulary", "PUT /vocabulary", WRITES, EDIT,
              "Save all motion names that a project agrees on.", "saved", status=201, terse=True,
              unmade="A vocabulary that was there, changed"),
    Operation("delete_vocabulary", "DELETE /vocabulary", WRITES, EDIT,
              "Take the vocabulary of a project away.", "saved", status=204),

    # names of joints
    Operation("list_mappings", "GET /mappings", READS, READ,
              "Saved mappings of joints, by project and name.", "names", "mapping list", terse=True),
    Operation("get_mapping", "GET /mappings/{name:path}", READS, READ,
              "One saved mapping.", "names", "mapping show NAME"),
    Operation("save_mapping", "PUT /mappings/{name:path}", WRITES, EDIT,
              "Save a mapping under a name.", "names", status=201, unmade="A mapping that was there, changed"),
    Operation("delete_mapping", "DELETE /mappings/{name:path}", WRITES, EDIT,
              "Delete a saved mapping.", "names", "mapping delete NAME", status=204),
    Operation("get_aliases", "GET /aliases", READS, READ,
              "What a project calls joints, beside the names that are known.", "names", "mapping aliases"),
    Operation("save_aliases", "PUT /aliases", WRITES, EDIT,
              "Save all aliases of a project.", "names"),
    Operation("delete_aliases", "DELETE /aliases", WRITES, EDIT,
              "Take all aliases of a project away.", "names", status=204),
    Operation("apply_names", "POST /documents/{id}/names", WRITES, EDIT,
              "Give joints of a document the names that an import would give them now, as a revision.", "names"),

    # analyses; each of the catalogue has operations of its own, made by `analyses.offered`
    Operation("list_analyses", "GET /analyses", READS, READ,
              "Every analysis with its parameters, the parts of its results, and what can be done with them.",
              "analyses"),
    Operation("get_analysis", "GET /analyses/{name}", READS, READ,
              "An analysis with its parameters as JSON schema.", "analyses"),
    Operation("read_music", "POST /music", READS, READ,
              "The beats of music, to be corrected and danced to.", "analyses", heavy=True),
    Operation("list_jobs", "GET /jobs", READS, READ,
              "Jobs, the newest first.", "jobs", "jobs list", terse=True),
    Operation("get_job", "GET /jobs/{id}", READS, READ,
              "How far a job is, and what came of it.", "jobs", "jobs show ID", terse=True),
    Operation("cancel_job", "DELETE /jobs/{id}", WRITES, EDIT,
              "End a job.", "jobs", "jobs cancel ID", status=202, terse=True),
    Operation("list_results", "GET /results", READS, READ,
              "Results, the newest first, without their parts.", "results", "analyse results", terse=True),
    Operation("get_result", "GET /results/{id}", READS, READ,
              "A result with its parts.", "results", terse=True),
    Operation("delete_result", "DELETE /results/{id}", WRITES, EDIT,
              "Delete a result and the results made from it.", "results", "analyse delete ID", status=204),
    Operation("get_result_picture", "GET /results/{id}/picture", STREAMS, READ,
              "A picture of a result: curves, graph, map or table as SVG or PNG.", "results"),
    Operation("get_result_part", "GET /results/{id}/{part}", READS, READ,
              "One part of a result.", "results", terse=True),
    Operation("get_result_array", "GET /results/{id}/{part}/{array}", READS, READ,
              "An array of a part, or some of its rows.", "results"),

    # what there is
    Operation("list_formats", "GET /formats", READS, READ,
              "Formats that are read and written, and those that are known but not read, with the reason.",
              "catalogues", "formats"),
    Operation("list_joint_names", "GET /joint-names", READS, READ,
              "The one table of joint names: MCML's own, and what other rigs call them.", "catalogues", "joints"),
    Operation("list_motion_names", "GET /motion-names", READS, READ,
              "Motion names in use with their frames, and the movements that each part of the body can perform.",
              "catalogues", "motions"),
    Operation("list_skeletons", "GET /skeletons", READS, READ,
              "Skeletons in use.", "catalogues", "skeletons"),
    Operation("get_rest_pose", "GET /documents/{id}/rest", READS, READ,
              "The skeleton of a document in its rest pose.", "catalogues", "rest ID", shared=True),
    Operation("list_projects", "GET /projects", READS, READ,
              "Projects by name.", "catalogues", "projects"),
    Operation("list_running_queries", "GET /running-queries", READS, OPERATE,
              "List running queries.", "running", "running list"),
    Operation("end_running_query", "DELETE /running-queries/{query}", WRITES, OPERATE,
              "Cancel a running query.", "running", "running end QUERY", status=204),
    Operation("list_activity", "GET /activity", READS, READ,
              "What was done, by whom and when, the newest first.", "activity", "activity"),

    Operation("get_project", "GET /project", READS, READ,
              "How much is in a project and may be, and whether it is archived.", "projects", "project show PROJECT"),
    Operation("change_project", "PATCH /project", WRITES, OWN,
              "Archive a project, or say how much it may hold.", "projects"),
    Operation("export_project", "GET /projects/export", STREAMS, OWN,
              "A whole project with every revision as one file.", "projects", heavy=True),
    Operation("import_project", "POST /projects", WRITES, OPERATE,
              "Make a project of such a file.", "projects", status=201, heavy=True),

    # who comes in
    Operation("get_account", "GET /account", READS, READ,
              "Who asks: name, role, and what one may do.", "accounts", "account me"),
    Operation("change_password", "PUT /account/password", WRITES, READ,
              "Change one's own password.", "accounts", status=204),
    Operation("list_accounts", "GET /accounts", READS, OPERATE,
              "The accounts of people.", "accounts", "account list"),
    Operation("add_owner", "POST /accounts", WRITES, OPERATE,
              "Make the first account, an owner's.", "accounts", status=201),
    Operation("change_account", "PATCH /accounts/{name}", WRITES, OPERATE,
              "Give somebody another role, or close their account.", "accounts"),
    Operation("list_invitations", "GET /invitations", READS, OWN,
              "Invitations that can be accepted still.", "accounts", "account invitations"),
    Operation("invite", "POST /invitations", WRITES, OWN,
              "Invite somebody to make an account of a role, in the repository or in one project.", "accounts",
              status=201),
    Operation("revoke_invitation", "DELETE /invitations/{number}", WRITES, OWN,
              "Take an invitation back.", "accounts", "account uninvite NUMBER", status=204),
    Operation("list_members", "GET /members", READS, READ,
              "Who belongs to a project, and as what.", "accounts", "project members PROJECT"),
    Operation("set_member", "PUT /members/{name}", WRITES, OWN,
              "Let somebody belong to a project, or give them another role there.", "accounts"),
    Operation("remove_member", "DELETE /members/{name}", WRITES, OWN,
              "Let somebody belong to a project no more.", "accounts", "project remove PROJECT NAME", status=204),
    Operation("list_shares", "GET /shares", READS, EDIT,
              "Links by which people without an account see some documents.", "sharing", "share list [PROJECT]"),
    Operation("add_share", "POST /shares", WRITES, EDIT,
              "Make a link by which somebody without an account sees some documents.", "sharing", status=201),
    Operation("revoke_share", "DELETE /shares/{number}", WRITES, EDIT,
              "Take a link to documents back.", "sharing", "share revoke NUMBER", status=204),
    Operation("list_webhooks", "GET /webhooks", READS, OWN,
              "Addresses that are told of events.", "webhooks", "webhook list [PROJECT]"),
    Operation("add_webhook", "POST /webhooks", WRITES, OWN,
              "Have the server tell an address of events.", "webhooks", status=201),
    Operation("remove_webhook", "DELETE /webhooks/{number}", WRITES, OWN,
              "Tell an address no more.", "webhooks", "webhook remove NUMBER", status=204),
    Operation("list_deliveries", "GET /webhooks/{number}/messages", READS, OWN,
              "Messages that were sent to an address, or wait.", "webhooks", "webhook log NUMBER"),
    Operation("redeliver", "POST /webhooks/{number}/messages/{message}", WRITES, OWN,
              "Send a message once more.", "webhooks", "webhook redeliver NUMBER MESSAGE", status=202),
    Operation("list_tokens", "GET /tokens", READS, READ,
              "Tokens of programs: names, scopes, dates.", "accounts"),
    Operation("add_token", "POST /tokens", WRITES, READ,
              "Make a token for a program.", "accounts", status=201),
    Operation("revoke_token", "DELETE /tokens/{name}", WRITES, READ,
              "Make a token useless at once.", "accounts", status=204),
]
# fmt: on

OPERATIONS: dict[str, Operation] = {operation.name: operation for operation in _ROWS}


def find_operation(name: str) -> Operation:
    """The operation of that name. NotFoundError where there is none."""
    if name in OPERATIONS:
        return OPERATIONS[name]
    found = {operation.name: operation for operation in all_operations()}
    if name not in found:
        raise NotFoundError(f"There is no operation {name!r}.", remedy=f"There are: {', '.join(found)}.")
    return found[name]


def all_operations() -> list[Operation]:
    """Those of OPERATIONS, and those that the catalogue of analyses makes."""
    from mcml_service.operations.analyses import offered

    return [*_ROWS, *offered()]
