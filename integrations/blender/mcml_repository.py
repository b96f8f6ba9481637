"""MCML Repository in Blender: browse a repository, import clips and the runs of a query as actions, send edits back.

One file, to be installed in Blender's preferences (docs/blender.md). It needs nothing but Blender's own Python.

The axes of all bones are those of the document's joints, not along the bones: so a curve of an action is a channel of
the document, its angle in radians, and goes back as the number that it is. Shapes show where bones lead.
"""

import http.client
import json
import math
import struct
import urllib.error
import urllib.parse
import urllib.request
from typing import NamedTuple

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty
from mathutils import Vector

bl_info = {
    "name": "MCML Repository",
    "description": "Clips of an MCML repository as actions, and edited actions as revisions",
    "author": "MCML Repository",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > MCML",
    "category": "Animation",
}
PAGE = 50
AXES = "XYZ"
SAME = 1e-6
"""Of a number in Blender, or of its size: single precision tells no closer."""
TURNS = {
    "X": (0, -math.pi / 2, 0),
    "-X": (0, math.pi / 2, 0),
    "Y": (math.pi / 2, 0, 0),
    "-Y": (-math.pi / 2, 0, 0),
    "Z": (0, 0, 0),
    "-Z": (math.pi, 0, 0),
}
"""By the axis that is up in a document, what turns it to Blender's Z."""
AGAIN = "Nothing was sent. Import the clip again and copy your keys to the new action."


# What follows knows nothing of Blender.


class RepositoryError(Exception):
    """What is wrong and what to do, in words for the user."""


class _NoRedirects(urllib.request.HTTPRedirectHandler):
    """The token is for the server that the preferences name, and for no other."""

    def redirect_request(self, *_):
        return None


class Server:
    """A repository's API."""

    def __init__(self, address, token=""):
        self.address = address.strip().rstrip("/")
        if not self.address.startswith(("http://", "https://")):
            raise RepositoryError("The address of the server must begin with http:// or https://.")
        self._headers = {"Authorization": f"Bearer {token.strip()}"} if token.strip() else {}
        self._opener = urllib.request.build_opener(_NoRedirects)

    def get(self, path, **parameters):
        return self._read(self._ask(path, parameters))

    def numbers(self, path, **parameters):
        """An answer of format=block, a tuple of floats."""
        content = self._ask(path, {**parameters, "format": "block"})
        return struct.unpack(f"<{len(content) // 8}d", content)

    def post(self, path, body, **headers):
        return self._read(self._ask(path, {}, json.dumps(body).encode(), headers))

    def _read(self, content):
        try:
            return json.loads(content)
        except ValueError as error:
            raise RepositoryError(f"What answers at {self.address} is no MCML repository.") from error

    def _ask(self, path, parameters, body=None, headers=None):
        said = urllib.parse.urlencode({name: value for name, value in parameters.items() if value not in (None, "")})
        sent = {**self._headers, **{name.replace("_", "-"): value for name, value in (headers or {}).items()}}
        if body is not None:
            sent["Content-Type"] = "application/json"
        try:
            asked = urllib.request.Request(f"{self.address}/api/v1/{path}?{said}", body, sent)
            with self._opener.open(asked, timeout=120) as answer:
                return answer.read()
        except urllib.error.HTTPError as error:
            raise RepositoryError(problem(error.code, error.read())) from error
        except (OSError, ValueError, http.client.HTTPException) as error:
            why = getattr(error, "reason", None) or error
            raise RepositoryError(f"No answer from {self.address}: {why}. Is `mcml serve` running there?") from error


def problem(status, content):
    """What an error's answer says, and how to mend it. content: problem details as JSON, or anything."""
    try:
        said = json.loads(content)
        text = " ".join(str(said[key]) for key in ("detail", "remedy") if said.get(key)) or said["title"]
    except (ValueError, KeyError, TypeError, AttributeError):
        text = f"The server answered with status {status}."
    more = {401: "Set the token in the preferences of this add-on.", 412: AGAIN}
    return " ".join([text, *([more[status]] if status in more else [])])


class Curve(NamedTuple):
    """A channel of a document that is a curve in Blender, which holds factor * number - rest."""

    column: int
    bone: int
    path: str
    axis: int
    factor: float
    rest: float


def editable(skeleton):
    """Whether all joints turn and move as curves of a pose bone do."""
    return all(bone["convention"] == "listed" for bone in skeleton["bones"])


def curves_of(skeleton):
    """The curves of a skeleton all of whose joints are `listed`, as the server tells it."""
    places = {bone["name"]: index for index, bone in enumerate(skeleton["bones"])}
    found = []
    for column, text in enumerate(skeleton["columns"]):
        name, _, channel = text.rpartition(".")
        index, axis = places[name], "xyz".find(channel[-1])
        bone = skeleton["bones"][index]
        if channel[0] == "R" and axis >= 0:
            found.append(Curve(column, index, "rotation_euler", axis, skeleton["radians"], 0.0))
        elif channel[0] == "T" and axis >= 0:
            rest = bone["offset"][axis] if bone["translation"] == "absolute" else 0.0
            found.append(Curve(column, index, "location", axis, 1.0, rest))
    return found


def order_of(bone):
    """Blender's name for the rotation order of a `listed` joint: what is first in a product is applied last."""
    order = bone["rotation_order"].upper()
    return (order + "".join(axis for axis in AXES if axis not in order))[::-1]


def short(name):
    """A name that Blender takes as it is: of the 63 bytes that it has, room for what it or we append."""
    return name.encode()[:44].decode(errors="ignore")


def single(value):
    """As Blender keeps it."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def held(curve, numbers):
    """What a curve holds for numbers of a document: missing samples keep the last value, or the rest before any."""
    found, last = [], 0.0
    for number in numbers:
        if number == number:
            last = curve.factor * number - curve.rest
        found.append(last)
    return found


def shortest(curve, value):
    """The number of fewest digits that is this value in Blender."""
    number = (value + curve.rest) / curve.factor
    for digits in range(5, 10):
        found = float(f"{number:.{digits}g}")
        if single(curve.factor * found - curve.rest) == single(value):
            return found
    return number


def changes_of(skeleton, first, base, sampled):
    """What samples of curves change in a document.

    first: the frame of the first row. base: all numbers of these frames, row after row. sampled: by curve, its values.
    Returns (a block of values for the API or None, how many samples change, how many cannot, as the document lacks
    them).
    """
    width, changed, lacking = len(skeleton["columns"]), {}, 0
    for curve, values in sampled.items():
        numbers = base[curve.column :: width]
        for row, (value, before) in enumerate(zip(values, held(curve, numbers), strict=True)):
            if abs(value - before) <= SAME * max(1.0, abs(before), abs(curve.rest)):
                continue
            if numbers[row] == numbers[row]:
                changed[row, curve.column] = shortest(curve, value)
            else:
                lacking += 1
    if not changed:
        return None, 0, lacking
    rows = [row for row, _ in changed]
    columns = sorted({column for _, column in changed})
    values = [[changed.get((row, column)) for column in columns] for row in range(min(rows), max(rows) + 1)]
    names = [skeleton["columns"][column] for column in columns]
    return {"first": first + min(rows), "columns": names, "values": values}, len(changed), lacking


def product(one, other):
    return [[sum(one[i][k] * other[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def matrix_of_angles(angles, order):
    """angles: about x, y, z. order: Blender's, applied first to last."""
    found = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for axis in map(AXES.index, order):
        cosine, sine = math.cos(angles[axis]), math.sin(angles[axis])
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = [[float(row == column) for column in range(3)] for row in range(3)]
        turn[i][i], turn[i][j], turn[j][i], turn[j][j] = cosine, -sine, sine, cosine
        found = product(turn, found)
    return found


def matrix_of_quaternion(quaternion):
    """quaternion: w, x, y, z of any length but 0."""
    size = math.sqrt(sum(part * part for part in quaternion)) or 1.0
    w, x, y, z = (part / size for part in quaternion)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def angles_of_matrix(matrix, order, near):
    """Angles about x, y, z of a rotation in Blender's order, of all that it has those nearest to others."""
    known = matrix_of_angles(near, order)
    if max(abs(matrix[i][j] - known[i][j]) for i in range(3) for j in range(3)) < 2 * SAME:
        return list(near)
    k, j, i = map(AXES.index, order)  # the product is about i, j, k
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    middle = math.asin(max(-1.0, min(1.0, sign * matrix[i][k])))
    if math.cos(middle) < 1e-4:  # only the sum of the outer angles is told: the last stays
        back = product(matrix, matrix_of_angles([-near[k] if axis == k else 0.0 for axis in range(3)], order))
        choices = [(math.atan2(sign * back[k][j], back[j][j]), middle, near[k])]
    else:
        outer = math.atan2(-sign * matrix[j][k], matrix[k][k])
        inner = math.atan2(-sign * matrix[i][j], matrix[i][i])
        choices = [(outer, middle, inner), (outer + math.pi, math.pi - middle, inner + math.pi)]
    whole = 2 * math.pi
    found = []
    for choice in choices:
        angles = [0.0, 0.0, 0.0]
        for axis, angle in zip((i, j, k), choice, strict=True):
            angles[axis] = angle + whole * round((near[axis] - angle) / whole)
        found.append(angles)
    return min(found, key=lambda angles: sum(abs(one - other) for one, other in zip(angles, near, strict=True)))


def times(one, other):
    """The product of quaternions x, y, z, w."""
    (a, b, c, d), (x, y, z, w) = one, other
    return (
        d * x + a * w + b * z - c * y,
        d * y - a * z + b * w + c * x,
        d * z + a * y - b * x + c * w,
        d * w - a * x - b * y - c * z,
    )


def poses_of(skeleton, positions, rotations):
    """Locations (x, y, z) and rotations (w, x, y, z) of pose bones, by bone, each a list of frames.

    positions, rotations: of joints in the world, from the rest pose, as the server tells them, frame after frame.
    """
    bones = skeleton["bones"]
    found = [([], []) for _ in bones]
    for row in range(len(positions) // (3 * len(bones))):
        for index, bone in enumerate(bones):
            place, above = row * len(bones) + index, row * len(bones) + bone["parent"]
            moved, turn = list(positions[place * 3 : place * 3 + 3]), rotations[place * 4 : place * 4 + 4]
            if bone["parent"] >= 0:
                x, y, z, w = rotations[above * 4 : above * 4 + 4]
                back = (-x, -y, -z, w)
                moved = [here - there for here, there in zip(moved, positions[above * 3 : above * 3 + 3], strict=True)]
                moved = times(times(back, (*moved, 0.0)), (x, y, z, w))[:3]
                turn = times(back, turn)
            turn = (turn[3], *turn[:3])
            locations, turns = found[index]
            if turns and sum(one * other for one, other in zip(turn, turns[-1], strict=True)) < 0:
                turn = tuple(-part for part in turn)
            locations.append(tuple(here - there for here, there in zip(moved, bone["offset"], strict=True)))
            turns.append(turn)
    return found


def ends_of(skeleton):
    """By bone, from its joint to where it leads: the joint below, a tip, or a little way up."""
    bones = skeleton["bones"]
    long = max((math.hypot(*bone["offset"]) for bone in bones if bone["parent"] >= 0), default=0.0)
    long = long or 0.2 / (skeleton.get("metres") or 1.0)
    found = [None] * len(bones)
    below = [(bone["parent"], bone["offset"]) for bone in bones]
    below += [(tip["bone"], tip["offset"]) for tip in skeleton["tips"]]
    for index, offset in below:
        if index >= 0 and found[index] is None and math.hypot(*offset) > long / 1000:
            found[index] = tuple(offset)
    return [end or (0.0, long / 10, 0.0) for end in found]


# What follows is Blender's.


def preferences(context):
    return context.preferences.addons[__name__].preferences


def server_of(context):
    told = preferences(context)
    return Server(told.server, told.token)


def figure_of(context, skeleton):
    """An armature of this skeleton: the active one, another one of the scene, or a new one."""
    told = json.dumps([skeleton["bones"], skeleton.get("metres"), skeleton["likely_up"]])
    for item in [context.object, *context.scene.objects]:
        if item is not None and item.type == "ARMATURE" and item.data.get("mcml_skeleton") == told:
            return item
    figure = new_figure(context, skeleton)
    figure.data["mcml_skeleton"] = told
    return figure


def new_figure(context, skeleton):
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    name = short(skeleton["name"])
    figure = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    context.collection.objects.link(figure)
    figure.scale = [skeleton.get("metres") or 1.0] * 3
    figure.rotation_euler = TURNS.get(skeleton["likely_up"], TURNS["Y"])
    select(context, figure)
    bpy.ops.object.mode_set(mode="EDIT")
    made = []
    for bone, end in zip(skeleton["bones"], ends_of(skeleton), strict=True):
        edited = figure.data.edit_bones.new(short(bone["name"]))
        above = made[bone["parent"]] if bone["parent"] >= 0 else None
        edited.head = Vector(bone["offset"]) + (above.head if above else Vector())
        edited.tail = edited.head + Vector((0.0, Vector(end).length, 0.0))
        edited.parent = above
        edited["mcml_bone"] = bone["name"]  # its own name may be shorter, or another one later
        made.append(edited)
    bpy.ops.object.mode_set(mode="OBJECT")
    shape, bones = bone_shape(), bones_of(figure)
    for bone, end in zip(skeleton["bones"], ends_of(skeleton), strict=True):
        posed = bones[bone["name"]]
        posed.rotation_mode = order_of(bone) if editable(skeleton) else "QUATERNION"
        posed.custom_shape = shape
        posed.custom_shape_rotation_euler = Vector((0, 1, 0)).rotation_difference(Vector(end)).to_euler()
    return figure


def bone_shape():
    """An octahedron along Y, of length 1, for all bones."""
    if "mcml_bone" not in bpy.data.objects:
        mesh = bpy.data.meshes.new("mcml_bone")
        corners = [(0, 0, 0), (0.1, 0.1, 0), (0, 0.1, 0.1), (-0.1, 0.1, 0), (0, 0.1, -0.1), (0, 1, 0)]
        sides = [(1, 2), (2, 3), (3, 4), (4, 1)]
        mesh.from_pydata(corners, [], [(end, *side) for side in sides for end in (0, 5)])
        bpy.data.objects.new("mcml_bone", mesh).use_fake_user = True
    return bpy.data.objects["mcml_bone"]


def select(context, figure):
    for item in context.selected_objects:
        item.select_set(False)
    figure.select_set(True)
    context.view_layer.objects.active = figure


def bones_of(figure):
    """Pose bones by the names of their joints in the document."""
    return {bone.bone["mcml_bone"]: bone for bone in figure.pose.bones if "mcml_bone" in bone.bone}


def import_action(context, server, document, first=1, last=None, revision=None):
    """Frames of a document as an action of a figure with its skeleton; they begin at Blender's frame 1.

    revision: in which these are the frames that are meant; the current one if it is not said.
    """
    skeleton = server.get(f"documents/{document}/skeleton", revision=revision)
    last = skeleton["frames"] if last is None else last
    if not skeleton["frames"]:
        raise RepositoryError(f"{skeleton['name']} has no frames.")
    asked = {"first": first, "last": last, "revision": skeleton["revision"]}
    frames = f"documents/{document}/frames"
    curves = []
    if editable(skeleton):
        numbers, width = server.numbers(frames, **asked), len(skeleton["columns"])
        for curve in curves_of(skeleton):
            curves.append((curve.bone, curve.path, curve.axis, held(curve, numbers[curve.column :: width])))
    else:
        spaces = [server.numbers(frames, **asked, space=space) for space in ("positions", "rotations")]
        for index, (locations, turns) in enumerate(poses_of(skeleton, *spaces)):
            for path, rows in (("location", locations), ("rotation_quaternion", turns)):
                curves += [(index, path, axis, values) for axis, values in enumerate(zip(*rows, strict=True))]
    figure = figure_of(context, skeleton)
    whole = (first, last) == (1, skeleton["frames"])
    action = bpy.data.actions.new(short(skeleton["name"]) + ("" if whole else f" {first}-{last}"))
    action.use_fake_user = True
    bones = bones_of(figure)
    for index, path, axis, values in curves:
        bone = bones[skeleton["bones"][index]["name"]]
        curve = action.fcurves.new(bone.path_from_id(path), index=axis, action_group=bone.name)
        curve.keyframe_points.add(len(values))
        curve.keyframe_points.foreach_set("co", [part for pair in enumerate(values, start=1) for part in pair])
        curve.keyframe_points.foreach_set("interpolation", [1] * len(values))  # linear
        curve.update()
    action.use_frame_range = True
    action.frame_start, action.frame_end = 1, last - first + 1
    action["mcml_server"], action["mcml_document"] = server.address, document
    action["mcml_revision"], action["mcml_first"], action["mcml_last"] = skeleton["revision"], first, last
    figure.animation_data_create().action = action
    select(context, figure)
    show(context.scene, action, skeleton.get("seconds_per_frame"))
    return action


def show(scene, action, seconds):
    if seconds:
        scene.render.fps = max(1, round(1 / seconds))
        scene.render.fps_base = scene.render.fps * seconds
    scene.frame_start, scene.frame_end = int(action.frame_start), int(action.frame_end)
    scene.frame_set(1)


def sampled_of(figure, action, skeleton, base):
    """By curve, its values in the action's frames; channels without a curve are left out: they stay as they are.

    base: as in `changes_of`.
    """
    bones, curves, width = bones_of(figure), curves_of(skeleton), len(skeleton["columns"])
    count = len(base) // width
    found = {}
    for index, joint in enumerate(skeleton["bones"]):
        if joint["name"] not in bones:
            raise RepositoryError(f"The figure has no bone {joint['name']} any more. Nothing was sent.")
        bone = bones[joint["name"]]

        def values(path, axis, bone=bone):
            curve = action.fcurves.find(bone.path_from_id(path), index=axis)
            return None if curve is None else [curve.evaluate(frame) for frame in range(1, count + 1)]

        mine = {(curve.path, curve.axis): curve for curve in curves if curve.bone == index}
        near = [
            held(curve, base[curve.column :: width]) if curve else [0.0] * count
            for curve in (mine.get(("rotation_euler", axis)) for axis in range(3))
        ]
        turned = turned_of(bone, order_of(joint), near, values)
        said = {("rotation_euler", axis): turned[axis] for axis in range(3)}
        said |= {(path, axis): values(path, axis) for path in ("location", "scale") for axis in range(3)}
        for (path, axis), samples in said.items():
            if samples is None:
                continue
            if (path, axis) in mine:
                found[mine[path, axis]] = samples
            elif any(abs(value - (path == "scale")) > 1e-5 for value in samples):
                word = {"location": "moved along", "scale": "scaled along", "rotation_euler": "turned about"}[path]
                raise RepositoryError(
                    f"{bone.name} is {word} {AXES[axis]}, for which the document has no channel. Nothing was sent. "
                    "Take these keys away."
                )
    return found


def turned_of(bone, order, near, values):
    """Angles of a bone about x, y, z in the order of its joint, whatever mode its rotation has now; None: as they are.

    near: those that the document has.
    """
    if bone.rotation_mode == order:
        return [values("rotation_euler", axis) for axis in range(3)]
    if bone.rotation_mode == "AXIS_ANGLE":
        raise RepositoryError(f"{bone.name} turns by axis and angle. Set it to quaternions, or Euler {order}.")
    path = "rotation_quaternion" if bone.rotation_mode == "QUATERNION" else "rotation_euler"
    parts = [values(path, part) for part in range(len(getattr(bone, path)))]
    if not any(parts):
        return parts[:3]
    rest = getattr(bone, path)
    parts = [part or [rest[place]] * len(near[0]) for place, part in enumerate(parts)]
    found = []
    for row, angles in zip(zip(*parts, strict=True), zip(*near, strict=True), strict=True):
        quaternion = len(row) == 4
        matrix = matrix_of_quaternion(row) if quaternion else matrix_of_angles(row, bone.rotation_mode)
        found.append(angles_of_matrix(matrix, order, angles))
    return list(zip(*found, strict=True))


def send_action(context, figure, action):
    """Send what was edited; what came of it, in words."""
    server = server_of(context)
    if "mcml_document" not in action:
        raise RepositoryError("This action is from no repository. Import a clip, and edit its action.")
    if action["mcml_server"] != server.address:
        raise RepositoryError(f"This action is from {action['mcml_server']}. Set that server in the preferences.")
    path, first, last = f"documents/{action['mcml_document']}", action["mcml_first"], action["mcml_last"]
    known = server.get(f"{path}/skeleton", revision=action["mcml_revision"])
    if not editable(known):
        raise RepositoryError(
            "Only documents whose joints turn as those of BVH do can be changed from here. Convert the document to BVH "
            "and store that, or import it as a new document from an exported file."
        )
    asked = {"first": first, "last": last}
    base = server.numbers(f"{path}/frames", **asked, revision=known["revision"])
    now = server.get(f"{path}/skeleton")
    # Other revisions of a name, a label or other frames are in nobody's way.
    if now["revision"] != known["revision"]:
        same = now["bones"] == known["bones"] and now["frames"] == known["frames"]
        if not same or struct.pack(f"{len(base)}d", *base) != struct.pack(
            f"{len(base)}d", *server.numbers(f"{path}/frames", **asked, revision=now["revision"])
        ):
            raise RepositoryError(
                f"Somebody changed these frames of {now['name']} since revision {known['revision']}; it is at revision "
                f"{now['revision']} now. {AGAIN}"
            )
    block, count, lacking = changes_of(known, first, base, sampled_of(figure, action, known, base))
    left = f" {lacking} samples that the document does not have were left out." if lacking else ""
    if block is None:
        return f"Nothing was changed in {now['name']}.{left}"
    message = f"edited in Blender: {', '.join(block['columns'][:4])}{' …' if len(block['columns']) > 4 else ''}"
    body = {"frames": [block], "message": message}
    made = server.post(f"{path}/changes", body, If_Match=f'"{now["revision"]}"')
    action["mcml_revision"] = made["revision"]
    return f"{now['name']} is at revision {made['revision']}: {count} samples changed.{left}"


class Asking:
    """Of operators: what goes wrong is told in Blender's way."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            self.report({"INFO"}, self.work(context, context.window_manager.mcml))
        except RepositoryError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class ListDocuments(Asking, bpy.types.Operator):
    """List the documents that have all words of the search"""

    bl_idname = "mcml.list"
    bl_label = "List documents"
    page: EnumProperty(items=[(name, name, "") for name in ("first", "next", "previous")])

    def work(self, context, state):
        trail = json.loads(state.trail) if self.page != "first" else [""]
        if self.page == "next" and state.following:
            trail.append(state.following)
        if self.page == "previous" and len(trail) > 1:
            trail.pop()
        found = server_of(context).get("documents", q=state.search, limit=PAGE, cursor=trail[-1])
        state.trail, state.following = json.dumps(trail), found.get("next_cursor") or ""
        state.documents.clear()
        for item in found["items"]:
            row = state.documents.add()
            row.name, row.document, row.last = item["name"], item["id"], item["frames"]
            row.shown = f"{item['frames']} · {item['duration']:.1f} s" if item.get("duration") else str(item["frames"])
        state.chosen = 0
        start = (len(trail) - 1) * PAGE
        state.place = f"{min(start + 1, found['total'])}-{start + len(found['items'])} of {found['total']}"
        return f"{found['total']} documents"


class ListRuns(Asking, bpy.types.Operator):
    """List the runs of frames that the XPath expression selects"""

    bl_idname = "mcml.list_runs"
    bl_label = "Ask"

    def work(self, context, state):
        state.runs.clear()
        body = {"q": state.xpath, "as": "runs", "limit": PAGE}
        found = server_of(context).post("xpath", body)
        for item in found["items"]:
            row = state.runs.add()
            row.name, row.document, row.revision = item["name"], item["document"], item["revision"]
            row.first, row.last = item["first"], item["last"]
            row.shown = f"{row.first}-{row.last}"
        more = f"; the first {PAGE} are listed" if found.get("next_cursor") else ""
        return f"{len(state.runs)} runs{more}"


class ImportClip(Asking, bpy.types.Operator):
    """Import the chosen document as an action, and an armature if there is none of its skeleton"""

    bl_idname = "mcml.import_clip"
    bl_label = "Import clip"

    def work(self, context, state):
        if not 0 <= state.chosen < len(state.documents):
            raise RepositoryError("List documents and choose one.")
        action = import_action(context, server_of(context), state.documents[state.chosen].document)
        return f"{action.name}: {int(action.frame_end)} frames"


class ImportRuns(Asking, bpy.types.Operator):
    """Import all runs that are listed, each as an action"""

    bl_idname = "mcml.import_runs"
    bl_label = "Import runs as actions"

    def work(self, context, state):
        if not len(state.runs):
            raise RepositoryError("Ask for runs of frames before.")
        for row in state.runs:
            import_action(context, server_of(context), row.document, row.first, row.last, row.revision)
        return f"{len(state.runs)} actions"


class SendAction(Asking, bpy.types.Operator):
    """Send what was edited in the active armature's action to its document, as a revision"""

    bl_idname = "mcml.send"
    bl_label = "Send action back"

    def work(self, context, state):
        figure = context.object
        if figure is None or figure.type != "ARMATURE" or not (figure.animation_data and figure.animation_data.action):
            raise RepositoryError("Choose an armature with an action.")
        return send_action(context, figure, figure.animation_data.action)


class Row(bpy.types.PropertyGroup):
    document: StringProperty()
    revision: IntProperty()
    first: IntProperty(default=1)
    last: IntProperty()
    shown: StringProperty()


class State(bpy.types.PropertyGroup):
    search: StringProperty(name="Search", description="Words; each occurs in a name, a label or a property")
    xpath: StringProperty(name="XPath", default="//frame[motion_name='walk']")
    documents: CollectionProperty(type=Row)
    chosen: IntProperty()
    runs: CollectionProperty(type=Row)
    chosen_run: IntProperty()
    trail: StringProperty(default='[""]')
    following: StringProperty()
    place: StringProperty()


class Rows(bpy.types.UIList):
    bl_idname = "MCML_UL_rows"

    def draw_item(self, _context, layout, _data, item, _icon, _active, _property):
        split = layout.split(factor=0.6)
        split.label(text=item.name)
        split.label(text=item.shown)


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    server: StringProperty(name="Server", default="http://127.0.0.1:8000")
    token: StringProperty(name="Token", subtype="PASSWORD", description="What `mcml token add` printed")

    def draw(self, _context):
        self.layout.prop(self, "server")
        self.layout.prop(self, "token")


class RepositoryPanel(bpy.types.Panel):
    bl_idname = "MCML_PT_repository"
    bl_label = "MCML Repository"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "MCML"

    def draw(self, context):
        state, layout = context.window_manager.mcml, self.layout
        for name in ("server", "token"):
            layout.prop(preferences(context), name)
        row = layout.row(align=True)
        row.prop(state, "search", text="", icon="VIEWZOOM")
        row.operator("mcml.list", text="List").page = "first"
        layout.template_list("MCML_UL_rows", "documents", state, "documents", state, "chosen")
        row = layout.row(align=True)
        row.operator("mcml.list", text="", icon="TRIA_LEFT").page = "previous"
        row.operator("mcml.list", text="", icon="TRIA_RIGHT").page = "next"
        row.label(text=state.place)
        layout.operator("mcml.import_clip", icon="IMPORT")
        layout.separator()
        row = layout.row(align=True)
        row.prop(state, "xpath", text="")
        row.operator("mcml.list_runs")
        layout.template_list("MCML_UL_rows", "runs", state, "runs", state, "chosen_run")
        layout.operator("mcml.import_runs", icon="IMPORT")
        layout.separator()
        layout.operator("mcml.send", icon="EXPORT")


CLASSES = (
    Row,
    State,
    Rows,
    Preferences,
    ListDocuments,
    ListRuns,
    ImportClip,
    ImportRuns,
    SendAction,
    RepositoryPanel,
)


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)
    bpy.types.WindowManager.mcml = PointerProperty(type=State)


def unregister():
    del bpy.types.WindowManager.mcml
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
