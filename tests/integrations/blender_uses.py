"""Run by Blender: uses the add-on as somebody would. Argument: the number of the file that is answered to.

A line of the input is JSON with `addon` and `steps`; its answer is a line with the list of what each step answered. A
step is [name, argument, …]. What operators refuse is their words.
"""

import json
import os
import sys
import urllib.request
from unittest.mock import MagicMock

import bpy


def told(call, **given):
    try:
        return sorted(call(**given))[0]
    except RuntimeError as error:
        return str(error).strip()


def set_server(address, token):
    preferences = bpy.context.preferences.addons["mcml_repository"].preferences
    preferences.server, preferences.token = address, token


def list_documents(search="", page="first"):
    state = bpy.context.window_manager.mcml
    state.search = search
    said = told(bpy.ops.mcml.list, page=page)
    return {"said": said, "names": [row.name for row in state.documents], "place": state.place}


def import_clip(index):
    bpy.context.window_manager.mcml.chosen = index
    return told(bpy.ops.mcml.import_clip)


def import_listed_runs():
    return told(bpy.ops.mcml.import_runs)


def import_runs(expression):
    state = bpy.context.window_manager.mcml
    state.xpath = expression
    listed = told(bpy.ops.mcml.list_runs)
    runs = [[row.name, row.first, row.last] for row in state.runs]
    said = told(bpy.ops.mcml.import_runs) if listed == "FINISHED" else ""
    return {"listed": listed, "runs": runs, "said": said}


def actions():
    """First and last frame, and the keys of every curve."""
    return {
        action.name: [action.frame_start, action.frame_end, *{len(curve.keyframe_points) for curve in action.fcurves}]
        for action in bpy.data.actions
    }


def figures():
    return [item.name for item in bpy.data.objects if item.type == "ARMATURE"]


def use_action(name):
    bpy.context.object.animation_data.action = bpy.data.actions[name]


def positions():
    """By bone, where it is in the world in every frame."""
    figure, scene = bpy.context.object, bpy.context.scene
    found = {bone.name: [] for bone in figure.pose.bones}
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        for bone in figure.pose.bones:
            found[bone.name].append(list(figure.matrix_world @ bone.head))
    return found


def rate():
    return bpy.context.scene.render.fps / bpy.context.scene.render.fps_base


def edit(bone, path, axis, frames, add):
    """Move keys of a curve."""
    figure = bpy.context.object
    target = figure.pose.bones[bone].path_from_id(path)
    curve = figure.animation_data.action.fcurves.find(target, index=axis)
    for key in curve.keyframe_points:
        if round(key.co.x) in frames:
            key.co.y += add
    curve.update()


def edit_nth(number, *more):
    """The same of a bone by its place, whatever it is called here."""
    edit(bpy.context.object.pose.bones[number].name, *more)


def key(bone, path, axis, frame, value):
    """A key of a curve that may be new."""
    figure = bpy.context.object
    target = figure.pose.bones[bone].path_from_id(path)
    curves = figure.animation_data.action.fcurves
    curve = curves.find(target, index=axis) or curves.new(target, index=axis)
    curve.keyframe_points.insert(frame, value)


def to_mode(bone, mode):
    """Another rotation mode: the same rotations, keyed anew, but a quarter of a turn about X in frame 2."""
    posed, scene = bpy.context.object.pose.bones[bone], bpy.context.scene
    rows = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        rows.append(posed.matrix_basis.to_quaternion())
    rows[1] = type(rows[1])((2**-0.5, 2**-0.5, 0, 0))
    delete_curves(bone)
    posed.rotation_mode = mode
    path = "rotation_quaternion" if mode == "QUATERNION" else "rotation_euler"
    for frame, value in enumerate(rows, start=1):
        for part, number in enumerate(value if mode == "QUATERNION" else value.to_euler(mode)):
            key(bone, path, part, frame, number)


def draw():
    """The operators and the properties that the panel and the preferences show."""
    import mcml_repository

    state, layout = bpy.context.window_manager.mcml, MagicMock()
    mcml_repository.RepositoryPanel.draw(MagicMock(layout=layout), bpy.context)
    mcml_repository.Preferences.draw(MagicMock(layout=layout), bpy.context)
    for row in state.documents:
        mcml_repository.Rows.draw_item(None, bpy.context, layout, state, row, 0, state, "chosen")
    calls = [(name.rpartition(".")[2], given) for name, given, _ in layout.mock_calls]
    operators = [given[0].partition(".")[2] for name, given in calls if name == "operator"]
    known = [name for name in operators if name in dir(bpy.ops.mcml)]
    lists = [len(getattr(given[2], given[3])) for name, given in calls if name == "template_list"]
    shown = [given[1] for name, given in calls if name == "prop"]
    texts = [given["text"] for name, _, given in layout.mock_calls if name.endswith("label")]
    return {"operators": operators, "known": known, "lists": lists, "shown": shown, "texts": texts}


def rename(bone, name):
    bpy.context.object.pose.bones[bone].name = name


def delete_curves(bone):
    action = bpy.context.object.animation_data.action
    for curve in [curve for curve in action.fcurves if f'["{bone}"]' in curve.data_path]:
        action.fcurves.remove(curve)


def send():
    return told(bpy.ops.mcml.send)


def revision():
    return bpy.context.object.animation_data.action["mcml_revision"]


def request(method, address, body, headers):
    """What somebody else does meanwhile."""
    asked = urllib.request.Request(address, json.dumps(body).encode(), headers, method=method)
    with urllib.request.urlopen(asked) as answer:
        return answer.status


with os.fdopen(int(sys.argv[-1]), "w", buffering=1) as answers:
    for line in sys.stdin:
        asked = json.loads(line)
        bpy.ops.wm.read_factory_settings()
        bpy.ops.preferences.addon_install(filepath=asked["addon"])
        bpy.ops.preferences.addon_enable(module="mcml_repository")
        done = [globals()[name](*arguments) for name, *arguments in asked["steps"]]
        bpy.ops.preferences.addon_disable(module="mcml_repository")
        print(json.dumps(done), file=answers)
