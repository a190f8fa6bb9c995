"""Numerics of balancing: arrays in, frozen dataclasses out; no I/O, clock, logging or global random state.

One complex convention throughout: a vector is magnitude * exp(1j * angle), angles in radians, masses counted
against the rotation and phases as lag, so that v = v0 + A u holds (`phasors` mirrors whatever is stated otherwise).
Masses in g, unbalance in g.mm, velocities as the sensor states them.

=============== =================================================================
phasors         degrees and senses at the edge <-> complex numbers inside
units           quantities, units and detections, and the turn of phase between
labels          names of runs, planes and sensors in messages
intervals       confidence interval of an amplitude
fit             influence coefficients and as-found vibration from runs
speed_scatter   scatter between runs that turn at different speeds
corrections     continuous correction masses from a fit
minimax         smallest greatest residual, limits of mass, certified
static_couple   static and couple parts, and fits in modes
uncertainty     ellipses, inexact placement, intervals
amplitude_only  influence without phase, every solution of it
saved_influence coefficients of earlier sessions, learning, statistics
trim            what to change on the rotor, many pieces as few
trial_mass      size, angle and force of the first trial mass
tolerance       permissible unbalance, grade reached, vibration zones
diagnosis       what is wrong with runs, sensors or planes
analysis        fit, correction and findings in one call
rotor           reactions of a rigid rotor on two bearings
selection       the discrete problem: which stock masses in which positions
checks          what a selection problem must satisfy
objectives      the norms that a selection is rated by
placements      vector sums and limits of a selection
exhaustive      every selection of a small problem, tried
jaya            modified Jaya on the selection problem
certified       modified Jaya, then the exact search
descent         single changes that make a selection better
exact           the best selection and the proof, level by level
alternatives    the next best, fewer pieces, the fewest within a limit
fitted          pieces that are on the rotor already
infeasible      why no selection meets a limit
record          the best selections so far, and how equals are told apart
opened          the problem without planes that take nothing
reach           how far a plane's masses can reach
bounds          the continuous optimum, a lower bound
region          where every better selection must lie
first_level     how high the exact search begins
neighbours      pairs of near points in the plane
sums            vector sums of one plane near a point
joint           lists of single planes combined under the shared box
=============== =================================================================
"""
