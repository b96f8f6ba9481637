"""Types of `repo.operations`, made by `make docs` from the declarations of operations."""

from typing import Any, Literal

from mcml.answers import Content
from mcml.client.client import Client, FileProgress
from mcml.formats.format import SourceFile
from mcml_schemas.bodies import Calibration, CalibrationChange
from mcml_schemas.catalogues import (
    FormatList,
    JointNameList,
    MotionNameList,
    ProjectChange,
    ProjectImported,
    ProjectList,
    ProjectView,
    RestPose,
    SkeletonPage,
)
from mcml_schemas.changes import ChangeSet, ChangesMade
from mcml_schemas.compose import Composed, ComposeRequest, SplitParts, SplitRequest
from mcml_schemas.documents import (
    ChangedDocuments,
    DocumentChange,
    DocumentDetail,
    DocumentPage,
    FramePage,
    InspectResult,
    LabelPage,
    LabelRequest,
    RevisionPage,
    UploadResult,
)
from mcml_schemas.elements import ChildPage, ElementChange, ElementEdited, ElementEdits, TextFound
from mcml_schemas.exports import ExportRequest
from mcml_schemas.frames import FrameEdits, FramesEdited
from mcml_schemas.jobs import (
    AnalysisInfo,
    AnalysisList,
    ArrayValues,
    Job,
    JobPage,
    MusicBeats,
    PartSummary,
    Result,
    ResultPage,
    ResultUsed,
    Selection,
)
from mcml_schemas.labels import LabelChange, LabelQuery, SuggestedLabels
from mcml_schemas.media import MediaChange, MediaInfo
from mcml_schemas.names import AliasTable, AppliedNames, SavedAliases
from mcml_schemas.querying.facets import FacetList
from mcml_schemas.querying.queries import Completions, QueryAnswer, QueryRequest
from mcml_schemas.querying.running import RunningQueries
from mcml_schemas.querying.saved import (
    Collection,
    CollectionPage,
    CollectionToSave,
    Colours,
    ColoursToSave,
    QueryToSave,
    SavedQuery,
    SavedQueryPage,
    Vocabulary,
    VocabularyToSave,
)
from mcml_schemas.querying.search import SearchAnswer, SearchRequest
from mcml_schemas.retarget import Mapping, MappingPage, Retargeted, RetargetMany, RetargetRequest, SavedMapping
from mcml_schemas.revisions import Difference
from mcml_schemas.selections import CopiedDocuments, ManyChanges, ManyCopies, ManyDocuments
from mcml_schemas.skeletons import SkeletonView
from mcml_schemas.team.accounts import (
    AccountChange,
    AccountList,
    AccountView,
    InvitationList,
    InvitationMade,
    InvitationRequest,
    Me,
    MemberChange,
    MemberList,
    OwnerRequest,
    PasswordChange,
    TokenList,
    TokenMade,
    TokenRequest,
)
from mcml_schemas.team.activity import ActivityPage
from mcml_schemas.team.comments import CommentChange, CommentPage, CommentRequest, CommentView
from mcml_schemas.team.presence import PresenceRequest, PresentList
from mcml_schemas.team.shares import ShareList, ShareMade, ShareRequest
from mcml_schemas.team.webhooks import DeliveryPage, DeliveryView, WebhookList, WebhookMade, WebhookRequest

class Operations:
    def __init__(self, client: Client) -> None: ...
    def list_documents(
        self,
        *,
        project: str | None = ...,
        q: str | None = ...,
        name: str | None = ...,
        id: str | None = ...,
        motion_name: str | None = ...,
        format: str | None = ...,
        skeleton: int | None = ...,
        property: list[str] | None = ...,
        length: str | None = ...,
        rate: str | None = ...,
        xpath: str | None = ...,
        collection: str | None = ...,
        deleted: bool | None = ...,
        limit: int | None = ...,
        cursor: str | None = ...,
        sort: Literal[
            "name",
            "-name",
            "newest",
            "created",
            "-created",
            "modified",
            "-modified",
            "duration",
            "-duration",
            "frames",
            "-frames",
            "rate",
            "-rate",
            "format",
            "-format",
            "project",
            "-project",
            "skeleton",
            "-skeleton",
            "revision",
            "-revision",
        ]
        | None = ...,
        offset: int | None = ...,
        with_: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentPage:
        """Documents, in any order."""
    def get_facets(
        self,
        *,
        project: str | None = ...,
        q: str | None = ...,
        name: str | None = ...,
        id: str | None = ...,
        motion_name: str | None = ...,
        format: str | None = ...,
        skeleton: int | None = ...,
        property: list[str] | None = ...,
        length: str | None = ...,
        rate: str | None = ...,
        xpath: str | None = ...,
        collection: str | None = ...,
        deleted: bool | None = ...,
        limit: int | None = ...,
        bins: int | None = ...,
        progress: FileProgress | None = None,
    ) -> FacetList:
        """What the list of documents can be narrowed by, with counts."""
    def get_document(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Everything about a document but its frames."""
    def upload_documents(
        self,
        *,
        file: list[SourceFile],
        project: str | None = ...,
        name: str | None = ...,
        description: str | None = ...,
        label: list[str] | None = ...,
        property: list[str] | None = ...,
        encoding: str | None = ...,
        translation: Literal["auto", "absolute", "relative"] | None = ...,
        unit: str | None = ...,
        up: str | None = ...,
        frame_time: str | float | None = ...,
        skeleton: str | None = ...,
        on_duplicate: Literal["new", "skip"] | None = ...,
        repair: list[str] | None = ...,
        strict_names: bool | None = ...,
        movements: float | None = ...,
        progress: FileProgress | None = None,
    ) -> UploadResult:
        """Store files as documents."""
    def inspect_files(
        self,
        *,
        file: list[SourceFile],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        encoding: str | None = ...,
        repair: list[str] | None = ...,
        progress: FileProgress | None = None,
    ) -> InspectResult:
        """What an upload of these files would find."""
    def change_document(
        self,
        *,
        id: str,
        change: DocumentChange | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Change name, project, description, properties, unit, up axis or frame time."""
    def delete_document(
        self,
        *,
        id: str,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Hide a document."""
    def restore_document(
        self,
        *,
        id: str,
        revision: int | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Bring a deleted document back, or make an earlier revision current, as a new revision."""
    def undo_revision(
        self,
        *,
        id: str,
        revision: int | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Take back what one revision did, as a new revision."""
    def list_revisions(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        with_: Literal["frames"] | None = ...,
        progress: FileProgress | None = None,
    ) -> RevisionPage:
        """The history of a document, newest first."""
    def compare_revisions(
        self,
        *,
        id: str,
        before: int,
        after: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Difference:
        """What differs between two revisions: elements, frames, labels, samples, angles between poses."""
    def set_properties(
        self,
        *,
        content: bytes,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Set properties of many documents from a CSV table."""
    def delete_documents(
        self,
        *,
        selection: Selection | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Hide all documents of a selection."""
    def restore_documents(
        self,
        *,
        request: ManyDocuments | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Bring deleted documents back."""
    def copy_documents(
        self,
        *,
        request: ManyCopies | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> CopiedDocuments:
        """Copy documents with their histories into a project."""
    def change_documents(
        self,
        *,
        request: ManyChanges | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Change facts of all documents of a selection, and name frames of them."""
    def get_mcml(
        self,
        *,
        id: str,
        revision: int | None = ...,
        pretty: bool | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        part: Literal["head", "frames"] | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """The document as MCML, valid against `mcml.dtd`."""
    def find_text(
        self,
        *,
        id: str,
        text: str,
        from_: int | None = ...,
        revision: int | None = ...,
        pretty: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> TextFound:
        """The next place of a text in a document: its line, and the address of the element there."""
    def export_document(
        self,
        *,
        id: str,
        format: str,
        revision: int | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        names: str | None = ...,
        unit: str | None = ...,
        up: str | None = ...,
        original: bool | None = ...,
        frame_time: str | float | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """The document in a motion-capture format."""
    def export_documents(
        self,
        *,
        request: ExportRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Content:
        """The documents of a selection as one zip of files."""
    def get_skeleton(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> SkeletonView:
        """The skeleton of a document, with all that one needs to draw or move it."""
    def get_thumbnail(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """A small moving picture of a document's skeleton."""
    def get_calibration(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Calibration:
        """What questions about motion rest on: unit, up axis, floor, leg, and where each is from."""
    def change_calibration(
        self,
        *,
        id: str,
        change: CalibrationChange | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Calibration:
        """Set the unit, up axis, floor, leg or reference pose of a document, as a revision."""
    def put_media(
        self,
        *,
        id: str,
        file: SourceFile,
        offset: float | None = ...,
        progress: FileProgress | None = None,
    ) -> MediaInfo:
        """Let a document carry video or audio for reference."""
    def get_media(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Content:
        """The video or audio that a document carries for reference."""
    def change_media(
        self,
        *,
        id: str,
        change: MediaChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> MediaInfo:
        """Say where in its video or audio the motion of a document begins."""
    def delete_media(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Take the video or audio of a document away."""
    def list_comments(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        progress: FileProgress | None = None,
    ) -> CommentPage:
        """Comments on a document, its frames and joints."""
    def add_comment(
        self,
        *,
        id: str,
        comment: CommentRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Say something about a document, some of its frames, or a joint."""
    def change_comment(
        self,
        *,
        id: str,
        comment: int,
        change: CommentChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Change the text of one's own comment."""
    def resolve_comment(
        self,
        *,
        id: str,
        comment: int,
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Say that what a comment asks for is done."""
    def reopen_comment(
        self,
        *,
        id: str,
        comment: int,
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Say that what a comment asks for is not done."""
    def delete_comment(
        self,
        *,
        id: str,
        comment: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a comment."""
    def list_present(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> PresentList:
        """Who looks at a document now, or edits it."""
    def keep_presence(
        self,
        *,
        id: str,
        presence: PresenceRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> PresentList:
        """Say that one looks at a document, or edits it, and hear who else does."""
    def end_presence(
        self,
        *,
        id: str,
        tab: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Say that one looks at a document no more."""
    def get_frames(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        revision: int | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        bone: list[str] | None = ...,
        quantity: list[str] | None = ...,
        space: Literal["channels", "positions", "rotations"] | None = ...,
        dtype: Literal["f8", "f4"] | None = ...,
        format: Literal["json", "npy", "npz", "block", "arrow", "parquet", "csv"] | None = ...,
        origin: Literal["keep", "subtract"] | None = ...,
        missing: Literal["hold", "nan"] | None = ...,
        tips: bool | None = ...,
        reduce: Literal["minmax"] | None = ...,
        pixels: int | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> FramePage | Content:
        """Frames of a document as numbers in the source's units."""
    def edit_frames(
        self,
        *,
        id: str,
        edits: FrameEdits | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> FramesEdited:
        """Delete, keep, move, insert, reverse, mirror, smooth, adjust or resample ranges of frames."""
    def put_frames(
        self,
        *,
        id: str,
        content: bytes,
        first: int | None = ...,
        last: int | None = ...,
        column: list[str] | None = ...,
        bone: list[str] | None = ...,
        channel: list[str] | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> FramesEdited:
        """Set channels of consecutive frames to numbers: JSON, or a NumPy file."""
    def list_labels(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        revision: int | None = ...,
        name: str | None = ...,
        progress: FileProgress | None = None,
    ) -> LabelPage:
        """The motion names of a document and the frames that carry them, in order."""
    def suggest_labels(
        self,
        *,
        id: str,
        confidence: float | None = ...,
        facing: Literal["X", "-X", "Y", "-Y", "Z", "-Z"] | None = ...,
        progress: FileProgress | None = None,
    ) -> SuggestedLabels:
        """Anatomical movements found in the motion, as names for its frames."""
    def add_labels(
        self,
        *,
        id: str,
        labels: list[LabelRequest] | list[dict[str, Any]],
        strict: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> LabelPage:
        """Name ranges of frames."""
    def change_label(
        self,
        *,
        id: str,
        label: int,
        change: LabelChange | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> LabelPage:
        """Rename a label, move its ends, or split it."""
    def delete_label(
        self,
        *,
        id: str,
        label: int,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Take a motion name off its frames."""
    def label_by_query(
        self,
        *,
        request: LabelQuery | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Name all frames that an XPath expression selects, or take the name off them."""
    def export_labels(
        self,
        *,
        project: str | None = ...,
        document: list[str] | None = ...,
        format: Literal["csv", "arrow", "parquet"] | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """The labels of documents as a CSV table: document, label, first, last."""
    def import_labels(
        self,
        *,
        content: bytes,
        project: str | None = ...,
        strict: bool | None = ...,
        replace: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Add labels from a CSV table, as the export writes it."""
    def list_children(
        self,
        *,
        id: str,
        address: str | None = ...,
        first: int | None = ...,
        limit: int | None = ...,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> ChildPage:
        """The children of an element, a window at a time."""
    def get_element(
        self,
        *,
        id: str,
        xpath: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """One element of a document as XML, or the value of one attribute as text."""
    def change_element(
        self,
        *,
        id: str,
        xpath: str,
        change: ElementChange | dict[str, Any],
        merge: bool | None = ...,
        gaps: Literal["allow", "refuse"] | None = ...,
        if_match: str | None = ...,
        many: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ElementEdited:
        """Change attributes or text of elements."""
    def delete_element(
        self,
        *,
        id: str,
        xpath: str,
        merge: bool | None = ...,
        gaps: Literal["allow", "refuse"] | None = ...,
        if_match: str | None = ...,
        many: bool | None = ...,
        renumber: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ElementEdited:
        """Delete elements or attributes, unless `mcml.dtd` or the frames need them."""
    def replace_element(
        self,
        *,
        id: str,
        xpath: str,
        fragment: bytes,
        merge: bool | None = ...,
        gaps: Literal["allow", "refuse"] | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ElementEdited:
        """Put other elements in the place of one."""
    def insert_elements(
        self,
        *,
        id: str,
        xpath: str,
        fragment: bytes,
        merge: bool | None = ...,
        gaps: Literal["allow", "refuse"] | None = ...,
        if_match: str | None = ...,
        where: Literal["before", "after", "into"] | None = ...,
        renumber: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ElementEdited:
        """Put elements beside one, or into it."""
    def edit_elements(
        self,
        *,
        id: str,
        request: ElementEdits | dict[str, Any],
        merge: bool | None = ...,
        gaps: Literal["allow", "refuse"] | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ElementEdited:
        """Change, delete, replace, insert and move elements as one revision: all, or none."""
    def make_changes(
        self,
        *,
        id: str,
        changes: ChangeSet | dict[str, Any],
        merge: bool | None = ...,
        dry_run: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ChangesMade:
        """Make values of frames, elements, labels and facts of a document one revision: all, or none."""
    def get_query(
        self,
        *,
        q: str,
        document: list[str] | None = ...,
        project: str | None = ...,
        revision: int | None = ...,
        as_: Literal["json", "xml", "ndjson", "csv", "runs", "arrow", "parquet"] | None = ...,
        otherwise: Literal["json"] | None = ...,
        limit: int | None = ...,
        cursor: str | None = ...,
        per: Literal["document"] | None = ...,
        guesses: Literal["yes", "no"] | None = ...,
        strict: bool | None = ...,
        explain: bool | None = ...,
        raw: bool | None = ...,
        with_: str | None = ...,
        progress: FileProgress | None = None,
    ) -> QueryAnswer | Content:
        """Ask one document or all an XPath question, such as `//frame[motion_name='left-arm-abduction']`."""
    def post_query(
        self,
        *,
        request: QueryRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> QueryAnswer | Content:
        """Ask an XPath question that is long, or has variables."""
    def complete_query(
        self,
        *,
        q: str,
        at: int | None = ...,
        document: list[str] | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Completions:
        """What may come next in an expression: elements, attributes, axes, functions, and names that occur."""
    def search_motion(
        self,
        *,
        request: SearchRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> SearchAnswer:
        """The poses or motions of the library that are most like one: of a document, or of joints at positions."""
    def search_file(
        self,
        *,
        file: list[SourceFile],
        first: int | None = ...,
        last: int | None = ...,
        within: list[str] | None = ...,
        project: str | None = ...,
        limit: int | None = ...,
        apart: float | None = ...,
        progress: FileProgress | None = None,
    ) -> SearchAnswer:
        """The poses or motions of the library that are most like one of a file that is not stored."""
    def compose(
        self,
        *,
        request: ComposeRequest | dict[str, Any],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Composed:
        """Make a document of frames of others, one segment after the other, with transitions between them."""
    def split_document(
        self,
        *,
        id: str,
        request: SplitRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> SplitParts:
        """Store parts of a document as documents: cut before frames, or around every range of a motion name."""
    def retarget(
        self,
        *,
        id: str,
        request: RetargetRequest | dict[str, Any],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Retargeted:
        """Bring a motion onto the skeleton of another document, as a new document."""
    def retarget_many(
        self,
        *,
        request: RetargetMany | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Content:
        """Bring the motions of all selected documents onto one skeleton, each as a new document."""
    def list_collections(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> CollectionPage:
        """Collections of documents, by project and name."""
    def get_collection(
        self,
        *,
        name: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Collection:
        """One collection, and the documents that are in it."""
    def save_collection(
        self,
        *,
        name: str,
        collection: CollectionToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Collection:
        """Save a collection of documents under a name."""
    def delete_collection(
        self,
        *,
        name: str,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a collection."""
    def list_saved_queries(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SavedQueryPage:
        """Saved XPath questions, by project and name."""
    def get_saved_query(
        self,
        *,
        name: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SavedQuery:
        """One saved question."""
    def save_query(
        self,
        *,
        name: str,
        query: QueryToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SavedQuery:
        """Save an XPath question under a name."""
    def delete_query(
        self,
        *,
        name: str,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a saved question."""
    def get_colours(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Colours:
        """The colours in which a project shows motion names."""
    def save_colours(
        self,
        *,
        colours: ColoursToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Colours:
        """Save all colours of motion names of a project."""
    def get_vocabulary(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Vocabulary:
        """The motion names that a project agrees on."""
    def save_vocabulary(
        self,
        *,
        vocabulary: VocabularyToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Vocabulary:
        """Save all motion names that a project agrees on."""
    def delete_vocabulary(
        self,
        *,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Take the vocabulary of a project away."""
    def list_mappings(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> MappingPage:
        """Saved mappings of joints, by project and name."""
    def get_mapping(
        self,
        *,
        name: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Mapping:
        """One saved mapping."""
    def save_mapping(
        self,
        *,
        name: str,
        mapping: SavedMapping | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Mapping:
        """Save a mapping under a name."""
    def delete_mapping(
        self,
        *,
        name: str,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a saved mapping."""
    def get_aliases(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AliasTable:
        """What a project calls joints, beside the names that are known."""
    def save_aliases(
        self,
        *,
        aliases: SavedAliases | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AliasTable:
        """Save all aliases of a project."""
    def delete_aliases(
        self,
        *,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Take all aliases of a project away."""
    def apply_names(
        self,
        *,
        id: str,
        dry_run: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AppliedNames:
        """Give joints of a document the names that an import would give them now, as a revision."""
    def list_analyses(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> AnalysisList:
        """Every analysis with its parameters, the parts of its results, and what can be done with them."""
    def get_analysis(
        self,
        *,
        name: str,
        progress: FileProgress | None = None,
    ) -> AnalysisInfo:
        """An analysis with its parameters as JSON schema."""
    def read_music(
        self,
        *,
        file: SourceFile,
        bpm: float | None = ...,
        beats_per_bar: int | None = ...,
        progress: FileProgress | None = None,
    ) -> MusicBeats:
        """The beats of music, to be corrected and danced to."""
    def list_jobs(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        state: Literal["waiting", "running", "done", "failed", "cancelled"] | None = ...,
        progress: FileProgress | None = None,
    ) -> JobPage:
        """Jobs, the newest first."""
    def get_job(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Job:
        """How far a job is, and what came of it."""
    def cancel_job(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Job:
        """End a job."""
    def list_results(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        analysis: str | None = ...,
        parent: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultPage:
        """Results, the newest first, without their parts."""
    def get_result(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Result:
        """A result with its parts."""
    def delete_result(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a result and the results made from it."""
    def get_result_picture(
        self,
        *,
        id: str,
        name: str | None = ...,
        format: Literal["svg", "png"] | None = ...,
        dpi: int | None = ...,
        width: float | None = ...,
        height: float | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """A picture of a result: curves, graph, map or table as SVG or PNG."""
    def get_result_part(
        self,
        *,
        id: str,
        part: str,
        progress: FileProgress | None = None,
    ) -> PartSummary:
        """One part of a result."""
    def get_result_array(
        self,
        *,
        id: str,
        part: str,
        array: str,
        first: int | None = ...,
        rows: int | None = ...,
        row: list[int] | None = ...,
        dtype: Literal["f4"] | None = ...,
        format: Literal["json", "npy"] | None = ...,
        progress: FileProgress | None = None,
    ) -> ArrayValues | Content:
        """An array of a part, or some of its rows."""
    def list_formats(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> FormatList:
        """Formats that are read and written, and those that are known but not read, with the reason."""
    def list_joint_names(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> JointNameList:
        """The one table of joint names: MCML's own, and what other rigs call them."""
    def list_motion_names(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> MotionNameList:
        """Motion names in use with their frames, and the movements that each part of the body can perform."""
    def list_skeletons(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SkeletonPage:
        """Skeletons in use."""
    def get_rest_pose(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> RestPose:
        """The skeleton of a document in its rest pose."""
    def list_projects(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> ProjectList:
        """Projects by name."""
    def list_running_queries(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> RunningQueries:
        """List running queries."""
    def end_running_query(
        self,
        *,
        query: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Cancel a running query."""
    def list_activity(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        document: str | None = ...,
        author: str | None = ...,
        kind: Literal["document", "comment", "project", "job", "member", "share", "webhook", "account", "token"]
        | None = ...,
        since: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ActivityPage:
        """What was done, by whom and when, the newest first."""
    def get_project(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> ProjectView:
        """How much is in a project and may be, and whether it is archived."""
    def change_project(
        self,
        *,
        change: ProjectChange | dict[str, Any],
        project: str,
        progress: FileProgress | None = None,
    ) -> ProjectView:
        """Archive a project, or say how much it may hold."""
    def export_project(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> Content:
        """A whole project with every revision as one file."""
    def import_project(
        self,
        *,
        file: SourceFile,
        name: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ProjectImported:
        """Make a project of such a file."""
    def get_account(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> Me:
        """Who asks: name, role, and what one may do."""
    def change_password(
        self,
        *,
        change: PasswordChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> None:
        """Change one's own password."""
    def list_accounts(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> AccountList:
        """The accounts of people."""
    def add_owner(
        self,
        *,
        request: OwnerRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> AccountView:
        """Make the first account, an owner's."""
    def change_account(
        self,
        *,
        name: str,
        change: AccountChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> AccountView:
        """Give somebody another role, or close their account."""
    def list_invitations(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> InvitationList:
        """Invitations that can be accepted still."""
    def invite(
        self,
        *,
        request: InvitationRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> InvitationMade:
        """Invite somebody to make an account of a role, in the repository or in one project."""
    def revoke_invitation(
        self,
        *,
        number: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Take an invitation back."""
    def list_members(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> MemberList:
        """Who belongs to a project, and as what."""
    def set_member(
        self,
        *,
        name: str,
        change: MemberChange | dict[str, Any],
        project: str,
        progress: FileProgress | None = None,
    ) -> MemberList:
        """Let somebody belong to a project, or give them another role there."""
    def remove_member(
        self,
        *,
        name: str,
        project: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Let somebody belong to a project no more."""
    def list_shares(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ShareList:
        """Links by which people without an account see some documents."""
    def add_share(
        self,
        *,
        request: ShareRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ShareMade:
        """Make a link by which somebody without an account sees some documents."""
    def revoke_share(
        self,
        *,
        number: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Take a link to documents back."""
    def list_webhooks(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> WebhookList:
        """Addresses that are told of events."""
    def add_webhook(
        self,
        *,
        request: WebhookRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> WebhookMade:
        """Have the server tell an address of events."""
    def remove_webhook(
        self,
        *,
        number: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Tell an address no more."""
    def list_deliveries(
        self,
        *,
        number: int,
        limit: int | None = ...,
        cursor: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DeliveryPage:
        """Messages that were sent to an address, or wait."""
    def redeliver(
        self,
        *,
        number: int,
        message: int,
        progress: FileProgress | None = None,
    ) -> DeliveryView:
        """Send a message once more."""
    def list_tokens(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> TokenList:
        """Tokens of programs: names, scopes, dates."""
    def add_token(
        self,
        *,
        request: TokenRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> TokenMade:
        """Make a token for a program."""
    def revoke_token(
        self,
        *,
        name: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Make a token useless at once."""
    def start_reach(
        self,
        *,
        request: dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Job:
        """A model that makes a reach for any age, height and hip point, or any other numbers that label clips."""
    def start_beats(
        self,
        *,
        request: dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Job:
        """Motion beats of dance clips, where the body rests for a moment, their period, and bars of four."""
    def start_motion_graph(
        self,
        *,
        request: dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Job:
        """Which bar of some dance clips may follow which: distances of poses and movement, and what is left when bars
        that lead nowhere are taken away."""
    def start_dance(
        self,
        *,
        request: dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Job:
        """A new dance of any length to a tempo or to music, made of bars of dance clips, beat on beat."""
    def start_expression(
        self,
        *,
        request: dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Job:
        """A map of all frames of facial takes with levels of detail, to find ways from face to face on."""
    def use_synthesize(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Make a motion for attributes"""
    def use_phases(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """The phases of a clip and the speed behind them"""
    def use_edges(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Which bar may follow which with another threshold"""
    def use_points(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Places of frames on the map"""
    def use_level(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Candidates and links of a level"""
    def use_neighbours(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Where one may go from a candidate"""
    def use_path(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Make a path over key frames"""
    def use_refine(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Refine a path, or see what it may lead over"""
    def use_playback(
        self,
        *,
        id: str,
        request: dict[str, Any],
        format: str | None = ...,
        positions: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ResultUsed | Content:
        """Play a path as a motion of markers"""
