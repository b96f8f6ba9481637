"""The curves of a gait report: those of the file's own model, in order, else those of joints."""

from __future__ import annotations

from mcml.laboratory.report_curves import choose_curves
from mcml.motion.bodies.limb_angles import angle_names


def test_quantities_of_both_sides_are_chosen_in_the_order_of_reports() -> None:
    labels = ["Anna:RKneeAngles", "Anna:LKneeAngles", "Anna:LHipAngles", "Anna:RHipAngles", "LAnkleAngles", "LHipPower"]
    curves = choose_curves(labels, angle_names())
    assert [curve.title for curve in curves] == [
        "Hip flexion", "Hip adduction", "Hip rotation", "Knee flexion", "Knee varus", "Knee rotation"
    ]  # fmt: skip
    assert curves[3].quantities == {"left": "quantity:Anna:LKneeAngles,x", "right": "quantity:Anna:RKneeAngles,x"}
    assert (curves[3].positive, curves[3].negative) == ("flexion", "extension")


def test_bodies_without_them_show_angles_of_joints() -> None:
    curves = choose_curves(["LKneeAngles"], angle_names())
    assert {"left": "angle:left-knee-flexion", "right": "angle:right-knee-flexion"} in [c.quantities for c in curves]
    assert choose_curves([], []) == ()
