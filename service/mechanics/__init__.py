"""Mechanics of machines that shake, turn or carry: arrays in, frozen dataclasses out; no I/O, clock or random state.

SI units, angles in rad, anticlockwise positive; vectors in the plane are complex numbers x + i y.

============ =====================================================================
chain        a planar linkage of dyads as data, and its layout
kinematics   its motion over a turn of the crank; where it closes
dynamics     shaking force, shaking moment and torque, linear in the masses
reactions    forces in the joints
bodies       mass numbers of links, three-point models, disc counterweights
refusals     what cannot be computed, each with a code
============ =====================================================================
"""
