"""Optimisation: problems, searches as iterators with one contract, fronts and evidence. Arrays only.

====================== ==============================================================
problem                mixed variables for searches that use values alone
smooth                 smooth problems with slopes
search                 the contract of every search and the loop that bounds it
sqp                    sequential quadratic programming from many starts: the default
kkt                    residuals of the optimality conditions, proved bounds, polish
epsilon                fronts of two smooth objectives
front                  ranks, crowding distance, hypervolume
population             Deb's order, for the published searches below
jaya                   modified Jaya, published and improved
differential_evolution five variants
differential_search    Differential Search of 2013
evolving_front         what the two searches for fronts share
nsjaya, nsga2          searches for fronts
====================== ==============================================================
"""
