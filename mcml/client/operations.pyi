"""Types of `repo.operations`, made by `make docs` from the declarations of operations."""

from typing import Any, Literal

from mcml.answers import Content
from mcml.client.client import Client, FileProgress
from mcml.formats.format import SourceFile
from mcml_schemas.arrays import ArraysRequest
from mcml_schemas.bodies import Calibration, CalibrationChange
from mcml_schemas.catalogues import (
    DemoLoaded,
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
from mcml_schemas.compose import Composed, ComposeRequest, MadeSkeletons, SkeletonsRequest, SplitParts, SplitRequest
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
from mcml_schemas.gait import CalibratedTrials, GaitComparison, GaitMeasures, StandingTrial, StandingTrialUse
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
from mcml_schemas.matching import FollowRequest, MatchingFacts, MatchingSelection, PathFollowed
from mcml_schemas.measure import MeasureRequest, Measures
from mcml_schemas.measurements import MeasurementList
from mcml_schemas.media import MediaChange, MediaInfo
from mcml_schemas.names import AliasTable, AppliedNames, JointChoices, SavedAliases
from mcml_schemas.querying.examples import QuantityRange, QueryExamples
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
from mcml_schemas.retarget import (
    KnownRigs,
    Mapping,
    MappingPage,
    Retargeted,
    RetargetMany,
    RetargetRequest,
    RetargetTable,
    SavedMapping,
)
from mcml_schemas.revisions import Difference, FileReplaced
from mcml_schemas.selections import CopiedDocuments, ManyChanges, ManyCopies, ManyDocuments
from mcml_schemas.skeletons import CharacterList, CharacterView, SkeletonView
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
from mcml_schemas.team.proposals import ProposalDetail, ProposalPage, ProposalRequest, ProposalView
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
        """List documents."""
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
        """List the values by which documents can be filtered, with counts."""
    def get_document(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Get everything about a document except its frames."""
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
        take: str | None = ...,
        rate: float | None = ...,
        repair: list[str] | None = ...,
        strict_names: bool | None = ...,
        movements: float | None = ...,
        progress: FileProgress | None = None,
    ) -> UploadResult:
        """Import files as documents."""
    def load_demo(
        self,
        *,
        part: list[Literal["people", "reaches", "dances", "walks", "faces"]] | None = ...,
        project: str | None = ...,
        seed: int | None = ...,
        progress: FileProgress | None = None,
    ) -> DemoLoaded:
        """Store the demo library: generated walks, reaches, dances and faces."""
    def inspect_files(
        self,
        *,
        file: list[SourceFile],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        encoding: str | None = ...,
        take: str | None = ...,
        rate: float | None = ...,
        repair: list[str] | None = ...,
        progress: FileProgress | None = None,
    ) -> InspectResult:
        """Preview an import: the clips, units, rates and joint names that these files contain."""
    def replace_file(
        self,
        *,
        id: str,
        file: list[SourceFile],
        encoding: str | None = ...,
        translation: Literal["auto", "absolute", "relative"] | None = ...,
        take: str | None = ...,
        rate: float | None = ...,
        repair: list[str] | None = ...,
        replace_skeleton: bool | None = ...,
        dry_run: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> FileReplaced:
        """Replace the frames of a document by those of a new file."""
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
        """Move a document to the trash."""
    def restore_document(
        self,
        *,
        id: str,
        revision: int | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Restore a deleted document, or restore an earlier revision as a new revision."""
    def undo_revision(
        self,
        *,
        id: str,
        revision: int | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DocumentDetail:
        """Revert the changes of one revision, as a new revision."""
    def list_revisions(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        with_: Literal["frames"] | None = ...,
        progress: FileProgress | None = None,
    ) -> RevisionPage:
        """List the revisions of a document, newest first."""
    def compare_revisions(
        self,
        *,
        id: str,
        before: int,
        after: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Difference:
        """Compare two revisions: elements, frames, labels, samples, angles between poses."""
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
        """Move all documents of a selection to the trash."""
    def restore_documents(
        self,
        *,
        request: ManyDocuments | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Restore deleted documents."""
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
        """Change fields of all documents of a selection, and label their frames."""
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
        """Get a document as MCML, valid against `mcml.dtd`."""
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
        """Find the next occurrence of a text in a document: its line, and the address of the element."""
    def export_document(
        self,
        *,
        id: str,
        format: str | None = ...,
        revision: int | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        names: str | None = ...,
        unit: str | None = ...,
        up: str | None = ...,
        original: bool | None = ...,
        frame_time: str | float | None = ...,
        fps: float | None = ...,
        scale: float | None = ...,
        height: float | None = ...,
        in_place: bool | None = ...,
        guesses: bool | None = ...,
        character: str | None = ...,
        for_: str | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """Export a document in a motion-capture format."""
    def export_documents(
        self,
        *,
        request: ExportRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Content:
        """Export the documents of a selection as one zip of files."""
    def get_skeleton(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> SkeletonView:
        """Get the skeleton of a document with all data for drawing and posing it."""
    def get_thumbnail(
        self,
        *,
        id: str,
        first: int | None = ...,
        last: int | None = ...,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """Get a small animated picture of a document's skeleton."""
    def get_character(
        self,
        *,
        id: str,
        revision: int | None = ...,
        character: str | None = ...,
        progress: FileProgress | None = None,
    ) -> CharacterView:
        """Get the body that a document is drawn with: a mesh, made to its skeleton, and its weights."""
    def list_characters(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> CharacterList:
        """List the characters of the library: documents whose file has a mesh with a skin."""
    def get_calibration(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Calibration:
        """Get the calibration of a body: unit, up axis, floor and leg length, each with its source."""
    def list_measurements(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> MeasurementList:
        """List the measurements of a document: quantities of its own model, analog channels, force plates."""
    def get_analog(
        self,
        *,
        id: str,
        channel: list[str] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        scaled: bool | None = ...,
        format: Literal["csv", "arrow", "parquet"] | None = ...,
        revision: int | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """Get the analog channels of a document, such as electromyography, at their own rate."""
    def change_calibration(
        self,
        *,
        id: str,
        change: CalibrationChange | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Calibration:
        """Set the unit, up axis, floor, leg length or reference pose of a document, as a revision."""
    def get_gait(
        self,
        *,
        id: str,
        revision: int | None = ...,
        events: Literal["auto", "labels", "positions"] | None = ...,
        subject: str | None = ...,
        quantity: list[str] | None = ...,
        progress: FileProgress | None = None,
    ) -> GaitMeasures:
        """Measure gait: events, strides, spatio-temporal parameters and cycles, with their sources."""
    def compare_gait(
        self,
        *,
        document: list[str],
        compare: list[str] | None = ...,
        reference: list[str] | None = ...,
        quantity: list[str] | None = ...,
        events: Literal["auto", "labels", "positions"] | None = ...,
        progress: FileProgress | None = None,
    ) -> GaitComparison:
        """Compare the gait of trials: parameters and cycles of several, beside others and a normal band."""
    def get_gait_report(
        self,
        *,
        document: list[str],
        compare: list[str] | None = ...,
        reference: list[str] | None = ...,
        quantity: list[str] | None = ...,
        events: Literal["auto", "labels", "positions"] | None = ...,
        format: Literal["pdf", "csv"] | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """Get a gait report of several trials to print, or all of their cycles as a table."""
    def get_standing_trial(
        self,
        *,
        id: str,
        foot: Literal["flat", "as it stands"] | None = ...,
        subject: str | None = ...,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> StandingTrial:
        """Get the measures that a standing trial gives to walking trials: offsets and lengths, with sources."""
    def use_standing_trial(
        self,
        *,
        id: str,
        use: StandingTrialUse | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> CalibratedTrials:
        """Use a standing trial: give its offsets and lengths to walking trials of the same person."""
    def put_media(
        self,
        *,
        id: str,
        file: SourceFile,
        offset: float | None = ...,
        progress: FileProgress | None = None,
    ) -> MediaInfo:
        """Attach reference video or audio to a document."""
    def get_media(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Content:
        """Get the reference video or audio of a document."""
    def change_media(
        self,
        *,
        id: str,
        change: MediaChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> MediaInfo:
        """Set the time in the reference media at which the motion begins."""
    def delete_media(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Remove the reference video or audio of a document."""
    def list_comments(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        proposal: int | None = ...,
        progress: FileProgress | None = None,
    ) -> CommentPage:
        """List the comments on a document, its frames and joints."""
    def add_comment(
        self,
        *,
        id: str,
        comment: CommentRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Comment on a document, some of its frames, or a joint."""
    def change_comment(
        self,
        *,
        id: str,
        comment: int,
        change: CommentChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Edit your own comment."""
    def resolve_comment(
        self,
        *,
        id: str,
        comment: int,
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Mark a comment as resolved."""
    def reopen_comment(
        self,
        *,
        id: str,
        comment: int,
        progress: FileProgress | None = None,
    ) -> CommentView:
        """Mark a comment as unresolved."""
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
        """List the people who are viewing or editing a document."""
    def keep_presence(
        self,
        *,
        id: str,
        presence: PresenceRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> PresentList:
        """Announce that you are viewing or editing a document, and list the others."""
    def end_presence(
        self,
        *,
        id: str,
        tab: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Announce that you have closed a document."""
    def list_proposals(
        self,
        *,
        id: str,
        limit: int | None = ...,
        cursor: str | None = ...,
        state: Literal["pending", "open", "approved", "applied", "closed"] | None = ...,
        progress: FileProgress | None = None,
    ) -> ProposalPage:
        """List the proposed changes of a document."""
    def create_proposal(
        self,
        *,
        id: str,
        proposal: ProposalRequest | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ProposalView:
        """Propose a change of a document."""
    def preview_changes(
        self,
        *,
        id: str,
        proposal: ProposalRequest | dict[str, Any],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        column: list[str] | None = ...,
        quantity: list[str] | None = ...,
        pixels: int | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> FramesEdited:
        """Preview a change of a document before proposing it: notes, curves, positions."""
    def get_proposal(
        self,
        *,
        id: str,
        proposal: int,
        progress: FileProgress | None = None,
    ) -> ProposalDetail:
        """Get a proposal with its change."""
    def preview_proposal(
        self,
        *,
        id: str,
        proposal: int,
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        column: list[str] | None = ...,
        quantity: list[str] | None = ...,
        pixels: int | None = ...,
        progress: FileProgress | None = None,
    ) -> FramesEdited:
        """Preview the effect of a proposal: notes, curves, positions."""
    def approve_proposal(
        self,
        *,
        id: str,
        proposal: int,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> ProposalView:
        """Approve a proposal."""
    def apply_proposal(
        self,
        *,
        id: str,
        proposal: int,
        progress: FileProgress | None = None,
    ) -> ProposalView:
        """Apply a proposal to its document, as one revision."""
    def rebase_proposal(
        self,
        *,
        id: str,
        proposal: int,
        progress: FileProgress | None = None,
    ) -> ProposalView:
        """Rebase a proposal: make it one for the current revision."""
    def close_proposal(
        self,
        *,
        id: str,
        proposal: int,
        progress: FileProgress | None = None,
    ) -> ProposalView:
        """Close a proposal without applying it."""
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
        character: str | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> FramePage | Content:
        """Get frames of a document as numbers in the source's units."""
    def edit_frames(
        self,
        *,
        id: str,
        edits: FrameEdits | dict[str, Any],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        column: list[str] | None = ...,
        quantity: list[str] | None = ...,
        pixels: int | None = ...,
        dry_run: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> FramesEdited:
        """Edit ranges of frames: delete, move, mirror, fill gaps, filter, smooth, resample, and more."""
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
        """Set channels of consecutive frames from JSON or a NumPy file."""
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
        """List the labels of a document with their frame ranges, in order."""
    def suggest_labels(
        self,
        *,
        id: str,
        kind: Literal["activities", "movements"] | None = ...,
        confidence: float | None = ...,
        facing: Literal["X", "-X", "Y", "-Y", "Z", "-Z"] | None = ...,
        progress: FileProgress | None = None,
    ) -> SuggestedLabels:
        """Suggest labels: activities or movements recognised in the motion."""
    def add_labels(
        self,
        *,
        id: str,
        labels: list[LabelRequest] | list[dict[str, Any]],
        strict: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> LabelPage:
        """Label ranges of frames."""
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
        """Remove a label from its frames."""
    def label_by_query(
        self,
        *,
        request: LabelQuery | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Add a label to all frames that an XPath expression selects, or remove it from them."""
    def export_labels(
        self,
        *,
        project: str | None = ...,
        document: list[str] | None = ...,
        format: Literal["csv", "arrow", "parquet"] | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """Export the labels of documents as a CSV table: document, label, first, last."""
    def import_labels(
        self,
        *,
        content: bytes,
        project: str | None = ...,
        strict: bool | None = ...,
        replace: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> ChangedDocuments:
        """Import labels from a CSV table in the format of the export."""
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
        """List the children of an element, page by page."""
    def get_element(
        self,
        *,
        id: str,
        xpath: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> Content:
        """Get one element of a document as XML, or the value of one attribute as text."""
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
        """Delete elements or attributes, unless `mcml.dtd` or the frames require them."""
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
        """Replace an element with other elements."""
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
        """Insert elements beside an element, or into it."""
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
        """Change values of frames, elements, labels and fields of a document as one revision: all, or none."""
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
        """Evaluate an XPath expression over documents, such as `//frame[motion_name='left-arm-abduction']`."""
    def post_query(
        self,
        *,
        request: QueryRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> QueryAnswer | Content:
        """Evaluate a long XPath expression, or one with variables."""
    def complete_query(
        self,
        *,
        q: str,
        at: int | None = ...,
        document: list[str] | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Completions:
        """Complete an expression: elements, attributes, axes, functions, and names in use."""
    def get_query_examples(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> QueryExamples:
        """Get examples of queries that find frames in this library."""
    def get_quantity_range(
        self,
        *,
        quantity: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> QuantityRange:
        """Get the range of a quantity in this library."""
    def search_motion(
        self,
        *,
        request: SearchRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> SearchAnswer:
        """Find the poses or motions most similar to a pose or motion of a document, or to joint positions."""
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
        """Find the poses or motions most similar to those of a file, without importing it."""
    def export_arrays(
        self,
        *,
        request: ArraysRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Content:
        """Export frames of many clips as one array or table: positions, rotations, channels, quantities."""
    def measure(
        self,
        *,
        request: MeasureRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Measures | Content:
        """Measure quantities in frame ranges of many clips: a table, outliers first, and mean curves of groups."""
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
        """Compose a document from frames of others, in sequence, with transitions."""
    def split_document(
        self,
        *,
        id: str,
        request: SplitRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> SplitParts:
        """Split a document into several: at frames, or by the ranges of a label."""
    def make_skeletons(
        self,
        *,
        id: str,
        request: SkeletonsRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> MadeSkeletons:
        """Make skeletons for the people of a marker trial, each as a new document."""
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
        """Retarget a motion to the skeleton of another document or to a known rig, as a new document."""
    def retarget_many(
        self,
        *,
        request: RetargetMany | dict[str, Any],
        format: Literal["ndjson", "json", "csv"] | None = ...,
        summary: bool | None = ...,
        raw: bool | None = ...,
        progress: FileProgress | None = None,
    ) -> RetargetTable | Content:
        """Retarget the motions of all selected documents to one skeleton, each as a new document."""
    def follow_path(
        self,
        *,
        request: FollowRequest | dict[str, Any],
        positions: Literal["f4"] | None = ...,
        first: int | None = ...,
        last: int | None = ...,
        step: int | None = ...,
        progress: FileProgress | None = None,
    ) -> PathFollowed:
        """Make a document in which a body follows a path, of frames of many clips (motion matching)."""
    def get_matching_library(
        self,
        *,
        request: MatchingSelection | dict[str, Any],
        format: Literal["json", "npy"] | None = ...,
        progress: FileProgress | None = None,
    ) -> MatchingFacts | Content:
        """Get the features of clips by which motion matching finds its frames."""
    def list_collections(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> CollectionPage:
        """List collections of documents, by project and name."""
    def get_collection(
        self,
        *,
        name: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Collection:
        """Get a collection and its documents."""
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
        """List saved queries, by project and name."""
    def get_saved_query(
        self,
        *,
        name: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SavedQuery:
        """Get a saved query."""
    def save_query(
        self,
        *,
        name: str,
        query: QueryToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SavedQuery:
        """Save an XPath expression under a name."""
    def delete_query(
        self,
        *,
        name: str,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a saved query."""
    def get_colours(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Colours:
        """Get the colours of labels in a project."""
    def save_colours(
        self,
        *,
        colours: ColoursToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Colours:
        """Set all colours of labels in a project."""
    def get_vocabulary(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Vocabulary:
        """Get the label vocabulary of a project."""
    def save_vocabulary(
        self,
        *,
        vocabulary: VocabularyToSave | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Vocabulary:
        """Set the label vocabulary of a project."""
    def delete_vocabulary(
        self,
        *,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete the label vocabulary of a project."""
    def list_mappings(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> MappingPage:
        """List saved joint mappings, by project and name."""
    def get_mapping(
        self,
        *,
        name: str,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Mapping:
        """Get a saved joint mapping."""
    def save_mapping(
        self,
        *,
        name: str,
        mapping: SavedMapping | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> Mapping:
        """Save a joint mapping under a name."""
    def delete_mapping(
        self,
        *,
        name: str,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a saved joint mapping."""
    def get_aliases(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AliasTable:
        """Get the joint names that a project has defined."""
    def save_aliases(
        self,
        *,
        aliases: SavedAliases | dict[str, Any],
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AliasTable:
        """Set all joint names that a project defines."""
    def delete_aliases(
        self,
        *,
        project: str | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete all joint names that a project has defined."""
    def apply_names(
        self,
        *,
        id: str,
        dry_run: bool | None = ...,
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AppliedNames:
        """Rename joints of a document as an import would name them now, as a revision."""
    def name_joints(
        self,
        *,
        id: str,
        choices: JointChoices | dict[str, Any],
        if_match: str | None = ...,
        progress: FileProgress | None = None,
    ) -> AppliedNames:
        """Give joints of a document names of MCML's, as a revision."""
    def list_analyses(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> AnalysisList:
        """List all analyses with their parameters, the parts of their results, and their actions."""
    def get_analysis(
        self,
        *,
        name: str,
        progress: FileProgress | None = None,
    ) -> AnalysisInfo:
        """Get an analysis with its parameters as JSON Schema."""
    def read_music(
        self,
        *,
        file: SourceFile,
        bpm: float | None = ...,
        beats_per_bar: int | None = ...,
        progress: FileProgress | None = None,
    ) -> MusicBeats:
        """Detect the beats of a music file."""
    def list_jobs(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        state: Literal["waiting", "running", "done", "failed", "cancelled"] | None = ...,
        progress: FileProgress | None = None,
    ) -> JobPage:
        """List jobs, newest first."""
    def get_job(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Job:
        """Get the progress and the outcome of a job."""
    def cancel_job(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Job:
        """Cancel a job."""
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
        """List results without their parts, newest first."""
    def get_result(
        self,
        *,
        id: str,
        progress: FileProgress | None = None,
    ) -> Result:
        """Get a result with its parts."""
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
        """Get a plot of a result: curves, graph, map or table as SVG or PNG."""
    def get_result_part(
        self,
        *,
        id: str,
        part: str,
        format: Literal["json", "csv"] | None = ...,
        progress: FileProgress | None = None,
    ) -> PartSummary | Content:
        """Get one part of a result."""
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
        """Get an array of a part, or some of its rows."""
    def list_formats(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> FormatList:
        """List supported formats, presets of exports, and known formats that are not supported, with the reason."""
    def list_joint_names(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> JointNameList:
        """List joint names: MCML's own, and their names in other rigs."""
    def list_motion_names(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> MotionNameList:
        """List labels with their frames, and movements of each part of the body."""
    def list_skeletons(
        self,
        *,
        limit: int | None = ...,
        cursor: str | None = ...,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> SkeletonPage:
        """List the skeletons in use."""
    def list_rigs(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> KnownRigs:
        """List the known rigs that motions can be retargeted to."""
    def get_rest_pose(
        self,
        *,
        id: str,
        revision: int | None = ...,
        progress: FileProgress | None = None,
    ) -> RestPose:
        """Get the skeleton of a document in its rest pose."""
    def list_projects(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> ProjectList:
        """List projects by name."""
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
        kind: Literal[
            "document", "comment", "proposal", "project", "job", "member", "share", "webhook", "account", "token"
        ]
        | None = ...,
        since: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ActivityPage:
        """List the activity in the repository, newest first."""
    def create_project(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> ProjectView:
        """Create an empty project."""
    def get_project(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> ProjectView:
        """Get the size, the quota and the state of a project."""
    def change_project(
        self,
        *,
        change: ProjectChange | dict[str, Any],
        project: str,
        progress: FileProgress | None = None,
    ) -> ProjectView:
        """Archive or reopen a project, or change its quota."""
    def export_project(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> Content:
        """Export a project with every revision as one file."""
    def import_project(
        self,
        *,
        file: SourceFile,
        name: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ProjectImported:
        """Import a project from an exported file."""
    def get_account(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> Me:
        """Get your account: name, role and permissions."""
    def change_password(
        self,
        *,
        change: PasswordChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> None:
        """Change your own password."""
    def list_accounts(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> AccountList:
        """List accounts."""
    def add_owner(
        self,
        *,
        request: OwnerRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> AccountView:
        """Create the first account, an owner's."""
    def change_account(
        self,
        *,
        name: str,
        change: AccountChange | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> AccountView:
        """Change the role of an account, or close it."""
    def list_invitations(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> InvitationList:
        """List open invitations."""
    def invite(
        self,
        *,
        request: InvitationRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> InvitationMade:
        """Invite a person to create an account with a role, in the repository or in one project."""
    def revoke_invitation(
        self,
        *,
        number: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Revoke an invitation."""
    def list_members(
        self,
        *,
        project: str,
        progress: FileProgress | None = None,
    ) -> MemberList:
        """List the members of a project with their roles."""
    def set_member(
        self,
        *,
        name: str,
        change: MemberChange | dict[str, Any],
        project: str,
        progress: FileProgress | None = None,
    ) -> MemberList:
        """Add a member to a project, or change their role."""
    def remove_member(
        self,
        *,
        name: str,
        project: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Remove a member from a project."""
    def list_shares(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> ShareList:
        """List share links."""
    def add_share(
        self,
        *,
        request: ShareRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> ShareMade:
        """Create a share link, with which people without an account can view documents."""
    def revoke_share(
        self,
        *,
        number: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Revoke a share link."""
    def list_webhooks(
        self,
        *,
        project: str | None = ...,
        progress: FileProgress | None = None,
    ) -> WebhookList:
        """List webhooks."""
    def add_webhook(
        self,
        *,
        request: WebhookRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> WebhookMade:
        """Add a webhook, which receives events at a URL."""
    def remove_webhook(
        self,
        *,
        number: int,
        progress: FileProgress | None = None,
    ) -> None:
        """Delete a webhook."""
    def list_deliveries(
        self,
        *,
        number: int,
        limit: int | None = ...,
        cursor: str | None = ...,
        progress: FileProgress | None = None,
    ) -> DeliveryPage:
        """List sent and waiting messages of a webhook."""
    def redeliver(
        self,
        *,
        number: int,
        message: int,
        progress: FileProgress | None = None,
    ) -> DeliveryView:
        """Send a message of a webhook again."""
    def list_tokens(
        self,
        *,
        progress: FileProgress | None = None,
    ) -> TokenList:
        """List your tokens: names, scopes, dates."""
    def add_token(
        self,
        *,
        request: TokenRequest | dict[str, Any],
        progress: FileProgress | None = None,
    ) -> TokenMade:
        """Create a token for a program."""
    def revoke_token(
        self,
        *,
        name: str,
        progress: FileProgress | None = None,
    ) -> None:
        """Revoke a token immediately."""
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
        """Possible transitions between bars of dance clips, by distances of poses and movement, without dead ends."""
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
    def start_gait(
        self,
        *,
        request: dict[str, Any],
        progress: FileProgress | None = None,
    ) -> Job:
        """Spatio-temporal parameters of any number of trials, by trial and side, and pooled by subject."""
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
        """Linked candidates of a candidate"""
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
        """Refine a path, or list its possible refinements"""
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
