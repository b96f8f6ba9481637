"""Changes of one document, each a revision.

| module | changes | |---|---|
| `whole_document` | facts, labels and deletion of a document; restoring a revision, undoing one |
| `calibration` | the unit, the axes, the floor and the reference pose of a document |
| `single_element` | attributes and text of one element at an address, or its deletion |
| `element_insertion` | elements put beside, into, or in place of another one |
| `element_edits` | several edits of elements as one revision |
| `frame_elements` | `frame` and `frame_bone` elements: one value, one id |
| `frame_labels` | `motion_name` elements of single frames |
| `frame_ranges` | consecutive frames: deleted, kept, copied, moved, reversed; samples written as arrays |
| `frame_splicing` | the timeline below all of these: frames in place of others |
| `motion_processing` | recomputed samples: mirrored, smoothed, moved, scaled, resampled |
| `drafts` | all changes of a draft, as one revision |
| `draft_merging` | a draft of an older revision, merged into the current one |
"""
