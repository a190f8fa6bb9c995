"""Mechanics of machines that shake, turn or carry: arrays in, frozen dataclasses out; no I/O, clock or random state.

SI units, angles in rad, anticlockwise positive; vectors in the plane are complex numbers x + i y.

============= =====================================================================
chain         a planar linkage of dyads as data, and its layout
kinematics    its motion over a turn of the crank; where it closes
dynamics      shaking force, shaking moment and torque, linear in the masses
reactions     forces in the joints
bodies        mass numbers of links, three-point models, disc counterweights
rotating_disc stresses, mass and energy of a disc whose thickness is a spline
spline        clamped cubic curves
gears         a helical gear pair, sound and as printed
shaft_set     three aims of balancing in several planes, weighed by fuzzy goals
refusals      what cannot be computed, each with a code
============= =====================================================================
"""
