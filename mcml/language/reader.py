"""A document as a stream: the head as elements, the frames as blocks, checked against `mcml.dtd` on the way.

Memory does not grow with the length of the motion. Every element is checked when it begins and ends, by the content
models that `mcml.language.content` compiles from `mcml.dtd`, so an error has its line; tests prove that the verdict is
libxml2's. Beyond the DTD: bones named in frames exist and appear once in a frame, channel values are finite decimals,
the counts agree. Entities, other DOCTYPEs, and anything beyond the limits are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import BinaryIO
from xml.parsers import expat

from mcml.errors import DocumentError, LimitError, McmlError, Notice, Place
from mcml.language.bones import MAX_DEPTH
from mcml.language.content import START, declarations
from mcml.language.element import Element, addresses, leaf
from mcml.language.elements import check_counts, joint_names, to_head
from mcml.language.frames import FrameReader
from mcml.language.lexical import WHITE_SPACE
from mcml.language.prologue import refused_doctype, utf8_chunks
from mcml.language.repeats import END, Pattern, match
from mcml.language.vocabulary import BONE, DOF, FRAME, FRAMES, FRAMETIME, MCML, MOTION, NAME, ORDER, ROOT
from mcml.motion.clip import ClipStream, FrameBlock

ELEMENT_SIZE = 100
"""Size of an element of the head besides its text, in characters: many empty elements also fill the memory."""


@dataclass(frozen=True, slots=True)
class Limits:
    """How much a document may hold.

    max_bytes: of the file. max_frames. max_head: characters of header, root and skeleton, each element counting as
    ELEMENT_SIZE more. max_text: characters of one text or tag. max_names: motion names of one frame.
    """

    max_bytes: int = 4 << 30
    max_frames: int = 10_000_000
    max_head: int = 16 << 20
    max_text: int = 4 << 20
    max_names: int = 1000


@dataclass
class McmlDocument:
    """A document that is being read.

    document: the `mcml` element without its motion, texts trimmed, otherwise as written.
    clip: its head, and its frames in blocks. They are checked while they are read: the document is known to be valid
    once `clip.blocks()` came to its end. `blocks` starts from the beginning each time if the stream can seek, else it
    works once.
    """

    document: Element
    clip: ClipStream

    @property
    def notices(self) -> list[Notice]:
        """Losses and guesses; complete once the blocks were read to the end."""
        return self.clip.notices


def read_document(stream: BinaryIO, limits: Limits | None = None, encoding: str | None = None) -> McmlDocument:
    """Reads the head of a document and gives its frames as a stream.

    encoding: for a document that does not state its own. Raises DocumentError with the line for a document that is
    not well-formed or not valid or breaks the rules beyond, LimitError for one that is too large.
    """
    limits = limits or Limits()
    seekable = stream.seekable()
    start = stream.tell() if seekable else 0
    first = _Pass(stream, limits, encoding)
    first.read_head()
    passes: list[_Pass] = [first]

    def blocks() -> Iterator[FrameBlock]:
        if passes:
            return passes.pop().blocks()
        if not seekable:
            raise ValueError("the frames were read already, and the stream cannot seek")
        stream.seek(start)
        again = _Pass(stream, limits, encoding)
        again.read_head()
        return again.blocks()

    head = to_head(first.document, first.frame_time)
    return McmlDocument(first.document, ClipStream(head, blocks, first.frames, first.notices))


class _Pass:
    """One reading of the stream from its start to its end."""

    def __init__(self, stream: BinaryIO, limits: Limits, encoding: str | None) -> None:
        self.notices: list[Notice] = []
        self._limits = limits
        self._chunks = utf8_chunks(stream, limits.max_bytes, encoding)
        self._fed = 0
        self._parser = parser = expat.ParserCreate("utf-8")
        parser.ordered_attributes = True
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = self._doctype
        parser.CommentHandler = self._comment
        parser.ProcessingInstructionHandler = self._comment
        self._handle(self._start, self._end, self._text)
        self._stack: list[tuple[Element, int]] = []
        self._lines: dict[int, int] = {}
        self._size = 0
        self._pieces: list[str] = []
        self._pieces_size = 0
        self._dropped = 0
        self._frame_reader: FrameReader | None = None
        self._done = False
        self._carry = b""
        self._frame_end = -1
        self._pattern: Pattern | None = None
        self._skipped_lines = 0
        self.document = Element(MCML)
        self.frames = 0
        self.frame_time: str | None = None

    def read_head(self) -> None:
        """Reads until header, root and skeleton are complete and the first frame is known, if there is one."""
        for _ in self._feed():
            if self._frame_reader is not None and (self._frame_reader.total or self._done):
                break

    def blocks(self) -> Iterator[FrameBlock]:
        """The blocks of frames, as they become complete."""
        reader = self._frame_reader
        if reader is None:
            raise ValueError("the head was not read")
        for _ in self._feed():
            ready, reader.blocks = reader.blocks, []
            yield from ready
        if self._dropped:
            self.notices.append(Notice("warning", f"{self._dropped} XML comments or instructions were dropped"))
            self._dropped = 0

    def _feed(self) -> Iterator[None]:
        """Reads chunk by chunk; the last turn comes after the end of the document."""
        try:
            for chunk in self._chunks:
                self._take(self._carry + chunk)
                yield
            if not self._done:
                self._parse(self._carry)
                self._parser.Parse(b"", True)
                self._done = True
            yield
        except expat.ExpatError as error:
            what = f"not well-formed XML: {expat.ErrorString(error.code)}"
            line = error.lineno + self._skipped_lines
            raise DocumentError(what, at=Place(line=line, column=error.offset + 1)) from None

    def _take(self, data: bytes) -> None:
        """Gives data to the parser frame by frame, without those that repeat a pattern (`mcml.language.repeats`)."""
        at = 0
        self._carry = b""
        while (end := data.find(END, at)) >= 0:
            stop = end + len(END)
            begins_at_frame = self._frame_end == self._fed
            if not (begins_at_frame and self._repeats(data[at:end])):
                self._parse(data[at:stop])
                if begins_at_frame and self._frame_end == self._fed and self._frame_reader is not None:
                    self._pattern = self._frame_reader.pattern(data[at:end])
            at = stop
        if self._frame_end == self._fed and len(data) - at <= self._limits.max_text:
            self._carry = data[at:]
        else:
            self._parse(data[at:])

    def _repeats(self, raw: bytes) -> bool:
        """Takes a frame that repeats the pattern; False if it does not."""
        found = match(raw, self._pattern) if self._pattern is not None else None
        if found is None or self._pattern is None or self._frame_reader is None:
            return False
        self._frame_reader.repeat(self._pattern, *found)
        self._skipped_lines += self._pattern.line_feeds
        return True

    def _parse(self, data: bytes) -> None:
        self._fed += len(data)
        self._parser.Parse(data, False)
        if self._fed - self._parser.CurrentByteIndex > self._limits.max_text + (1 << 17):
            raise LimitError(f"a tag or text has more than {self._limits.max_text} characters", at=self._place())

    def _line(self) -> int:
        return self._parser.CurrentLineNumber + self._skipped_lines

    def _handle(
        self,
        start: Callable[[str, list[str]], None],
        end: Callable[[str], None],
        text: Callable[[str], None],
    ) -> None:
        self._parser.StartElementHandler = start
        self._parser.EndElementHandler = end
        self._parser.CharacterDataHandler = text

    def _start(self, tag: str, attributes: list[str]) -> None:
        declared = declarations().get(tag)
        if declared is None:
            raise DocumentError(f"there is no element {tag} in MCML", at=self._place())
        if self._stack:
            parent, state = self._stack[-1]
            model = declarations()[parent.tag]
            following = model.steps[state].get(tag)
            if following is None:
                raise DocumentError(model.child_error(state, tag), at=self._place())
            self._stack[-1] = parent, following
        elif tag != MCML:
            raise DocumentError(f"the document begins with {tag}", at=self._place(), remedy="Begin with mcml.")
        if len(self._stack) > MAX_DEPTH + 3:
            raise LimitError(f"bones are nested deeper than {MAX_DEPTH}", at=self._place())
        if tag == FRAME:
            self._begin_frame(attributes)
            return
        element = Element(tag, dict(zip(attributes[0::2], attributes[1::2], strict=True)))
        error = declared.attribute_error(element.attributes)
        if error:
            raise DocumentError(error, at=self._place())
        self._grow(ELEMENT_SIZE + sum(map(len, attributes)))
        self._lines[id(element)] = self._line()
        if not self._stack:
            self.document = element
        elif tag != MOTION:
            self._stack[-1][0].children.append(element)
        self._stack.append((element, START))

    def _end(self, tag: str) -> None:
        element, state = self._stack.pop()
        error = declarations()[tag].end_error(state)
        if error:
            raise DocumentError(error, at=self._place())
        element.text = "".join(self._pieces).strip(WHITE_SPACE)
        self._pieces, self._pieces_size = [], 0
        if tag == MOTION:
            reader = self._frame_reader or self._begin_frames(element)
            reader.flush()
            if reader.total != self.frames:
                raise DocumentError(
                    f"frames says {self.frames}, the motion has {reader.total}",
                    at=Place(line=self._lines[id(element.children[0])], element=f"/mcml/{MOTION}/{FRAMES}"),
                    remedy=f"Write {reader.total}.",
                )

    def _text(self, text: str) -> None:
        element, _ = self._stack[-1]
        kind = declarations()[element.tag].kind
        if kind == "text":
            # Comments cut a text into many pieces: they are joined once.
            self._pieces.append(text)
            self._pieces_size += len(text)
            self._grow(len(text))
            if self._pieces_size > self._limits.max_text:
                raise LimitError(f"a text has more than {self._limits.max_text} characters", at=self._place())
        elif kind == "empty" or text.strip(WHITE_SPACE):
            found = text.strip(WHITE_SPACE)[:40]
            raise DocumentError(f"{element.tag} cannot hold text, found {found!r}", at=self._place())

    def _begin_frame(self, attributes: list[str]) -> None:
        motion, _ = self._stack[-1]
        reader = self._frame_reader or self._begin_frames(motion)
        reader.begin(attributes)

        def end(tag: str) -> None:
            if tag != FRAME:
                reader.end(tag)
                return
            if reader.total == 0:
                reader.finish()
                self._state_channels(reader)
            else:
                reader.finish()
            self._handle(self._start, self._end, self._text)
            self._frame_end = self._parser.CurrentByteIndex + len(END)

        self._handle(reader.start, end, reader.text)

    def _begin_frames(self, motion: Element) -> FrameReader:
        """Check the complete head, and pass its joints to the reader of frames."""
        frames = motion.leaf(FRAMES) or ""
        self.frame_time = motion.leaf(FRAMETIME)
        motion_lines = {f"/mcml/{MOTION}/{child.tag}": self._lines[id(child)] for child in motion.children}
        if not (frames.isascii() and frames.isdigit() and len(frames) < 16):
            address = f"/mcml/{MOTION}/{FRAMES}"
            raise DocumentError(
                f"frames is {frames[:40]!r}, not a number of frames",
                at=Place(line=motion_lines[address], element=address),
            )
        self.frames = int(frames)
        if self.frames > self._limits.max_frames:
            raise LimitError(f"the document has more than {self._limits.max_frames} frames")
        try:
            to_head(self.document, self.frame_time)
            check_counts(self.document, self.frames)
            names = joint_names(self.document)
        except McmlError as error:
            raise self._with_line(error, motion_lines) from None
        joints = {name: index for index, name in enumerate(names)}
        self._frame_reader = FrameReader(
            joints,
            self._line,
            self._limits.max_frames,
            self._limits.max_names,
            self._limits.max_text,
        )
        return self._frame_reader

    def _state_channels(self, reader: FrameReader) -> None:
        """Joints that state no channels get those of the first frame: hand-written documents leave them out."""
        stated = state_channels(self.document, reader.first_channels)
        if stated:
            what = f"these bones state no order or dof, so the attributes of the first frame count: {', '.join(stated)}"
            self.notices.append(Notice("guess", what))

    def _doctype(self, name: str, system: str | None, public: str | None, internal: bool) -> None:
        why = "it declares entities or elements of its own" if internal else f"it names {system or public or name!r}"
        raise refused_doctype(self._line(), why)

    def _comment(self, *_: str) -> None:
        reader = self._frame_reader
        in_empty = bool(self._stack) and declarations()[self._stack[-1][0].tag].kind == "empty"
        if in_empty or (reader is not None and reader.inside_empty()):
            raise DocumentError("a comment is not allowed in an empty element", at=self._place())
        self._dropped += 1

    def _grow(self, characters: int) -> None:
        self._size += characters
        if self._size > self._limits.max_head:
            raise LimitError(f"header and skeleton have more than {self._limits.max_head} characters", at=self._place())

    def _place(self) -> Place:
        return Place(line=self._line())

    def _with_line(self, error: McmlError, motion_lines: dict[str, int]) -> McmlError:
        """The error with the line of the element whose address it gives."""
        wanted = (error.at.element or "").partition("/@")[0] if error.at else ""
        lines = motion_lines | {
            address: self._lines[id(element)] for address, element in addresses(self.document) if address == wanted
        }
        if wanted in lines and error.at:
            error.at = replace(error.at, line=lines[wanted])
        return error


def state_channels(document: Element, channels: dict[int, Sequence[str]] | dict[int, tuple[str, ...]]) -> list[str]:
    """Gives every root and bone without order and dof its channels, in place. Returns the names of those changed.

    channels: of each joint, by its index.
    """
    changed = []
    joints = [element for _, element in addresses(document) if element.tag in (ROOT, BONE)]
    for index, joint in enumerate(joints):
        own = " ".join(channels.get(index, ()))
        if not own:
            continue
        if joint.tag == ROOT and ORDER not in joint.attributes:
            joint.attributes[ORDER] = own
            changed.append(joint.attributes.get(NAME, "Root"))
        elif joint.tag == BONE and joint.first(ORDER) is None and joint.first(DOF) is None:
            before = (NAME, "direction", "length", "position", "axis")
            place = sum(1 for child in joint.children if child.tag in before)
            joint.children.insert(place, leaf(ORDER, own))
            changed.append(joint.leaf(NAME) or "")
    return changed
