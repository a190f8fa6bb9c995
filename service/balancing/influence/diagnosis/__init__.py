"""Diagnosis of runs, sensors and planes.

======== ==================================================================
findings the type of a finding, and what is known besides the vectors
misfit   how badly each run fits the rest
readings sensors: silent, stuck, unsteady, speed drift, is it unbalance
runs     runs that contradict the others, flipped senses, missed prediction
planes   trial response, dependent planes, planes that buck, noise
======== ==================================================================
"""
