"""Diagnosis of runs, sensors and planes.

============= ==================================================================
findings      the type of a finding, and what is known besides the vectors
misfit        how badly each run fits the rest
readings      sensors: silent, stuck, unsteady, speed drift, is it unbalance
runs          runs that contradict the others, flipped senses, missed prediction
single_faults slips and wrong readings that a session may hold, each undone
free_values   the same where an angle or a size is not known
suspects      every single fault weighed: which run is wrong, or which may be
blame         what is said of it
planes        trial response, dependent planes, planes that buck, noise
============= ==================================================================
"""
