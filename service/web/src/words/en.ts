/** English. Short, calm, present: what is so, then what to do. "one|many" is chosen by n. */
export const en = {
  product: "MCML Repository",
  library: "Library", xpath: "XPath", compose: "Composer", retarget: "Retarget", settings: "Settings", apiReference: "API reference",
  skip: "Skip to the content", menu: "Pages", pin: "Show words", unpin: "Icons only",
  searchAll: "clips, motion names, //xpath", palette: "Find anything", nothingFound: "Nothing is called so.",
  help: "Keys of this page", close: "Close", again: "Try again", cancel: "Cancel", more: "More", copy: "Copy", copied: "Copied",
  addressCopied: "Address copied", search: "Search", none: "None", save: "Save", open: "Open", add: "Add",
  remove: "Remove", name: "Name", undo: "Undo", redo: "Redo", loading: "Loading", show: "Show",
  offline: "The server does not answer since {time}. Your changes are kept here; trying again.",
  unknownPage: "There is no such page.", toLibrary: "To the library",
  singleKeys: "Single-key shortcuts", singleKeysHelp: "Letters such as J K L act without Ctrl.",
  theme: "Theme", dark: "Dark", light: "Light", system: "As the system", language: "Language", sides: "Side colours",
  sidesUsual: "Left blue, right orange", sidesSwapped: "Left orange, right blue", timeAs: "Time as", frameNumbers: "Frame numbers",
  seconds: "Seconds", timecode: "Timecode", everywhere: "Everywhere", onThisPage: "On this page",
  leftPanel: "Fold the left panel", rightPanel: "Fold the right panel", copyAddress: "Copy the address", goLibrary: "Go to the library",
  goXpath: "Go to XPath", goCompose: "Go to the composer", goRetarget: "Go to retargeting", goSettings: "Go to settings",

  // Library
  clips: "1 clip|{n} clips", grid: "Grid", list: "List", sort: "Order", newest: "newest first", byName: "by name",
  project: "Project", motionName: "Motion name", format: "Format", skeleton: "Skeleton", length: "Length", frameRate: "Frame rate",
  properties: "Properties", filters: "Filters", clearFilters: "Clear all filters",
  emptyLibrary: "Nothing is stored yet", emptyLibraryHelp: "Drop BVH, ASF and AMC, HTR, C3D or TRC files, folders or a zip anywhere in this window. Nothing is lost: what you drop comes back out byte for byte.",
  noneMatch: "No clip matches", noneMatchHelp: "Take a filter away, or search for other words.",
  chooseFiles: "Choose files", picked: "1 picked|{n} picked", pickNone: "Pick none", preview: "Preview", unit: "Unit", rateWord: "Rate",
  up: "Up", joints: "Joints", names: "Names", jointCount: "1 joint|{n} joints", description: "Description", unknown: "unknown", frames: "1 frame|{n} frames", framesAndTime: "{frames}, {time}",
  mapped: "{mapped} of {n} mapped", unitUnknown: "unknown unit", rateUnknown: "unknown rate",
  confirm: "Confirm", confirmAs: "Confirm {value}", deleted: "1 clip deleted|{n} clips deleted", restored: "Restored", delete: "Delete",
  nameThese: "Name", exportWord: "Export", composeThese: "Compose", labelPicked: "Name these clips",
  labelPickedHelp: "The motion name stands on all frames of each.", labelled: "1 clip named {name}|{n} clips named {name}",
  collect: "Collect", collectHelp: "A collection is a list of clips under a name, for every list and command.", collections: "Collections", newer: "{who} saved revision {n}.",
  revision: "revision {n}",
  openClip: "Open the clip", pickClip: "Pick {name}", moveToComposer: "To the composer",

  // Import
  dropTitle: "Drop to add", dropHelp: "Files, folders, or a zip. An ASF goes with its AMC.", lookFirst: "Look first", lookFirstHelp: "Opens them without storing anything",
  queue: "Import", queued: "waiting", sending: "sending", reading: "reading", stored: "stored", refused: "refused", cancelled: "cancelled",
  skippedTwin: "here already", retry: "Retry", uploads: "{done} of {n} done", receipts: "Receipts", hideQueue: "Hide the list",
  undoImport: "Undo import", receiptUnit: "Unit", receiptRate: "Rate", receiptUp: "Up axis", receiptJoints: "Joints", receiptNumbers: "Numbers",
  receiptNumbersText: "{channels} channels × {frames} frames; the original is kept byte for byte",
  jointsMapped: "{mapped} of {n} mapped (convention: {rig}), {own} keep their own names", notices: "Notes",
  noFiles: "No file could be read from what was dropped.", keep: "Keep", notStored: "Not stored yet",
  lookedAt: "Seen without storing", tooMany: "Only the first {n} files are taken.", twin: "Equal to a stored clip; both are kept.",

  // Clip
  draft: "Draft: 1 change|Draft: {n} changes", discard: "Discard", saved: "Saved as revision {n}", share: "Share",
  persp: "Perspective", front: "Front", side: "Side", top: "Top", view: "View", follow: "follow", ghosts: "ghosts", trails: "trails", jointNames: "names", axes: "axes",
  gridOf: "grid {size}", play: "Play", pause: "Pause", firstFrame: "First frame", lastFrame: "Last frame", backFrame: "One frame back",
  nextFrame: "One frame on", frame: "Frame", ofFrames: "of {n}", speed: "Speed", loop: "loop {first}–{last} ({n})", noLoop: "whole clip",
  clearLoop: "Clear the loop", setIn: "Loop from here", setOut: "Loop to here", timeline: "Timeline", oldRevision: "This is an old revision. Restore it to change it.",
  restore: "Restore", restoredAs: "Restored as revision {n}", tree: "Tree", graph: "Graph", structure: "Structure", text: "Text", history: "History", info: "Info",
  spanAdd: "Name this stretch", spanSplit: "Split at the playhead", spanName: "Motion name",
  spanHelp: "Drag in the lane to name a stretch; drag edges to trim.", spanFrom: "From", spanTo: "to", suggestions: "Suggest names", suggestionsNone: "No movement was recognised.",
  accept: "Accept", acceptAll: "Accept all {n}", hideSuggestions: "Hide suggestions", confidence: "confidence {value}", speedLane: "speed", namesLane: "names",
  noFrames: "This document has no frames.", tenBack: "Ten frames back", tenOn: "Ten frames on", previousEdge: "Previous edge", nextEdge: "Next edge", slower: "Play backwards, again faster",
  faster: "Play, again faster", stop: "Stop", frameSelection: "Look at the selection", picture: "Save a picture", film: "Record a film", viewerWords: "{name}, frame {frame} of {n}",
  dock: "Panels", channel: "Channel", euler: "Euler", quaternion: "Quaternion", selectJoint: "Select a joint: in the viewer, the tree or the structure.",
  smooth: "Smooth", scale: "Scale", offset: "Offset", apply: "Apply", overRange: "over frames {first}–{last}", selectFrames: "Drag over the curve to choose frames.",
  curveTools: "Curve tools", setKey: "Value at frame {frame}", author: "by {who}", thisRevision: "shown", showGhost: "Show as ghost",
  hideGhost: "Hide the ghost", difference: "Difference", original: "Original file", created: "Stored", provenance: "Where it comes from", commandLines: "For scripts",
  addProperty: "Add a property", value: "Value", elements: "1 element|{n} elements", boneLength: "Length", offsets: "Offset", parent: "Parent", conflict: "Someone saved another revision meanwhile.", conflictHelp: "Merge what does not touch theirs, or discard your draft.",
  bothChanged: "Both changed", theirs: "Theirs", mine: "Yours", keepMine: "Keep yours", takeTheirs: "Take theirs", merge: "Merge", openNewest: "Open the newest", textWindow: "Lines {first}–{last}", check: "Check", noFaults: "No fault found.", faults: "1 fault|{n} faults", exportAs: "as {format}", kept: "as it came",

  // XPath
  head: "Head", framesOf: "Frames {first}–{last}", sameFrames: "Frames are added and removed in the timeline or the tree, not here.",
  reference: "Reference", referenceHelp: "A video or a sound of the take, played in step.", chooseMedia: "Choose a video or a sound", beginsAt: "Motion begins at", mediaGone: "Taken away", referenceOf: "Video or sound of {name}",
  line: "line {n}",
  run: "Run", scope: "Scope", wholeLibrary: "the whole library", answerAs: "Answer as", runs: "runs", nodes: "nodes", explain: "Explain", savedQueries: "Saved", queryHistory: "History", saveQuery: "Save this query",
  asCurl: "as curl", asCommand: "as mcml", resultRuns: "{frames} in {runs}, {ms} ms", runCount: "1 run|{n} runs", resultNodes: "1 item, {ms} ms|{n} items, {ms} ms", incomplete: "incomplete", complete: "complete", document: "Document", from: "From", last: "To", playResults: "Plays the runs one after the other",
  exportAll: "Export all", saveAsClip: "Save as clip", toComposer: "To composer", noAnswer: "Nothing in the library answers this.", xpathStart: "Ask for frames by motion name, any element, in any clip",
  xpathExamples: "For example", queryPlaceholder: "//frame[motion_name = 'walk']", savedAs: "Saved as {name}",

  // Composer
  untitled: "untitled", bridge: "Bridge", crossfade: "Crossfade", bin: "Clips", pieces: "Pieces", dragHere: "Drag clips or runs here, or press + on one.", piece: "Piece {n}", transition: "Transition", trimFrom: "from", trimTo: "to", moveLeft: "Move left", moveRight: "Move right", split: "Split", previewWord: "Preview",
  newName: "Name of the new clip", composed: "Stored as {name}", total: "{time} in 1 piece|{time} in {n} pieces", seam: "Seam", composeEmpty: "Make a new clip of stored ones", fitOnAdd: "Pieces of other skeletons are retargeted.",

  // Retarget
  sourceClip: "Motion", targetClip: "Onto the body of", choose: "Choose a clip", mapping: "Mapping", mappedOf: "{n} of {total} joints", notMapped: "not mapped", retargetNow: "Make the clip", retargeting: "Retargeting", retargetEmpty: "Put a motion on another body", retargetHelp: "Choose the motion, and a clip with the body it shall move.", report: "Report", mappingName: "Save this mapping as", retargeted: "Stored as {name}", cleanFeet: "Hold feet where they stand", slides: "{foot} slides",
};
